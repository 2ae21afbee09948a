// The contact cases: solids, their poses, and the true contact.
//
// In the frame of a case, A's touched surface is the plane z = 0, or A's highest point or edge is
// at z = 0. B comes from above with its lowest point at z = -depth. The true normal is +z. The true
// center is that of the overlap's volume: the center of a pressure proportional to depth. Lengths
// in the builders' arguments are voxels.
#include "contact/contact_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <ostream>
#include <stdexcept>

namespace cloudcontact::testing {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
// Bounds of the contact tests.
constexpr Bounds kSmooth{0.5, 0.1, 0.5, 0.03};
constexpr Bounds kEdge{1.0, 0.3, kInfinite, kInfinite};
constexpr Bounds kCrossed{4.0, kInfinite, kInfinite, kInfinite};
constexpr Bounds kOverhang{1.5, kInfinite, kInfinite, kInfinite};
// No bounds: for contact_table only.
constexpr Bounds kWatched{kInfinite, kInfinite, kInfinite, kInfinite};

const std::vector<double> kPressed{0.3, 0.6, 1.0};
const Vec3 kSlab(44, 42, 10);

using Quaternion = Eigen::Quaterniond;

Pose at(double x, double y, double z, const Quaternion& turn = Quaternion::Identity()) {
  return {turn, {x, y, z}};
}

Truth pressed(double depth, double volume, double x = 0, double y = 0) {
  return {Vec3::UnitZ(), depth, {x, y, -depth / 2}, volume};
}

double capVolume(double radius, double depth) {
  return std::numbers::pi * depth * depth * (radius - depth / 3);
}

// Area of the part of a disc beyond a chord at `depth` from its edge.
double segmentArea(double radius, double depth) {
  const double chord = radius - depth;
  return radius * radius * std::acos(chord / radius) -
         chord * std::sqrt(depth * (2 * radius - depth));
}

// The body that B is pressed into.
enum class Ground { HalfSpace, Slab, AlignedSlab };

Body groundBody(BodyMaker& make, Ground ground) {
  if (ground == Ground::HalfSpace) return BodyMaker::shape(HalfSpace{});
  return make.box(kSlab, ground == Ground::AlignedSlab);
}

Pose groundPose(Ground ground, double voxel) {
  return ground == Ground::HalfSpace ? Pose{} : at(0, 0, -kSlab.z() / 2 * voxel);
}

using VolumeAt = std::function<double(double depth)>;

// A body turned by `turn`, then about z at random. Its lowest point is then `below` [voxels] under
// its origin, and so is the overlap's center.
Instance onGround(BodyMaker& make, Ground ground, Body body, double below, VolumeAt volume,
                  const Quaternion& turn = Quaternion::Identity()) {
  const double h = make.voxel;
  const Quaternion turned = make.random.yaw() * turn;
  Instance instance{groundBody(make, ground), std::move(body), {}};
  instance.place = [=](double depth) {
    return Placed{groundPose(ground, h), at(0, 0, below * h - depth, turned),
                  pressed(depth, volume(depth))};
  };
  return instance;
}

Instance sphereOn(BodyMaker& make, Ground ground, Body body, double radius) {
  const double r = radius * make.voxel;
  return onGround(make, ground, std::move(body), radius,
                  [r](double depth) { return capVolume(r, depth); });
}

Instance faceOn(BodyMaker& make, Ground ground, Body body, const Vec3& edges) {
  const double area = edges.x() * edges.y() * make.voxel * make.voxel;
  return onGround(make, ground, std::move(body), edges.z() / 2,
                  [area](double depth) { return area * depth; });
}

const Quaternion kAxisAlongX(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()));
constexpr double kCylinderLength = 28;

Instance cylinderOn(BodyMaker& make, Ground ground, Body body, double radius) {
  const double r = radius * make.voxel, length = kCylinderLength * make.voxel;
  return onGround(
      make, ground, std::move(body), radius,
      [=](double depth) { return length * segmentArea(r, depth); }, kAxisAlongX);
}

