// Time of one narrow-phase query, compared with other libraries in the same run: a nut on its bolt,
// two tori, a face on a block, two spheres. Also with a window of 2.5 voxels stated, and the error
// of the default number of samples against all samples.
//   pairs [BOLT NUT] [--turns N] [--out FILE.json]
// BOLT and NUT are meshes in meters; by default a generated M16 bolt and nut. Each turn times every
// method once; the table shows the least of the turns' medians, as other work on the machine only
// adds.
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string>

#include "lab/pair.h"
#include "scene/bullet_methods.h"
#include "scene/generated_mesh.h"
#include "scene/pair_probe.h"
#include "scene/primitive_mesh.h"
#include "timing.h"
#include "torus.h"

namespace {

using namespace cloudcontact;
using nlohmann::json;
using program::Method;
using program::PairProbe;

constexpr double kJitter = 1e-3;  // shift between calls [voxels]
constexpr std::size_t kOurs = 3;  // the first timers are this project's
constexpr double kWindow = 2.5;   // radius of the stated C [voxels]

struct Case {
  const char* name;
  Mesh a, b;
  Pose pose;     // of b
  double voxel;  // [m]
  std::vector<std::string> peers;
};

Pose placed(double x, double y, double z) {
  Pose pose;
  pose.position = Vec3(x, y, z);
  return pose;
}

// Times of repeated queries of one pair [us].
using Timer = std::function<std::vector<double>(int repeat)>;

// A probe with the shapes that it refers to.
struct Probed {
  program::BulletShape a, b;
  PairProbe probe;

