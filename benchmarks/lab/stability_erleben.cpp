// The ten scenes of Erleben 2018 ("Methodology for Assessing Mesh-Based Contact Point Methods", ACM
// TOG 37), rebuilt from their dimensions: spike 1x1x3, wedge 1x2x3, crack 2x1x4 with a notch 0.5
// deep, cliff frustum 1.5 to 1.0 of height 1, internal-edge box 2x1x2 (meters). Each is hard for
// methods that derive contact points from meshes: sharp tips, edges on edges, narrow gaps, aligned
// edges, internal edges. What the paper leaves open (gaps, friction) is chosen so that mechanics
// gives the final state.
#include <algorithm>
#include <cmath>

#include "lab/lab_meshes.h"
#include "lab/trial_runs.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kVoxel = 0.05;       // [m]
constexpr double kFineVoxel = 0.025;  // for scenes with a gap of 0.15
constexpr double kGap = 0.01;         // initial gap between bodies [m]
constexpr double kMass = 1000;        // of every moving body [kg]
constexpr double kFriction = 0.5;     // where nothing should slide
constexpr double kHigh = 3;           // of a spike or a wedge [m]
constexpr double kSag = 0.1 * kVoxel;
// Angle of a spike's or wedge's flank from the vertical.
const double kFlank = std::atan(0.5 / kHigh);

std::shared_ptr<const Mesh> shared(Mesh mesh) {
  return std::make_shared<const Mesh>(std::move(mesh));
}
Mesh spike() {
  return taperedMesh({1, 1}, {0, 0}, kHigh);
}
Mesh wedge() {
  return taperedMesh({1, 2}, {0, 2}, kHigh);
}
Mesh cliff() {
  return taperedMesh({1.5, 1.5}, {1, 1}, 1);
}
// A slab 4 long, 2 wide, 1 high, with a notch across its middle a little narrower than the tip that
// enters it.
constexpr double kMouth = 0.15, kNotch = 0.5;
Mesh crack() {
  return prismMesh(
      {{0, 1 - kNotch}, {-kMouth / 2, 1}, {-2, 1}, {-2, 0}, {2, 0}, {2, 1}, {kMouth / 2, 1}}, 2);
}
// A square block over 0 <= z <= height with a square through hole along z.
Mesh squareHole(double width, double hole, double height) {
  Mesh mesh;
  for (const double z : {0.0, height})
    for (const double half : {width / 2, hole / 2})
      for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
        mesh.vertices.emplace_back(x * half, y * half, z);
  const auto side = [&mesh](int a, int b, int c, int d) {
    mesh.triangles.emplace_back(a, b, c);
    mesh.triangles.emplace_back(a, c, d);
  };
  for (int k = 0; k < 4; ++k) {
    const int n = (k + 1) % 4;
    side(k, n, n + 8, k + 8);            // outside
    side(n + 4, k + 4, k + 12, n + 12);  // hole
    side(k, k + 4, n + 4, n);            // bottom
    side(k + 8, n + 8, n + 12, k + 12);  // top
  }
  return mesh;
}

const Eigen::Quaterniond kUpright = Eigen::Quaterniond::Identity();
const Eigen::Quaterniond kUpsideDown(Eigen::AngleAxisd(EIGEN_PI, Vec3::UnitX()));
const Eigen::Quaterniond kQuarter(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitZ()));
// A spike or wedge lying on its flank, tip toward +x.
const Eigen::Quaterniond kLying(Eigen::AngleAxisd(EIGEN_PI / 2 + kFlank, Vec3::UnitY()));
// Position just above z = kHigh, with the center of mass, `middle` above the base, over the origin.
Vec3 lyingAbove(double middle) {
  return {-(kLying * Vec3(0, 0, middle)).x(), 0, kHigh + 0.5 * std::cos(kFlank) + kGap};
}

SceneBody fixedBody(const std::string& kind, const Mesh& mesh, const Pose& pose,
                    double friction = kFriction) {
  return meshBody(kind, shared(mesh), pose, 0, friction);
}
SceneBody movingBody(const std::string& kind, const Mesh& mesh, const Pose& pose,
                     double friction = kFriction) {
  return meshBody(kind, shared(mesh), pose, kMass, friction);
}

