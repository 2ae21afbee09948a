// A device that fails half-way: what callers are told, and what is left.
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/device/device_workpiece.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "contact/contact_cases.h"
#include "contact/same_contact.h"
#include "device/device_wanted.h"
#include "device/opencl_faults.h"
#include "mesh/test_meshes.h"
#include "voxels/small_clouds.h"
#include "workpiece/base_vector_bricks.h"

namespace cloudcontact::test {
namespace {

const TissueTable kBone{{"bone", 2e4, .4, 3e9, 2970}};

DigitizeSettings voxelsOfOne() {
  DigitizeSettings settings;
  settings.voxelSize = 1;
  return settings;
}

// What is thrown where a call fails; it names the device and the call.
void expectTold(const char* call, const std::string& device, const std::function<void()>& work,
                int after = 0) {
  SCOPED_TRACE(call);
  const Fault fault(call, after);
  try {
    work();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    const std::string told = e.what();
    EXPECT_NE(told.find(device), std::string::npos) << told;
    EXPECT_NE(told.find(call), std::string::npos) << told;
  } catch (const std::exception& e) {
    ADD_FAILURE() << "no runtime_error: " << e.what();
  }
}

// What a workpiece says whose cut failed half-way.
void expectEnded(const std::function<void()>& work) {
  try {
    work();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("make the workpiece anew"), std::string::npos) << e.what();
  }
}

TEST(DeviceFailure, OfADigitizerIsARuntimeError) {
  Digitizer digitizer({Backend::OpenCl, true});
  SKIP_WITHOUT(digitizer);
  const std::string& name = digitizer.device();
  const Mesh ball = sphereMesh(8, 3);
  expectTold("clEnqueueNDRangeKernel", name, [&] { digitizer.run(ball, voxelsOfOne()); });
  digitizer.run(ball, voxelsOfOne(), kBone, sphereWindow(1));
  ASSERT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
  expectTold("clEnqueueReadBuffer", name, [&] { digitizer.cloud(); });
  expectTold("clEnqueueReadBuffer", name, [&] { digitizer.field(); });
  expectTold("clEnqueueReadBuffer", name, [&] { DeviceWorkpiece{digitizer}; });
  expectTold("clEnqueueWriteBuffer", name, [&] { DeviceWorkpiece{digitizer}; });
  expectTold("clFinish", name, [&] { digitizer.deviceTimes(); });
  // What was made is still there.
  const Cloud want = digitize(ball, voxelsOfOne());
  EXPECT_EQ(digitizer.cloud().voxels().coverage, want.voxels().coverage);
  EXPECT_EQ(digitizer.field().hash(), BaseVectorField(want, kBone, sphereWindow(1)).hash());
}

// A driver that does not even say what it is.
TEST(DeviceFailure, OfADriverLeavesTheCpu) {
  for (const char* what : {"its name", "its type"}) {
    SCOPED_TRACE(what);
    const Fault fault(what);
    Digitizer digitizer({Backend::OpenCl});
    EXPECT_EQ(digitizer.backend(), Backend::Cpu);
    EXPECT_NE(digitizer.message().find("no OpenCL device"), std::string::npos)
        << digitizer.message();
  }
}

BaseVectorField ballField() {
  return {ballCloud(1, 3, Vec3(12.2, 11.9, 12.1), 10), kBone, sphereWindow(1)};
}

// Whatever a cut has begun when the device fails, nothing is cut on top of it. What it was begun
// with is the caller's again.
TEST(DeviceFailure, InTheMidstOfACutEndsTheWorkpiece) {
  const std::vector<VoxelCut> cuts{{{12, 12, 12}, 0}, {{12, 12, 12}, 9}, {{12, 13, 12}, 0}};
  const Area area = SphereArea{Vec3(12, 12, 12), 3};
  for (const int after : {0, 1, 2}) {  // kernels that still run: a cut is three
    for (const bool pass : {false, true}) {
      SCOPED_TRACE(std::to_string(after) + (pass ? " of a tool's" : " of voxels named"));
      DeviceWorkpiece piece(ballField(), {Backend::OpenCl});
      SKIP_WITHOUT(piece);
      ASSERT_EQ(piece.cut(cuts), 2u);  // so that a pass of a tool, too, has three
      const auto cut = [&] { pass ? piece.cut(area, Pose{}) : piece.cut(cuts); };
      expectTold("clEnqueueNDRangeKernel", piece.device(), cut, after);
      EXPECT_FALSE(calls.underWay);
      expectEnded([&] { piece.cut(cuts); });
      expectEnded([&] { piece.cut(area, Pose{}); });
      expectEnded([&] { piece.field(); });
      expectEnded([&] { piece.mass(); });
    }
  }
}

// What is read goes into memory that is gone once field() has thrown.
TEST(DeviceFailure, InTheMidstOfFetchingIsWaitedFor) {
  const BaseVectorField cpu = ballField();
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl});
  SKIP_WITHOUT(piece);
  // The table, the shared block, and then what the bricks have of their own.
  for (const int after : {0, 1, 2}) {
    expectTold(
        "clEnqueueReadBuffer", piece.device(), [&] { piece.field(); }, after);
    EXPECT_FALSE(calls.underWay) << after;
  }
  EXPECT_EQ(piece.field().hash(), cpu.hash());
}