  Probed(program::BulletShape first, program::BulletShape second, const Pose& pose, Method method,
         const CloudContactSettings& law)
      : a(std::move(first)),
        b(std::move(second)),
        probe(*a.shape, *b.shape, pose, Motion{}, method, law) {}
};

// `rests`: contacts are moved with the bodies (CloudContactSettings::reuseMotion).
Timer probed(const program::BulletShape& a, const program::BulletShape& b, const Case& pair,
             Method method, bool rests = false) {
  CloudContactSettings law{KelvinVoigt{1e4, 0}};
  law.fidelity.exact = true;
  if (!rests) law.reuseMotion = 0;
  const auto made = std::make_shared<Probed>(a, b, pair.pose, method, law);
  const double jitter = kJitter * pair.voxel;
  return [=](int repeat) { return made->probe.microseconds(repeat, jitter); };
}

Timer peer(const std::string& name, const Case& pair) {
  if (name == "FCL") {
    const double jitter = kJitter * pair.voxel;
    const auto body = [](const Mesh& mesh) {
      return program::lab::LabBody{"", [mesh](double) { return mesh; }, {}, false, {}};
    };
    for (const auto& method : program::lab::otherMethods())
      if (method.method == "fcl" && method.setting.starts_with("BVH")) {
        const auto made = method.prepare(body(pair.a), body(pair.b), method.detail);
        return [=](int repeat) { return made.microseconds(pair.pose, repeat, jitter); };
      }
    throw std::runtime_error("built without FCL");
  }
  const bool hull = name == "GJK/EPA";
  const auto shape = [&](const Mesh& mesh) {
    return hull ? program::hullShape(mesh) : program::gimpactShape(mesh);
  };
  return probed(shape(pair.a), shape(pair.b), pair, hull ? Method::Gjk : Method::Gimpact);
}

struct Total {
  Vec3 force = Vec3::Zero();
  double deepest = 0;
  std::size_t samples = 0;
};

Total totalOf(const ContactBody& a, const ContactBody& b, std::size_t samples) {
  ContactFinder finder;
  ContactSettings settings;
  settings.law = KelvinVoigt{1, 0};
  settings.samples = samples;
  const ContactResult& found = finder.find(a, b, settings);
  Total total;
  total.samples = found.samples;
  for (const ContactPoint& p : found.points) {
    if (p.depth <= 0) continue;
    total.force += p.stiffness * p.depth * p.normal;
    total.deepest = std::max(total.deepest, p.depth);
  }
  return total;
}

// Error of the default number of samples against all samples.
json accuracy(const Case& pair, const SurfaceField& a, const SurfaceField& b) {
  ContactBody at{}, on{};
  at.field = &a;
  on.field = &b;
  on.pose = pair.pose;
  const Total few = totalOf(at, on, ContactSettings{}.samples), all = totalOf(at, on, SIZE_MAX);
  const double sine = few.force.cross(all.force).norm(), cosine = few.force.dot(all.force);
  const double degrees = std::atan2(sine, cosine) * 180 / std::numbers::pi;
  const double depth = std::abs(few.deepest - all.deepest) / pair.voxel;
  std::printf(
      "  %zu samples in contact instead of all %zu: direction off by %.3f deg, depth by %.3f "
      "voxels\n",
      few.samples, all.samples, degrees, depth);
  return {{"samples", few.samples}, {"all", all.samples}, {"degrees", degrees}, {"voxels", depth}};
}

double least(const std::vector<double>& times) {
  return *std::min_element(times.begin(), times.end());
}

json measure(const Case& pair, int turns) {
  DigitizeSettings settings;
  settings.voxelSize = pair.voxel;
  const auto a = SurfaceField::build(digitize(pair.a, settings)),
             b = SurfaceField::build(digitize(pair.b, settings));
  std::vector<std::pair<std::string, Timer>> timers;
  const auto cloud = [](const auto& field) {
    return program::BulletShape{{}, std::make_shared<CloudShape>(field)};
  };
  const auto stated = [&](const auto& field) {
    const auto shape = std::make_shared<CloudShape>(field);
    PaperSettings paper;
    paper.window = sphereWindow(pair.voxel, kWindow);
    shape->usePaper(paper);
    return program::BulletShape{{}, shape};
  };
  timers.emplace_back("cloud", probed(cloud(a), cloud(b), pair, Method::Cloud));
  timers.emplace_back("stated", probed(stated(a), stated(b), pair, Method::Paper));
  timers.emplace_back("cloud, at rest", probed(cloud(a), cloud(b), pair, Method::Cloud, true));
  for (const std::string& name : pair.peers) timers.emplace_back(name, peer(name, pair));
  std::vector<std::vector<double>> times(timers.size());
  for (int turn = 0; turn < turns; ++turn)
    for (std::size_t k = 0; k < timers.size(); ++k)
      times[k].push_back(median(timers[k].second(k < kOurs ? 200 : 9)));
  std::printf("%s: %zu and %zu triangles, voxels of %g mm\n", pair.name, pair.a.triangles.size(),
              pair.b.triangles.size(), 1e3 * pair.voxel);
  json row{{"pair", pair.name}, {"voxel", pair.voxel}};
  const double ours = least(times[0]), resting = least(times[2]);
  for (std::size_t k = 0; k < timers.size(); ++k) {
    const double time = least(times[k]);
    std::printf("  %-14s %11.1f us, %8.2f x cloud, %8.2f x cloud at rest\n",
                timers[k].first.c_str(), time, time / ours, time / resting);
    row["microseconds"][timers[k].first] = time;
  }
  row["against all samples"] = accuracy(pair, *a, *b);
  std::fflush(stdout);
  return row;
}

std::vector<Case> casesOf(const std::vector<std::string>& files) {
  program::Thread thread;
  thread.clearance = 1e-4;
  const bool given = files.size() == 2;
  std::vector<Case> cases;
  cases.push_back({"a M16 nut on its bolt",
                   given ? loadMesh(files[0]) : program::boltMesh(thread, 40e-3),
                   given ? loadMesh(files[1]) : program::nutMesh(thread, 13e-3, 24e-3),
                   placed(0, 0, 0.0078),
                   0.25e-3,
                   {"GImpact", "FCL"}});
  const Mesh torus = torusMesh(2.5, 1, 128, 64);
  cases.push_back(
      {"a torus on another", torus, torus, placed(0.1, 0.05, 1.95), 1.0 / 20, {"GImpact"}});
  const auto box = [](const Vec3& half) { return program::primitiveMesh(Box{half}, 1); };
  Pose onBlock = placed(0.3e-3, 0.2e-3, 27.5e-3);  // half a voxel deep
  onBlock.orientation = Eigen::AngleAxisd(0.3, Vec3::UnitZ());
  cases.push_back({"a face of 32 x 32 voxels on a block",
                   box(Vec3(32, 32, 12) * 1e-3),
                   box(Vec3(16, 16, 16) * 1e-3),
                   onBlock,
                   1e-3,
                   {"GImpact"}});
  const Mesh sphere = program::primitiveMesh(Sphere{1}, 1.0 / 100);
  cases.push_back(
      {"a sphere on another", sphere, sphere, placed(0.3, 0.2, 1.9), 1.0 / 16, {"GJK/EPA"}});
  return cases;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    int turns = 5;
    std::string out;
    std::vector<std::string> files;
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word == "--turns" && i + 1 < argc)
        turns = std::max(1, std::stoi(argv[++i]));
      else if (word == "--out" && i + 1 < argc)
        out = argv[++i];
      else
        files.push_back(word);
    }
    if (files.size() != 0 && files.size() != 2)
      throw std::invalid_argument("give the meshes of a bolt and a nut, or none");
    json rows;
    for (const Case& pair : casesOf(files)) rows.push_back(measure(pair, turns));
    if (out.empty()) return 0;
    std::ofstream file(out);
    file << json{{"rows", rows}}.dump(2) << '\n';
    if (!file) throw std::runtime_error(out + ": cannot write the file");
    return 0;
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "pairs: %s\n", failure.what());
    return 1;
  }
}