// A wedge on its edge falls over slowly: from rest its lean grows as cosh(t / tau) with tau =
// sqrt(I / (m g l)), I about the edge. A method may push the tip sideways by half a voxel; the
// limit is that lean after growing.
double wedgeLean(double seconds) {
  // Inertia / mass about the edge: h^2 / 18 + a^2 / 24 for a triangular prism, plus its lever's.
  const double lever = 2 * kHigh / 3;
  const double inertia = kHigh * kHigh / 18 + 1.0 / 24 + lever * lever;
  const double tau = std::sqrt(inertia / (kGravity * lever));
  return turnLimit(kVoxel, lever) * std::cosh(seconds / tau);
}

Plan planOf(std::vector<SceneBody> bodies, double seconds) {
  Plan plan;
  plan.scene.bodies = std::move(bodies);
  plan.voxel = kVoxel;
  plan.seconds = seconds;
  plan.spring = springFor(kMass, kMass, kSag);
  plan.instants = 100;
  return plan;
}

// Rules of all scenes: no penetration, no energy gained.
std::vector<Rule> with(const RunResult& result, std::vector<Rule> more) {
  more.insert(more.begin(), {penetrationRule(result), energyRule(result)});
  return more;
}
// The body ends where it started, lower by the gap.
void staysPut(std::vector<Rule>& rules, const RunResult& result, int body, double lever) {
  const Vec3 place = result.scene.bodies[body].pose.position - Vec3(0, 0, kGap);
  rules.push_back({result.moved(body, place), kInPlace, "moved [voxels]"});
  rules.push_back({result.turned(body), turnLimit(kVoxel, lever), "turned [deg]"});
}

// Two spikes tip on tip: the upper one may fall, but not into the other.
Verdict spikes(const Trial& trial) {
  return judged(trial,
                planOf({fixedBody("spike", spike(), Pose()),
                        movingBody("spike", spike(), {kUpsideDown, Vec3(0, 0, 2 * kHigh + kGap)})},
                       1),
                [](const RunResult& result) { return with(result, {}); });
}

// A wedge stands on its base across the edges of two. Beside it one balances its edge across the
// edge of another.
Verdict wedges(const Trial& trial) {
  std::vector<SceneBody> bodies;
  for (const double x : {-0.5, 0.5})
    bodies.push_back(fixedBody("wedge", wedge(), {kUpright, Vec3(x, 0, 0)}));
  bodies.push_back(movingBody("wedge", wedge(), {kQuarter, Vec3(0, 0, kHigh + kGap)}));
  bodies.push_back(fixedBody("wedge", wedge(), {kUpright, Vec3(5, 0, 0)}));
  bodies.push_back(
      movingBody("wedge", wedge(), {kQuarter * kUpsideDown, Vec3(5, 0, 2 * kHigh + kGap)}));
  return judged(trial, planOf(bodies, 1), [](const RunResult& result) {
    std::vector<Rule> rules{{result.turned(4), wedgeLean(1), "lean of the balanced one [deg]"}};
    staysPut(rules, result, 2, 0.5);
    return with(result, rules);
  });
}

// A spike lies on its flank across the edges of two wedges. Beside it one balances its tip on a
// wedge's edge and may fall.
Verdict spikeAndWedge(const Trial& trial) {
  std::vector<SceneBody> bodies;
  for (const double x : {-0.5, 0.5})
    bodies.push_back(fixedBody("wedge", wedge(), {kUpright, Vec3(x, 0, 0)}));
  bodies.push_back(movingBody("spike", spike(), {kLying, lyingAbove(kHigh / 4)}));
  bodies.push_back(fixedBody("wedge", wedge(), {kUpright, Vec3(5, 0, 0)}));
  bodies.push_back(movingBody("spike", spike(), {kUpsideDown, Vec3(5, 0, 2 * kHigh + kGap)}));
  return judged(trial, planOf(bodies, 1), [](const RunResult& result) {
    std::vector<Rule> rules;
    staysPut(rules, result, 2, 0.5);
    return with(result, rules);
  });
}