// The mesh is on its way up when its field is refused, or a kernel is; the next takes its place.
TEST(DeviceFailure, InTheMidstOfDigitizingIsWaitedFor) {
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  const Mesh ball = sphereMesh(8, 3);
  EXPECT_THROW(digitizer.run(ball, voxelsOfOne(), TissueTable{}, sphereWindow(1)),
               std::invalid_argument);
  EXPECT_FALSE(calls.underWay);
  expectTold("clEnqueueNDRangeKernel", digitizer.device(),
             [&] { digitizer.run(ball, voxelsOfOne()); });
  EXPECT_FALSE(calls.underWay);
  EXPECT_THROW(digitizer.cloud(), std::logic_error);
  digitizer.run(ball, voxelsOfOne());
  EXPECT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
  EXPECT_EQ(digitizer.cloud().voxels().coverage, digitize(ball, voxelsOfOne()).voxels().coverage);
}

// Kernels that a device could not run are not handed to it.
TEST(DeviceFailure, SmallGroupsAreTheCpus) {
  const Said most(CL_DEVICE_MAX_WORK_GROUP_SIZE, 128);
  const DeviceWorkpiece piece(ballField(), {Backend::OpenCl});
  if (mayDoWithout(piece)) GTEST_SKIP() << piece.message();
  EXPECT_EQ(piece.backend(), Backend::Cpu);
  EXPECT_NE(piece.message().find("128 work-items"), std::string::npos) << piece.message();
}

TEST(DeviceFailure, LittleLocalMemoryIsEnough) {
  const Said little(CL_DEVICE_LOCAL_MEM_SIZE, 8192);
  BaseVectorField cpu = ballField();
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl, true});
  SKIP_WITHOUT(piece);
  const std::vector<VoxelCut> cuts{{{12, 12, 12}, 0}, {{12, 13, 12}, 9}};
  EXPECT_EQ(piece.cut(cuts), cpu.cut(cuts));
  EXPECT_EQ(piece.field().hash(), cpu.hash());
  EXPECT_EQ(piece.deviceTimes().count("ccRenewWindows"), 0u);
  Digitizer digitizer({Backend::OpenCl, true});
  digitizer.run(sphereMesh(8, 3), voxelsOfOne(), kBone, sphereWindow(1));
  EXPECT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
  EXPECT_EQ(digitizer.deviceTimes().count("ccSumWindows"), 0u);
}

// What was never handed over took no time, and is no reason not to tell what others took.
TEST(DeviceFailure, IsNoReasonNotToTellTimes) {
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl, true});
  SKIP_WITHOUT(piece);
  const std::vector<VoxelCut> cuts{{{9, 9, 9}, 7}};
  piece.deviceTimes();
  expectTold(
      "clEnqueueNDRangeKernel", piece.device(), [&] { piece.cut(cuts); }, 1);
  const std::map<std::string, DeviceTime> times = piece.deviceTimes();
  EXPECT_EQ(times.at("ccStringCuts").calls, 1);
  EXPECT_EQ(times.count("ccNoteLosses"), 0u);
  EXPECT_TRUE(piece.deviceTimes().empty());
}

// Where nobody asks for times, what is noted does not grow without end; and none is forgotten.
TEST(DeviceFailure, TimesNobodyAsksForDoNotPileUp) {
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl, true});
  SKIP_WITHOUT(piece);
  const std::vector<VoxelCut> cuts{{{0, 0, 0}, 7}};
  piece.deviceTimes();
  const int released = calls.eventsReleased, count = 2000;
  for (int k = 0; k < count; ++k) piece.cut(cuts);
  EXPECT_GT(calls.eventsReleased - released, count);
  const std::map<std::string, DeviceTime> times = piece.deviceTimes();
  for (const char* what : {"step sent", "ccStringCuts", "ccNoteLosses", "ccRenewWindows"})
    EXPECT_EQ(times.at(what).calls, count) << what;
}

