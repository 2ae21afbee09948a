// The samples of docs/guides, compiled and run, and compared with the guides to the letter. Lines
// of a shell in guides and scenes in docs/scenes.md are run and read as they stand there.
#include <gtest/gtest.h>

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet.h>
#include <cloudcontact/cloudcontact.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "base/document_sample.h"
#include "bullet/bullet_world.h"
#include "mesh/test_meshes.h"
#include "program/program_run.h"
#include "scene/scene_file.h"

namespace guide_samples_test {
namespace {

using cloudcontact::NamedMesh;
using cloudcontact::Vec3;
namespace fs = std::filesystem;

void expectSamples(const std::string& guide, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    cloudcontact::testing::expectSample(guide, name, "tests/program/guide_samples_test.cpp");
}

std::string stl(const cloudcontact::Mesh& mesh) {
  std::ostringstream text;
  text << "solid part\n";
  for (const Eigen::Vector3i& t : mesh.triangles) {
    text << "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) text << "vertex " << mesh.vertices[t[k]].transpose() << "\n";
    text << "endloop\nendfacet\n";
  }
  text << "endsolid part\n";
  return text.str();
}

// Points on a ball of 30 mm.
std::string scan() {
  std::ostringstream text;
  for (const Vec3& p : cloudcontact::test::sphereMesh(30, 5).vertices)
    text << p.transpose() << "\n";
  return text.str();
}

// A ball of enamel with a core of dentin in air, voxels of 1 mm.
std::string volume() {
  constexpr int n = 24;
  std::string file =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 24 24 24\nspacings: 1 1 1\nendian: little\n"
      "encoding: raw\n\n";
  for (int k = 0; k < n * n * n; ++k) {
    const double r = (Vec3(k % n, k / n % n, k / (n * n)) - Vec3::Constant(11.5)).norm();
    const auto value = static_cast<std::int16_t>(r < 5 ? 1200 : r < 9 ? 2400 : -1000);
    file.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return file;
}

// Files that the guides name, in the working directory.
class Guide : public ::testing::Test {
 protected:
  Guide() : before_(fs::current_path()) {
    folder_.write("part.stl", stl(cloudcontact::test::boxMesh({-20, -15, -10}, {20, 15, 10})));
    folder_.write("scan.xyz", scan());
    folder_.write("tooth.nrrd", volume());
    fs::current_path(folder_ / "");
  }
  ~Guide() override { fs::current_path(before_); }
  program_test::Workplace folder_;

 private:
  fs::path before_;
};

TEST_F(Guide, FirstClouds) {
  const cloudcontact::Mesh box = cloudcontact::test::boxMesh({-0.2, -0.2, -0.02}, {0.2, 0.2, 0});
  const auto above = [](double z) {
    return btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(z)));
  };
  // first begins
  btDefaultCollisionConfiguration configuration;
  cloudcontact::CloudContact contact;
  btCollisionDispatcher dispatcher(&configuration);
  contact.attach(dispatcher);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  cloudcontact::recommendedSettings(world);
  // first ends
  world.setGravity(btVector3(0, 0, btScalar(-9.81)));
  // clang-format off
  // bodies begins
  const cloudcontact::Mesh mesh = cloudcontact::loadMesh("part.stl", 0.001);  // the file is in mm
  cloudcontact::CloudBody table(box, btTransform::getIdentity(), {.mass = 0});
  cloudcontact::CloudBody part(mesh, above(0.012), {.mass = 0.2});
  cloudcontact::CloudBody other(part, above(0.12));  // of the same voxels, digitized once
  for (cloudcontact::CloudBody* body : {&table, &part, &other}) body->addTo(world);
  part.body().setFriction(btScalar(0.5));  // a btRigidBody like any other
  // bodies ends
  // clang-format on
  EXPECT_EQ(&part.shape().field(), &other.shape().field());
  // steps begins
  for (int i = 0; i < 480; ++i) world.stepSimulation(btScalar(1) / 240, 0);
  for (const std::string& advice : cloudcontact::diagnose(world)) std::puts(advice.c_str());
  const btVector3 where = part.meshPlace().getOrigin();  // of the mesh, to draw it
  // steps ends
  EXPECT_TRUE(cloudcontact::diagnose(world).empty());
  // Half its height above the table, but for the sag of a fraction of a voxel.
  EXPECT_NEAR(where.z(), 0.01, 3e-4);
  EXPECT_NEAR(other.meshPlace().getOrigin().z(), 0.03, 6e-4);
  expectSamples("docs/guides/first_clouds.md", {"first", "bodies", "steps"});
}

// A ball on the sample's spring, against a fixed face without gravity: the speed that comes back.
double restitution(const cloudcontact::KelvinVoigt& law, double mass, double step) {
  cloudcontact::testing::BulletWorld scene;
  scene.world.setGravity(btVector3(0, 0, 0));
  scene.addGround();
  cloudcontact::CloudBody ball(
      cloudcontact::test::sphereMesh(0.02, 5),
      btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(0.0205))),
      {.voxelSize = 0.001, .mass = mass, .law = law});
  ball.addTo(scene.world);
  ball.body().setLinearVelocity(btVector3(0, 0, btScalar(-0.1)));
  for (int i = 0; i < int(0.2 / step); ++i) scene.step(step);
  const double back = ball.body().getLinearVelocity().z() / 0.1;
  ball.leaveWorld();
  return back;
}