// Not in Erleben's paper, and harder: a spike stands or a wedge lies on the tips of four spikes.
// The last three voxels of each tip are thinner than a voxel.
Verdict onTips(const Trial& trial, const SceneBody& body, double apart) {
  std::vector<SceneBody> bodies;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    bodies.push_back(fixedBody("spike", spike(), {kUpright, Vec3(x, y, 0) * apart / 2}));
  bodies.push_back(body);
  return judged(trial, planOf(bodies, 1), [&](const RunResult& result) {
    std::vector<Rule> rules;
    staysPut(rules, result, 4, apart / 2);
    return with(result, rules);
  });
}
Verdict spikeOnTips(const Trial& trial) {
  return onTips(trial, movingBody("spike", spike(), {kUpright, Vec3(0, 0, kHigh + kGap)}), 0.7);
}
Verdict wedgeOnTips(const Trial& trial) {
  return onTips(trial, movingBody("wedge", wedge(), {kLying, lyingAbove(kHigh / 3)}), 1);
}

// Slides on its flank, tip first, down a slope of 0.5 at friction 0.3: a = g (sin - mu cos).
Verdict sliding(const Trial& trial, const std::string& kind, const Mesh& mesh) {
  constexpr double kLowFriction = 0.3;
  const double slope = std::atan(0.5), low = 0.5 * std::cos(kFlank);
  Plan plan = planOf({fixedBody("slab", taperedMesh({6, 3}, {6, 3}, 0.5),
                                {kUpright, Vec3(1, 0, -0.5)}, kLowFriction),
                      movingBody(kind, mesh, {kLying, Vec3(-1.5, 0, low)}, kLowFriction)},
                     1);
  plan.scene.gravity = kGravity * Vec3(std::sin(slope), 0, -std::cos(slope));
  return judged(trial, plan, [&](const RunResult& result) {
    const double a = kGravity * (std::sin(slope) - kLowFriction * std::cos(slope));
    const int n = result.report.steps;
    const double way = a * result.report.step * result.report.step * n * (n + 1) / 2;
    const Vec3 end = result.scene.bodies[1].pose.position + Vec3(way, 0, 0);
    return with(result, {{result.moved(1, end), kInPlace, "off its path [voxels]"},
                         {result.turned(1), turnLimit(kVoxel, 0.5), "turned [deg]"}});
  });
}

// Height of the base of a spike or wedge that hangs tip down by its flanks between edges `mouth`
// apart, 1 above the ground. Half a voxel into the flanks lowers it by three voxels.
double held(double mouth) {
  return 1 + kHigh - kHigh * mouth;
}
std::vector<Rule> heldAt(const RunResult& result, double mouth) {
  const double sunk = std::abs(held(mouth) - result.report.bodies[1].pose.position.z());
  return {{sunk * std::sin(kFlank) / result.voxel, kInPlace, "sunk, normal to the flank [voxels]"},
          {result.aside(1), kInPlace, "sideways [voxels]"},
          {result.turned(1), turnLimit(result.voxel, mouth / 2), "turned [deg]"}};
}

// Tip down in a square hole of 0.5, whose four rims hold it half way up.
Verdict spikeInHole(const Trial& trial) {
  constexpr double kHole = 0.5;
  const Plan plan =
      planOf({fixedBody("hole", squareHole(2, kHole, 1), Pose()),
              movingBody("spike", spike(), {kUpsideDown, Vec3(0, 0, held(kHole) + kGap)})},
             2);
  return judged(trial, plan,
                [](const RunResult& result) { return with(result, heldAt(result, kHole)); });
}

// Tip or edge down in the notch, whose mouth holds both flanks. Below the mouth a gap of half a
// degree remains to the walls, and 0.05 to the bottom.
Verdict inCrack(const Trial& trial, const std::string& kind, const Mesh& mesh) {
  Plan plan = planOf({fixedBody("crack", crack(), Pose()),
                      movingBody(kind, mesh, {kUpsideDown, Vec3(0, 0, held(kMouth) + kGap)})},
                     1);
  plan.voxel = kFineVoxel;
  plan.spring = springFor(kMass, kMass, 0.1 * kFineVoxel);
  return judged(trial, plan,
                [](const RunResult& result) { return with(result, heldAt(result, kMouth)); });
}