// A long cylinder across a narrow bar, their centers 2 voxels apart.
Instance cylinderAcross(BodyMaker& make, double radius) {
  const double h = make.voxel;
  const Vec3 bar(24, 40, 10);
  Instance instance{make.box(bar), make.cylinder(radius, 40), {}};
  instance.place = [=](double depth) {
    return Placed{at(2 * h, 0, -5 * h), at(0, 0, radius * h - depth, kAxisAlongX),
                  pressed(depth, bar.x() * h * segmentArea(radius * h, depth), 2 * h)};
  };
  return instance;
}

Instance sphereOnSphere(BodyMaker& make, double lower, double upper) {
  const double h = make.voxel;
  Instance instance{make.sphere(lower), make.sphere(upper), {}};
  instance.place = [=](double depth) {
    return Placed{at(0, 0, -lower * h), at(0, 0, upper * h - depth), pressed(depth, 0)};
  };
  return instance;
}

const Vec3 kFaced(24.3, 31.6, 18.4);  // edges of the box that touches with a face

// Two equal boxes stacked with their edges aligned.
Instance stack(BodyMaker& make, bool aligned) {
  const double h = make.voxel, half = kFaced.z() / 2 * h;
  Instance instance{make.box(kFaced, aligned), make.box(kFaced, aligned), {}};
  instance.place = [=](double depth) {
    return Placed{at(0, 0, -half), at(0, 0, half - depth),
                  pressed(depth, kFaced.x() * kFaced.y() * h * h * depth)};
  };
  return instance;
}

// The lowest corner of a turned box about the origin.
Vec3 lowestCorner(const Vec3& edges, const Quaternion& turn) {
  Vec3 lowest = Vec3::Zero();
  for (int k = 0; k < 8; ++k) {
    const Vec3 sign((k & 1) - 0.5, ((k >> 1) & 1) - 0.5, ((k >> 2) & 1) - 0.5);
    const Vec3 corner = turn * sign.cwiseProduct(edges).eval();
    if (corner.z() < lowest.z()) lowest = corner;
  }
  return lowest;
}

double genericRoll(Random& random) {
  return random.uniform(15, 75) * std::numbers::pi / 180;
}

const Vec3 kEdged(30, 24, 26);  // edges of the box that touches with an edge or a corner

// A box rolled about its x axis, so that an edge along x is lowest.
Instance edgeOn(BodyMaker& make, Ground ground, Body body) {
  const double h = make.voxel;
  const double roll = genericRoll(make.random);
  const Quaternion rolled(Eigen::AngleAxisd(roll, Vec3::UnitX()));
  const Quaternion yaw = make.random.yaw();
  const Vec3 lowest = lowestCorner(kEdged, rolled);
  Instance instance{groundBody(make, ground), std::move(body), {}};
  instance.place = [=](double depth) {
    const Vec3 edgeToBox(0, -lowest.y() * h, -lowest.z() * h - depth);
    // The wedge's cross-section: a triangle from the edge along its two faces to z = 0.
    const Vec3 center(0, (depth / std::tan(roll) - depth * std::tan(roll)) / 3, -depth / 3);
    const double section = depth * depth * (std::tan(roll) + 1 / std::tan(roll)) / 2;
    const double volume = section * kEdged.x() * h;
    return Placed{groundPose(ground, h),
                  {yaw * rolled, yaw * edgeToBox},
                  {Vec3::UnitZ(), depth, yaw * center, volume}};
  };
  return instance;
}

// A rotation with a corner lowest and its three edges rising by at least 15 degrees.
Quaternion cornerDown(Random& random) {
  for (;;) {
    const Quaternion turn = random.rotation();
    if ((turn.toRotationMatrix().row(2).array().abs() > std::sin(std::numbers::pi / 12)).all()) {
      return turn;
    }
  }
}

Instance cornerOn(BodyMaker& make, Ground ground, Body body) {
  const double h = make.voxel;
  const Quaternion turn = cornerDown(make.random);
  const Vec3 lowest = lowestCorner(kEdged, turn);
  const double rises = turn.toRotationMatrix().row(2).cwiseAbs().prod();
  Vec3 sum = Vec3::Zero();  // sum of the pyramid's three base corners at depth 1
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 edge = turn.toRotationMatrix().col(axis);
    sum += edge / std::abs(edge.z()) * (edge.z() < 0 ? -1 : 1);
  }
  Instance instance{groundBody(make, ground), std::move(body), {}};
  instance.place = [=](double depth) {
    const Vec3 center = sum * depth / 4;  // of the pyramid, from its apex
    return Placed{groundPose(ground, h),
                  {turn, -lowest * h - depth * Vec3::UnitZ()},
                  {Vec3::UnitZ(),
                   depth,
                   {center.x(), center.y(), -depth / 2},
                   depth * depth * depth / rises / 6}};
  };
  return instance;
}