// The guide's formula: of a spring with this damping ratio that never pulls.
double returned(double z) {
  const double root = std::sqrt(1 - z * z);
  return std::exp(-z / root * std::atan2(2 * z * root, 2 * z * z - 1));
}

TEST_F(Guide, Choosing) {
  // clang-format off
  // choosing begins
  const double m = 0.2;                      // [kg]
  const double h = 1.0 / 240;                // step [s]
  const double voxel = 0.0005;               // [m]
  const double k = m * 9.81 / (0.1 * voxel); // its weight sags by a tenth of a voxel
  const double z = 0.36;                     // damping ratio: 0.4 of a speed comes back
  const double c = 2 * z * std::sqrt(k * m);
  const cloudcontact::KelvinVoigt law{k, c};
  const double longest = std::sqrt(10 * m / k);  // step that ten sweeps carry [s]
  // choosing ends
  // clang-format on
  EXPECT_NEAR(returned(z), 0.4, 5e-3);
  EXPECT_NEAR(returned(1 - 1e-12), std::exp(-2), 1e-4);
  const std::pair<double, double> table[] = {{0.9, 0.034}, {0.8, 0.074}, {0.7, 0.122},
                                             {0.6, 0.181}, {0.5, 0.255}, {0.4, 0.355},
                                             {0.3, 0.497}, {0.2, 0.731}};
  for (const auto& [speed, ratio] : table) EXPECT_NEAR(returned(ratio), speed, 2e-3) << ratio;
  EXPECT_NEAR(cloudcontact::stepLimited(m, longest).stiffness, k, 1e-9 * k);
  EXPECT_LT(h, longest);
  EXPECT_NEAR(longest, std::sqrt(10 * 0.1 * voxel / 9.81), 1e-12);
  EXPECT_NEAR(longest, 7.1e-3, 5e-5);
  EXPECT_NEAR(longest / std::sqrt(10), 2.3e-3, 6e-5);
  EXPECT_NEAR(returned(0.068 / 2), 0.9, 2e-3);
  // In Bullet. The steps' own damping, w h / 2, is a hundredth of z.
  const double w = std::sqrt(k / m);
  EXPECT_NEAR(restitution(law, m, 0.02 * z / w), returned(1.01 * z), 0.02);
  // Without damping the step's own counts.
  EXPECT_NEAR(restitution({k, 0}, m, 0.068 / w), 0.9, 0.03);
  expectSamples("docs/guides/choosing.md", {"choosing"});
}

cloudcontact::Cloud digitized(const cloudcontact::Mesh& mesh, double voxel) {
  cloudcontact::DigitizeSettings settings;
  settings.voxelSize = voxel;
  return cloudcontact::digitize(mesh, settings);
}

TEST_F(Guide, PaperMethod) {
  cloudcontact::CloudShape shape(
      cloudcontact::SurfaceField::build(digitized(cloudcontact::test::sphereMesh(0.01, 4), 0.001)));
  // clang-format off
  // paper begins
  cloudcontact::PaperSettings paper;
  paper.window = cloudcontact::sphereWindow(shape.cloud().voxelSize());  // C: 2.5 voxels around, Gr in its middle
  paper.area = cloudcontact::PlacedSolid{cloudcontact::Sphere{0.004}};   // D, in the body's frame
  paper.parts = {{{cloudcontact::Sphere{0.002}}, 2.0}};                  // its middle cuts twice as well
  shape.setTissues({cloudcontact::dentalTissues()[1]});  // dentin throughout
  shape.usePaper(paper);
  // paper ends
  // clang-format on
  EXPECT_TRUE(shape.usesPaper());
  expectSamples("docs/guides/paper_method.md", {"paper"});
}