// Two frusta, top on top, with all edges of the tops aligned.
Verdict cliffEdges(const Trial& trial) {
  return judged(trial,
                planOf({fixedBody("cliff", cliff(), Pose()),
                        movingBody("cliff", cliff(), {kUpsideDown, Vec3(0, 0, 2 + kGap)})},
                       2),
                [](const RunResult& result) {
                  std::vector<Rule> rules;
                  staysPut(rules, result, 1, 0.5);
                  return with(result, rules);
                });
}

// A box slides at 3 m/s over three adjacent boxes, one mesh that still contains their inner walls,
// and stops after v^2 / (2 mu g). The internal edges must not catch it.
Verdict internalEdges(const Trial& trial) {
  constexpr double kLowFriction = 0.3, kSpeed = 3;
  const Mesh box = taperedMesh({2, 2}, {2, 2}, 1);
  Mesh row;
  for (const double x : {-2, 0, 2}) {
    const auto first = static_cast<int>(row.vertices.size());
    for (const Vec3& v : box.vertices) row.vertices.push_back(v + Vec3(x, 0, -1));
    for (const Eigen::Vector3i& t : box.triangles)
      row.triangles.push_back(t + Eigen::Vector3i::Constant(first));
  }
  const Vec3 start(-1.3, 0, 0);
  std::vector<SceneBody> bodies{fixedBody("row", row, Pose(), kLowFriction),
                                movingBody("box", box, {kUpright, start}, kLowFriction)};
  bodies.back().linearVelocity.x() = kSpeed;
  return judged(trial, planOf(bodies, 1.5), [&](const RunResult& result) {
    // Each step reduces the speed by mu g h before it moves: v h / 2 less distance in total.
    const double way =
        kSpeed * kSpeed / (2 * kLowFriction * kGravity) - kSpeed * result.report.step / 2;
    return with(result, {{result.moved(1, start + Vec3(way, 0, 0)), kInPlace,
                          "off its stopping place [voxels]"},
                         {result.turned(1), turnLimit(kVoxel, 1), "turned [deg]"}});
  });
}

StabilityScene scene(const std::string& name, const std::string& end, double cost,
                     std::function<Verdict(const Trial&)> run) {
  return {name,
          "Erleben",
          "penetration [voxels]; " + end + "; no energy gained",
          {Method::Cloud, Method::Paper, Method::Gimpact, Method::Hacd, Method::Gjk},
          {0.01, 1.0 / 60, 1.0 / 240, 1.0 / 1000},
          {"stiff", "auto"},
          cost,
          std::move(run)};
}

}  // namespace

std::vector<StabilityScene> erlebenScenes() {
  return {
      scene("spikes", "the upper spike falls aside or balances", 1, spikes),
      scene("wedges", "one stays on two edges, one balances edge on edge", 1, wedges),
      scene("spike and wedge", "the spike on two edges stays", 1, spikeAndWedge),
      scene("sliding spike", "slides by g (sin - mu cos) t^2 / 2", 1,
            [](const Trial& trial) { return sliding(trial, "spike", spike()); }),
      scene("sliding wedge", "slides by g (sin - mu cos) t^2 / 2", 1,
            [](const Trial& trial) { return sliding(trial, "wedge", wedge()); }),
      scene("spike in hole", "the rims hold the spike half way up", 1, spikeInHole),
      scene("spike in crack", "the mouth holds the spike", 1,
            [](const Trial& trial) { return inCrack(trial, "spike", spike()); }),
      scene("wedge in crack", "the mouth holds the wedge", 1,
            [](const Trial& trial) { return inCrack(trial, "wedge", wedge()); }),
      scene("cliff edges", "the upper frustum stays", 1, cliffEdges),
      scene("internal edges", "the box stops after v^2 / (2 mu g)", 1, internalEdges),
      scene("spike on tips", "the spike stays", 1, spikeOnTips),
      scene("wedge on tips", "the wedge stays", 1, wedgeOnTips),
  };
}

}  // namespace cloudcontact::program::lab