// A's highest edge lies along x, B's lowest edge is turned from it by `degrees`; both are rolled.
Instance crossedEdges(BodyMaker& make, double degrees) {
  const double h = make.voxel;
  const double angle = degrees * std::numbers::pi / 180;
  const double rollA = genericRoll(make.random), rollB = genericRoll(make.random);
  const double slipA = make.random.uniform(-4, 4) * h, slipB = make.random.uniform(-4, 4) * h;
  const Quaternion turnA(Eigen::AngleAxisd(rollA, Vec3::UnitX()));
  const Quaternion turnB(Eigen::AngleAxisd(rollB, Vec3::UnitX()));
  const Quaternion yaw(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
  const Vec3 lowA = lowestCorner(kEdged, turnA), lowB = lowestCorner(kEdged, turnB);
  Instance instance{make.box(kEdged), make.box(kEdged), {}};
  instance.place = [=](double depth) {
    Placed placed;
    placed.a = {turnA, {slipA, lowA.y() * h, lowA.z() * h}};
    placed.b = {yaw * turnB, yaw * Vec3(slipB, -lowB.y() * h, -lowB.z() * h - depth)};
    // The overlap is a tetrahedron with a piece of each edge, from where it enters the other wedge
    // to where it leaves. `mean` is the middle of such a piece, beside the other edge.
    const auto mean = [&](double roll) {
      return depth * (std::tan(roll) - 1 / std::tan(roll)) / 2;
    };
    const Vec3 pieceB = mean(rollA) / std::sin(angle) * (yaw * Vec3::UnitX());
    const Vec3 pieceA = mean(rollB) / std::sin(angle) * Vec3::UnitX();
    placed.truth = {Vec3::UnitZ(), depth, (pieceA + pieceB - depth * Vec3::UnitZ()) / 2};
    return placed;
  };
  return instance;
}

// The center of the part at x < 0 of a rectangle turned by `yaw` about z [voxels].
Vec3 coveredCenter(double length, double width, const Quaternion& yaw) {
  std::vector<Vec3> corners, kept;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    corners.push_back(yaw * Vec3(x * length / 2, y * width / 2, 0));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3 from = corners[k], to = corners[(k + 1) % 4];
    if (from.x() < 0) kept.push_back(from);
    if ((from.x() < 0) != (to.x() < 0)) {
      kept.push_back(from + (to - from) * (from.x() / (from.x() - to.x())));
    }
  }
  Vec3 moment = Vec3::Zero();
  double area = 0;
  for (std::size_t k = 1; k + 1 < kept.size(); ++k) {
    const double part = (kept[k] - kept[0]).cross(kept[k + 1] - kept[0]).z() / 2;
    moment += part * (kept[0] + kept[k] + kept[k + 1]) / 3;
    area += part;
  }
  return moment / area;
}

// A box that overhangs, by half, the edge of a table that ends at x = 0.
Instance overhang(BodyMaker& make, bool aligned, bool yawed) {
  const double h = make.voxel;
  const Vec3 table(44, 40, 10), box(20, 24, 12);
  const Quaternion yaw = yawed ? make.random.yaw() : Quaternion::Identity();
  const Vec3 covered = coveredCenter(box.x(), box.y(), yaw) * h;
  Instance instance{make.box(table, aligned), make.box(box, aligned), {}};
  instance.place = [=](double depth) {
    return Placed{at(-22 * h, 0, -5 * h), at(0, 0, 6 * h - depth, yaw),
                  pressed(depth, box.x() * box.y() / 2 * h * h * depth, covered.x(), covered.y())};
  };
  return instance;
}

// A sphere or a smaller plate on an unsupported plate.
Instance onPlate(BodyMaker& make, double thickness, Instance instance) {
  const double h = make.voxel;
  instance.a = make.box({44, 42, thickness});
  instance.place = [=, upon = instance.place](double depth) {
    Placed placed = upon(depth);
    placed.a = at(0, 0, -thickness / 2 * h);
    return placed;
  };
  return instance;
}