// A mesh that the device has no room for keeps no other off it, nor any memory there.
TEST(DeviceFailure, ASmallMeshAfterOneTooLargeIsTheDevices) {
  const Said largest(CL_DEVICE_MAX_MEM_ALLOC_SIZE, 20 << 20);
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  const Mesh small = sphereMesh(8, 3), large = sphereMesh(100, 5);
  for (const bool field : {false, true}) {
    const auto run = [&](const Mesh& mesh) {
      if (field)
        digitizer.run(mesh, voxelsOfOne(), kBone, sphereWindow(1));
      else
        digitizer.run(mesh, voxelsOfOne());
    };
    run(small);
    ASSERT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
    run(large);
    ASSERT_FALSE(digitizer.deviceReport().onDevice);
    EXPECT_NE(digitizer.message().find("MB on the device"), std::string::npos)
        << digitizer.message();
    EXPECT_EQ(digitizer.deviceBytes(), 0u);
    run(small);
    EXPECT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
    EXPECT_EQ(digitizer.cloud().voxels().coverage,
              digitize(small, voxelsOfOne()).voxels().coverage);
  }
}

// A field asks for no more blocks than there are bricks, and is judged by what it asks for.
TEST(DeviceFailure, AFieldsBlocksAreCountedBeforeTheyAreAskedFor) {
  const Mesh box = boxMesh({-10, -10, -10}, {10, 10, 10});
  const std::size_t bricks = 64;
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  digitizer.run(box, voxelsOfOne());
  ASSERT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
  const std::size_t before = digitizer.deviceBytes();
  digitizer.run(box, voxelsOfOne(), kBone, sphereWindow(1));
  ASSERT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
  ASSERT_LE(std::size_t(digitizer.field().bricks().table.size()), bricks);
  // Each of them 21 kB; a quarter more is kept.
  EXPECT_LT(digitizer.deviceBytes() - before, 1.25 * (bricks + 1) * sizeof(FieldBlock) + 1e5);
}

// What throws before anything is cut leaves the workpiece as it was.
TEST(DeviceFailure, BeforeACutLeavesTheWorkpiece) {
  BaseVectorField cpu = ballField();
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl});
  SKIP_WITHOUT(piece);
  const std::vector<VoxelCut> outside{{{12, 12, 12}, 0}, {{24, 0, 0}, 0}}, cuts{{{9, 9, 9}, 7}};
  EXPECT_THROW(piece.cut(outside), std::out_of_range);
  EXPECT_THROW(piece.cut(SphereArea{}, Pose{}), std::invalid_argument);
  EXPECT_EQ(piece.cut(cuts), cpu.cut(cuts));
  EXPECT_EQ(piece.field().hash(), cpu.hash());
}

// Two balls that touch, many times.
struct Balls {
  testing::BodyMaker maker{5e-4, testing::Random(2)};
  testing::Body ball = maker.sphere(8);
  std::vector<BatchPair> pairs;
  ContactFinder finder;

  explicit Balls(std::size_t count) {
    Pose pose;
    pose.position = Vec3(15.5 * maker.voxel, 0, 0);
    pairs.assign(count, {ball.at({}), ball.at(pose), {}});
  }
  void expectFound(ContactBatch& batch) {
    const ContactResult& want = finder.find(pairs[0].a, pairs[0].b, pairs[0].settings);
    EXPECT_FALSE(want.points.empty());
    for (const ContactResult* result : batch.find(pairs))
      testing::expectSame(*result, want, testing::Ids::Ignored);
  }
};

// What does not fit at once is asked in halves, and these do not find the room taken.
TEST(DeviceFailure, PairsThatDoNotFitAtOnceFitInHalves) {
  ContactBatch batch({Backend::OpenCl, 2, false});
  SKIP_WITHOUT(batch);
  Balls balls(100);
  balls.expectFound(batch);
  EXPECT_EQ(batch.report().onDevice, 100u);
  const std::size_t before = batch.deviceBytes();
  Balls more(400);
  {
    const LittleMemory little(8 << 20);  // the hits of some 25 pairs
    more.expectFound(batch);
    EXPECT_EQ(batch.report().onDevice, 400u);
    EXPECT_EQ(batch.report().noRoom, 0u);
  }
  EXPECT_LT(batch.deviceBytes(), 2 * before);
  more.expectFound(batch);
  EXPECT_EQ(batch.report().onDevice, 400u);
}

// Whatever a batch has begun when the device fails, the next is found.
TEST(DeviceFailure, InTheMidstOfABatchIsTold) {
  ContactBatch batch({Backend::OpenCl, 2, false});
  SKIP_WITHOUT(batch);
  Balls balls(3);
  for (int after : {0, 1, 4, 7})
    expectTold(
        "clEnqueueNDRangeKernel", batch.device(), [&] { batch.find(balls.pairs); }, after);
  for (const char* call : {"clEnqueueWriteBuffer", "clEnqueueReadBuffer"})
    expectTold(call, batch.device(), [&] { batch.find(balls.pairs); });
  EXPECT_FALSE(calls.underWay);
  balls.expectFound(batch);
  EXPECT_EQ(batch.report().onDevice, 3u);
}

}  // namespace
}  // namespace cloudcontact::test