TEST_F(Guide, FromCt) {
  // ct begins
  cloudcontact::VolumeFileSettings file;
  file.metersPerUnit = 0.001;  // where the file states no unit
  const cloudcontact::CtVolume scan = cloudcontact::loadVolume("tooth.nrrd", file);
  const cloudcontact::Cloud tooth =
      cloudcontact::cloudFromCt(scan, {{900, "dentin"}, {1800, "enamel"}});
  // ct ends
  EXPECT_EQ(tooth.materials(), (std::vector<std::string>{"dentin", "enamel"}));
  EXPECT_NEAR(tooth.massProperties().volume, 4 * std::numbers::pi / 3 * std::pow(9e-3, 3), 2e-7);
  expectSamples("docs/guides/from_scans.md", {"ct"});
}

TEST_F(Guide, FromADepthCamera) {
  const auto distanceAt = [](int x, int y) { return 1e-4 * (x * x + y * y) / 40; };
  // depth begins
  cloudcontact::DepthImage image;
  image.width = 40, image.height = 30;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)  // [m]; NaN where the camera saw nothing
      image.points.emplace_back(0.002 * x, 0.002 * y, 0.5 + distanceAt(x, y));
  cloudcontact::DepthCloudSettings settings;
  settings.voxelSize = 0.002;
  settings.thickness = 0.01;
  const cloudcontact::Cloud seen = cloudcontact::toCloud(image, settings);
  // depth ends
  EXPECT_NEAR(seen.massProperties().volume, 0.078 * 0.058 * 0.01, 0.1 * 0.078 * 0.058 * 0.01);
  expectSamples("docs/guides/from_scans.md", {"depth"});
}

TEST_F(Guide, FromPoints) {
  // points begins
  auto points = std::get<cloudcontact::PointCloud>(cloudcontact::loadPoints("scan.xyz", 0.001));
  cloudcontact::ScanSettings scan;
  scan.voxelSize = cloudcontact::suggestedVoxel(points);
  scan.shell = 3 * scan.voxelSize;  // for points that close no volume
  cloudcontact::ScanReport report;
  const cloudcontact::Cloud body = cloudcontact::toCloud(points, scan, &report);
  // points ends
  EXPECT_TRUE(report.closed);
  const double ball = 4 * std::numbers::pi / 3 * std::pow(0.03, 3);
  EXPECT_NEAR(body.massProperties().volume, ball, 0.02 * ball);
  expectSamples("docs/guides/from_scans.md", {"points"});
}

TEST_F(Guide, Haptics) {
  const cloudcontact::Cloud cloud = digitized(cloudcontact::test::sphereMesh(0.01, 4), 0.0004);
  cloudcontact::BaseVectorField work(cloud, {cloudcontact::dentalTissues()[3]},
                                     cloudcontact::sphereWindow(cloud.voxelSize()));
  cloudcontact::Pose hand;
  hand.position = Vec3(0, 0, 0.0121);
  // hand begins
  cloudcontact::HapticSettings settings;
  settings.tool.area = {cloudcontact::Sphere{0.002}};  // D
  settings.handStiffness = 800;                        // of the device's virtual coupling [N/m]
  cloudcontact::HapticLoop loop(work, cloudcontact::Pose{}, settings);
  double most = 0;
  for (int i = 0; i < 200; ++i) {  // a millisecond each
    hand.position.z() -= 1e-5;
    most = std::max(most, loop.tick({hand, Vec3(0, 0, -0.01)}).onHand.force.z());
  }
  // hand ends
  EXPECT_GT(most, 0.5);
  EXPECT_LT(most, 800 * 2.1e-3);
  // clang-format off
  // bur begins
  settings.cutter = cloudcontact::Cutter{17e9, 0.1, 5};  // tungsten carbide, a tenth comes off, edges at 5 m/s
  cloudcontact::HapticLoop drill(work, cloudcontact::Pose{}, settings);
  double cut = 0;  // [m^3]
  for (int i = 0; i < 200; ++i) cut += drill.tick({hand, Vec3::Zero()}).cutVolume;
  // bur ends
  // clang-format on
  const double left = work.cloud().massProperties().volume;
  EXPECT_GT(cut, 1e-10);
  EXPECT_NEAR(cloud.massProperties().volume - left, cut, 0.02 * cut);
  expectSamples("docs/guides/cutting.md", {"hand", "bur"});
}