using Cases = std::vector<ContactCase>;

std::string digits(double number) {
  return std::to_string(std::lround(number));
}

std::string groundName(Ground ground) {
  return ground == Ground::HalfSpace ? "halfspace" : "slab";
}

void addCurved(Cases& cases, double radius, const Bounds& bounds) {
  const std::string size = digits(radius);
  for (const Ground ground : {Ground::HalfSpace, Ground::Slab}) {
    cases.push_back(
        {"sphere" + size + "-" + groundName(ground), kPressed, bounds,
         [=](BodyMaker& make) { return sphereOn(make, ground, make.sphere(radius), radius); }});
    cases.push_back(
        {"cylinder" + size + "-" + groundName(ground), kPressed, bounds, [=](BodyMaker& make) {
           return cylinderOn(make, ground, make.cylinder(radius, kCylinderLength), radius);
         }});
  }
  cases.push_back({"cylinder" + size + "-across", kPressed, bounds,
                   [=](BodyMaker& make) { return cylinderAcross(make, radius); }});
  for (const double lower : {radius, 40.0}) {
    if (lower == radius && radius == 40.0) continue;
    cases.push_back({"sphere" + size + "-sphere" + digits(lower), kPressed, bounds,
                     [=](BodyMaker& make) { return sphereOnSphere(make, lower, radius); }});
  }
}