TEST_F(Guide, CuttingInBullet) {
  btDefaultCollisionConfiguration configuration;
  cloudcontact::CloudContact contact;
  btCollisionDispatcher dispatcher(&configuration);
  contact.attach(dispatcher);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  const cloudcontact::Cloud cloud =
      digitized(cloudcontact::test::boxMesh({-0.02, -0.005, -0.005}, {0.02, 0.005, 0.005}), 0.001);
  // clang-format off
  // saw begins
  cloudcontact::CuttableBodySettings settings;
  settings.densities = {1200};  // [kg/m^3]
  cloudcontact::CuttableBody bar(cloud, btTransform::getIdentity(), settings);
  bar.addTo(world);
  std::vector<cloudcontact::VoxelCut> cuts;
  const int middle = bar.cloud().size().x() / 2;
  for (int z = 0; z < bar.cloud().size().z(); ++z)
    for (int y = 0; y < bar.cloud().size().y(); ++y) cuts.push_back({{middle, y, z}, 0});  // nothing is left there
  const cloudcontact::CutOutcome outcome = bar.cut(cuts);  // outcome.fallen: the pieces
  // saw ends
  // clang-format on
  ASSERT_EQ(outcome.fallen.size(), 1u);
  EXPECT_NEAR(bar.volume() + outcome.fallen[0]->volume(), 0.039 * 1e-4, 2e-8);
  expectSamples("docs/guides/cutting.md", {"saw"});
}

TEST_F(Guide, BatchOfTheMeasurements) {
  using namespace cloudcontact;
  const auto field = SurfaceField::build(digitized(cloudcontact::test::sphereMesh(0.01, 4), 0.001));
  std::vector<BatchPair> pairs(3);
  for (BatchPair& pair : pairs) {
    pair.a.field = pair.b.field = field.get();
    pair.b.pose.position = Vec3(0, 0, 0.0195);
  }
  std::size_t points = 0;
  const auto use = [&](const ContactResult& contact) { points += contact.points.size(); };
  // batch begins
  ContactBatch batch({Backend::OpenCl});
  for (const ContactResult* contact : batch.find(pairs)) use(*contact);
  // batch ends
  EXPECT_GE(points, 3u);
  expectSamples("docs/measurements.md", {"batch"});
}

// Fenced blocks of a language.
std::vector<std::string> blocks(const std::string& document, const std::string& language) {
  std::ifstream in(fs::path(CLOUDCONTACT_SOURCE_DIR) / document);
  std::vector<std::string> all;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line == "```" + language) {
      inside = true;
      all.emplace_back();
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      all.back() += line + "\n";
    }
  }
  return all;
}

std::string world(const std::string& models) {
  return "<sdf version=\"1.9\" xmlns:cloudcontact=\"https://cloudcontact\"><world name=\"w\">" +
         models + "</world></sdf>";
}

TEST_F(Guide, LinesOfAShellRun) {
  folder_.write("scene.sdf",
                world("<model name=\"ball\"><link name=\"l\"><collision name=\"c\"><geometry>"
                      "<sphere><radius>0.02</radius></sphere></geometry></collision></link>"
                      "</model>"));
  int count = 0;
  for (const auto& guide :
       fs::directory_iterator(fs::path(CLOUDCONTACT_SOURCE_DIR) / "docs/guides"))
    for (const std::string& block :
         blocks("docs/guides/" + guide.path().filename().string(), "sh")) {
      std::istringstream lines(block);
      for (std::string line; std::getline(lines, line); ++count) {
        std::istringstream words(line);
        std::string word;
        ASSERT_TRUE(words >> word && word == "cloudcontact") << line;
        std::vector<std::string> arguments;
        while (words >> word) arguments.push_back(word);
        const program_test::Outcome outcome = folder_.run(arguments);
        EXPECT_EQ(outcome.exitCode, 0) << line << "\n" << outcome.err;
      }
    }
  EXPECT_GE(count, 4);
}

TEST_F(Guide, ScenesAreRead) {
  fs::copy_file(fs::path(CLOUDCONTACT_SOURCE_DIR) / "tests/program/layers.obj",
                folder_ / "layers.obj");
  const auto scenes = blocks("docs/scenes.md", "xml");
  ASSERT_GE(scenes.size(), 2u);
  for (const std::string& scene : scenes) {
    folder_.write("shown.sdf", world(scene));
    EXPECT_NO_THROW(cloudcontact::program::loadScene(folder_ / "shown.sdf")) << scene;
  }
}

}  // namespace

}  // namespace guide_samples_test