// A body of revolution, tilted by a random angle of `least` to `most` degrees. Its lowest point is
// then (radius, 0, z).
Instance tiltedOn(BodyMaker& make, Body body, double radius, double z, double least, double most) {
  const double h = make.voxel;
  const double tilt = make.random.uniform(least, most) * std::numbers::pi / 180;
  const Quaternion turn = make.random.yaw() * Quaternion(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
  const Vec3 lowest = turn * Vec3(radius, 0, z);
  Instance instance{groundBody(make, Ground::Slab), std::move(body), {}};
  instance.place = [=](double depth) {
    return Placed{groundPose(Ground::Slab, h),
                  {turn, -lowest * h - depth * Vec3::UnitZ()},
                  {Vec3::UnitZ(), depth, {0, 0, -depth / 2}}};
  };
  return instance;
}

// B is an analytic shape, on a slab that is a cloud.
void addPrimitives(Cases& cases) {
  for (const double radius : {16.0, 40.0}) {
    cases.push_back({"primitive-sphere" + digits(radius), kPressed, kSmooth, [=](BodyMaker& make) {
                       const Sphere sphere{radius * make.voxel};
                       return sphereOn(make, Ground::Slab, BodyMaker::shape(sphere), radius);
                     }});
    cases.push_back(
        {"primitive-cylinder" + digits(radius), kPressed, kSmooth, [=](BodyMaker& make) {
           const Cylinder cylinder{radius * make.voxel, kCylinderLength / 2 * make.voxel};
           return cylinderOn(make, Ground::Slab, BodyMaker::shape(cylinder), radius);
         }});
  }
  const auto box = [](const BodyMaker& make, const Vec3& edges) {
    return BodyMaker::shape(Box{edges / 2 * make.voxel});
  };
  cases.push_back({"primitive-face", kPressed, kSmooth, [=](BodyMaker& make) {
                     return faceOn(make, Ground::Slab, box(make, kFaced), kFaced);
                   }});
  cases.push_back({"primitive-edge", kPressed, kEdge,
                   [=](BodyMaker& make) { return edgeOn(make, Ground::Slab, box(make, kEdged)); }});
  cases.push_back({"primitive-corner", kPressed, kEdge, [=](BodyMaker& make) {
                     return cornerOn(make, Ground::Slab, box(make, kEdged));
                   }});
  cases.push_back({"primitive-hull-corner", kPressed, kEdge, [=](BodyMaker& make) {
                     return cornerOn(make, Ground::Slab,
                                     BodyMaker::shape(boxAsHull(kEdged / 2 * make.voxel)));
                   }});
  cases.push_back({"primitive-rim", kPressed, kEdge, [=](BodyMaker& make) {
                     const Cylinder cylinder{12 * make.voxel, 9 * make.voxel};
                     return tiltedOn(make, BodyMaker::shape(cylinder), 12, -9, 20, 70);
                   }});
  cases.push_back({"primitive-tip", {0.6, 1.0}, kEdge, [=](BodyMaker& make) {
                     const Cone cone{12 * make.voxel, 9 * make.voxel};
                     return tiltedOn(make, BodyMaker::shape(cone), 0, 9, 160, 180);
                   }});
}

void addFaces(Cases& cases) {
  for (const bool aligned : {false, true}) {
    const std::string tail = aligned ? "-aligned" : "";
    const Ground slab = aligned ? Ground::AlignedSlab : Ground::Slab;
    for (const Ground ground : {Ground::HalfSpace, slab}) {
      cases.push_back(
          {"face-" + groundName(ground) + tail, kPressed, kSmooth, [=](BodyMaker& make) {
             return faceOn(make, ground, make.box(kFaced, aligned), kFaced);
           }});
    }
    cases.push_back({"face-stack" + tail, kPressed, kSmooth,
                     [=](BodyMaker& make) { return stack(make, aligned); }});
    cases.push_back({"overhang" + tail, kPressed, kOverhang,
                     [=](BodyMaker& make) { return overhang(make, aligned, false); }});
  }
  cases.push_back({"overhang-yawed", kPressed, kOverhang,
                   [](BodyMaker& make) { return overhang(make, false, true); }});
}

void addEdges(Cases& cases) {
  for (const Ground ground : {Ground::HalfSpace, Ground::Slab}) {
    const std::string name = groundName(ground);
    cases.push_back({"edge-" + name, kPressed, kEdge,
                     [=](BodyMaker& make) { return edgeOn(make, ground, make.box(kEdged)); }});
    cases.push_back({"corner-" + name, kPressed, kEdge,
                     [=](BodyMaker& make) { return cornerOn(make, ground, make.box(kEdged)); }});
  }
  for (const double degrees : {90.0, 60.0}) {
    cases.push_back({"crossed" + digits(degrees), {0.5, 1.0}, kCrossed, [=](BodyMaker& make) {
                       return crossedEdges(make, degrees);
                     }});
  }
}

void addPlates(Cases& cases) {
  for (const double thickness : {2.0, 3.0}) {
    const std::string plate = "plate" + digits(thickness);
    const Vec3 edges(30, 24, thickness);
    const std::vector<double> depths{0.3, 0.6};
    for (const Ground ground : {Ground::HalfSpace, Ground::Slab}) {
      cases.push_back({plate + "-" + groundName(ground), depths, kWatched, [=](BodyMaker& make) {
                         return faceOn(make, ground, make.box(edges), edges);
                       }});
    }
    cases.push_back({"sphere16-" + plate, depths, kWatched, [=](BodyMaker& make) {
                       return onPlate(make, thickness,
                                      sphereOn(make, Ground::HalfSpace, make.sphere(16), 16));
                     }});
    cases.push_back({plate + "-" + plate, depths, kWatched, [=](BodyMaker& make) {
                       return onPlate(make, thickness,
                                      faceOn(make, Ground::HalfSpace, make.box(edges), edges));
                     }});
  }
}

}  // namespace

std::vector<ContactCase> contactCases() {
  Cases cases;
  addCurved(cases, 10, kWatched);
  for (const double radius : {16.0, 24.0, 40.0}) addCurved(cases, radius, kSmooth);
  cases.push_back({"sphere40-sphere40", kPressed, kSmooth,
                   [](BodyMaker& make) { return sphereOnSphere(make, 40, 40); }});
  addFaces(cases);
  addPrimitives(cases);
  addEdges(cases);
  addPlates(cases);
  return cases;
}

ContactCase contactCase(const std::string& name) {
  for (ContactCase& one : contactCases()) {
    if (one.name == name) return std::move(one);
  }
  throw std::invalid_argument("no contact case is called " + name);
}

std::string testName(std::string caseName) {
  std::replace(caseName.begin(), caseName.end(), '-', '_');
  return caseName;
}

void PrintTo(const ContactCase& one, std::ostream* out) {
  *out << one.name;
}

}  // namespace cloudcontact::testing
