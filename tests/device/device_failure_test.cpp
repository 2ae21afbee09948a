// A device that fails half-way: the exceptions, and what is left afterwards.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/device/device_workpiece.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "contact/contact_cases.h"
#include "contact/same_contact.h"
#include "device/opencl_faults.h"
#include "device/skip_without_device.h"
#include "field/base_vector_bricks.h"
#include "mesh/test_meshes.h"
#include "voxels/small_clouds.h"

namespace cloudcontact::test::device_failure_test {
namespace {

const TissueTable kBone{{"bone", 2e4, .4, 3e9, 2970}};

DigitizeSettings voxelsOfOne() {
  DigitizeSettings settings;
  settings.voxelSize = 1;
  return settings;
}

// Expects a std::runtime_error that names the device and the failing call.
void expectFailure(const char* call, const std::string& device, const std::function<void()>& work,
                   int after = 0) {
  SCOPED_TRACE(call);
  const Fault fault(call, after);
  try {
    work();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find(device), std::string::npos) << message;
    EXPECT_NE(message.find(call), std::string::npos) << message;
  } catch (const std::exception& e) {
    ADD_FAILURE() << "no runtime_error: " << e.what();
  }
}

// Expects the exception of a workpiece whose cut failed half-way.
void expectLost(const std::function<void()>& work) {
  try {
    work();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("create the workpiece again"), std::string::npos)
        << e.what();
  }
}

TEST(DeviceFailure, DigitizerThrowsRuntimeError) {
  Digitizer digitizer({Backend::OpenCl, true});
  SKIP_WITHOUT(digitizer);
  const std::string& name = digitizer.device();
  const Mesh ball = sphereMesh(8, 3);
  expectFailure("clEnqueueNDRangeKernel", name, [&] { digitizer.run(ball, voxelsOfOne()); });
  digitizer.run(ball, voxelsOfOne(), kBone, sphereWindow(1));
  ASSERT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
  expectFailure("clEnqueueReadBuffer", name, [&] { digitizer.cloud(); });
  expectFailure("clEnqueueReadBuffer", name, [&] { digitizer.field(); });
  expectFailure("clEnqueueReadBuffer", name, [&] { DeviceWorkpiece{digitizer}; });
  expectFailure("clEnqueueWriteBuffer", name, [&] { DeviceWorkpiece{digitizer}; });
  expectFailure("clFinish", name, [&] { digitizer.deviceTimes(); });
  // The results are still there.
  const Cloud want = digitize(ball, voxelsOfOne());
  EXPECT_EQ(digitizer.cloud().voxels().coverage, want.voxels().coverage);
  EXPECT_EQ(digitizer.field().hash(), BaseVectorField(want, kBone, sphereWindow(1)).hash());
}

// The driver cannot even report the device's name or type.
TEST(DeviceFailure, BrokenDriverFallsBackToCpu) {
  for (const char* property : {"its name", "its type"}) {
    SCOPED_TRACE(property);
    const Fault fault(property);
    Digitizer digitizer({Backend::OpenCl});
    EXPECT_EQ(digitizer.backend(), Backend::Cpu);
    EXPECT_NE(digitizer.message().find("no OpenCL device"), std::string::npos)
        << digitizer.message();
  }
}

BaseVectorField ballField() {
  return {ballCloud(1, 3, Vec3(12.2, 11.9, 12.1), 10), kBone, sphereWindow(1)};
}

// After a failure in any of a cut's kernels, nothing more is cut, and no transfer is pending.
TEST(DeviceFailure, DuringACutLosesTheWorkpiece) {
  const std::vector<VoxelCut> cuts{{{12, 12, 12}, 0}, {{12, 12, 12}, 9}, {{12, 13, 12}, 0}};
  const PlacedSolid area = {Sphere{3}, {.position = Vec3(12, 12, 12)}};
  for (const int after : {0, 1, 2}) {  // kernels that still run, of three
    for (const bool pass : {false, true}) {
      SCOPED_TRACE(std::to_string(after) + (pass ? " of a tool's pass" : " of a list of voxels"));
      DeviceWorkpiece piece(ballField(), {Backend::OpenCl});
      SKIP_WITHOUT(piece);
      ASSERT_EQ(piece.cut(cuts), 2u);  // so that a tool's pass has three kernels, too
      const auto cut = [&] { pass ? piece.cut(area, Pose{}) : piece.cut(cuts); };
      expectFailure("clEnqueueNDRangeKernel", piece.device(), cut, after);
      EXPECT_FALSE(calls.pending);
      expectLost([&] { piece.cut(cuts); });
      expectLost([&] { piece.cut(area, Pose{}); });
      expectLost([&] { piece.field(); });
      expectLost([&] { piece.mass(); });
    }
  }
}

// field() frees the memory it reads into, so it waits before it throws.
TEST(DeviceFailure, DuringADownloadIsWaitedFor) {
  const BaseVectorField cpu = ballField();
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl});
  SKIP_WITHOUT(piece);
  // The table, the shared block, then the bricks' own blocks.
  for (const int after : {0, 1, 2}) {
    expectFailure(
        "clEnqueueReadBuffer", piece.device(), [&] { piece.field(); }, after);
    EXPECT_FALSE(calls.pending) << after;
  }
  EXPECT_EQ(piece.field().hash(), cpu.hash());
}

// The mesh is being uploaded when the field is rejected or a kernel fails. The next mesh uses the
// same memory.
TEST(DeviceFailure, DuringDigitizingIsWaitedFor) {
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  const Mesh ball = sphereMesh(8, 3);
  EXPECT_THROW(digitizer.run(ball, voxelsOfOne(), TissueTable{}, sphereWindow(1)),
               std::invalid_argument);
  EXPECT_FALSE(calls.pending);
  expectFailure("clEnqueueNDRangeKernel", digitizer.device(),
                [&] { digitizer.run(ball, voxelsOfOne()); });
  EXPECT_FALSE(calls.pending);
  EXPECT_THROW(digitizer.cloud(), std::logic_error);
  digitizer.run(ball, voxelsOfOne());
  EXPECT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
  EXPECT_EQ(digitizer.cloud().voxels().coverage, digitize(ball, voxelsOfOne()).voxels().coverage);
}

// The device cannot run the kernels.
TEST(DeviceFailure, SmallWorkGroupsFallBackToCpu) {
  const FakeInfo largest(CL_DEVICE_MAX_WORK_GROUP_SIZE, 128);
  const DeviceWorkpiece piece(ballField(), {Backend::OpenCl});
  if (maySkip(piece)) GTEST_SKIP() << piece.message();
  EXPECT_EQ(piece.backend(), Backend::Cpu);
  EXPECT_NE(piece.message().find("128 work-items"), std::string::npos) << piece.message();
}

TEST(DeviceFailure, LittleLocalMemorySelectsTheSlowKernels) {
  const FakeInfo little(CL_DEVICE_LOCAL_MEM_SIZE, 8192);
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

// A kernel that was never enqueued is left out of the times; the others are reported.
TEST(DeviceFailure, KeepsTheTimesOfOtherKernels) {
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl, true});
  SKIP_WITHOUT(piece);
  const std::vector<VoxelCut> cuts{{{9, 9, 9}, 7}};
  piece.deviceTimes();
  expectFailure(
      "clEnqueueNDRangeKernel", piece.device(), [&] { piece.cut(cuts); }, 1);
  const std::map<std::string, DeviceTime> times = piece.deviceTimes();
  EXPECT_EQ(times.at("ccStringCuts").calls, 1);
  EXPECT_EQ(times.count("ccNoteLosses"), 0u);
  EXPECT_TRUE(piece.deviceTimes().empty());
}

// If nobody calls deviceTimes(), events are released on the way, and no time is lost.
TEST(DeviceFailure, UnreadTimesDoNotPileUp) {
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl, true});
  SKIP_WITHOUT(piece);
  const std::vector<VoxelCut> cuts{{{0, 0, 0}, 7}};
  piece.deviceTimes();
  const int released = calls.eventsReleased, count = 2000;
  for (int k = 0; k < count; ++k) piece.cut(cuts);
  EXPECT_GT(calls.eventsReleased - released, count);
  const std::map<std::string, DeviceTime> times = piece.deviceTimes();
  for (const char* label : {"step sent", "ccStringCuts", "ccNoteLosses", "ccRenewWindows"})
    EXPECT_EQ(times.at(label).calls, count) << label;
}

// A mesh that does not fit on the device leaves no memory in use there.
TEST(DeviceFailure, SmallMeshAfterATooLargeOneRunsOnTheDevice) {
  const FakeInfo largest(CL_DEVICE_MAX_MEM_ALLOC_SIZE, 20 << 20);
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

// A field reserves no more blocks than there are bricks.
TEST(DeviceFailure, FieldReservesAtMostOneBlockPerBrick) {
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
  // 21 kB each, plus a quarter of reserve.
  EXPECT_LT(digitizer.deviceBytes() - before, 1.25 * (bricks + 1) * sizeof(FieldBlock) + 1e5);
}

// An exception before anything is cut leaves the workpiece unchanged.
TEST(DeviceFailure, BadInputLeavesTheWorkpiece) {
  BaseVectorField cpu = ballField();
  DeviceWorkpiece piece(ballField(), {Backend::OpenCl});
  SKIP_WITHOUT(piece);
  const std::vector<VoxelCut> outside{{{12, 12, 12}, 0}, {{24, 0, 0}, 0}}, cuts{{{9, 9, 9}, 7}};
  EXPECT_THROW(piece.cut(outside), std::out_of_range);
  EXPECT_THROW(piece.cut(PlacedSolid{}, Pose{}), std::invalid_argument);
  EXPECT_EQ(piece.cut(cuts), cpu.cut(cuts));
  EXPECT_EQ(piece.field().hash(), cpu.hash());
}

// Many pairs of the same two touching balls.
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

// Pairs that do not fit together run in halves, after their memory was freed.
TEST(DeviceFailure, PairsThatDoNotFitTogetherRunInHalves) {
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

// After a failure in any kernel or transfer, the next batch succeeds.
TEST(DeviceFailure, DuringABatchIsReported) {
  ContactBatch batch({Backend::OpenCl, 2, false});
  SKIP_WITHOUT(batch);
  Balls balls(3);
  for (int after : {0, 1, 4, 7})
    expectFailure(
        "clEnqueueNDRangeKernel", batch.device(), [&] { batch.find(balls.pairs); }, after);
  for (const char* call : {"clEnqueueWriteBuffer", "clEnqueueReadBuffer"})
    expectFailure(call, batch.device(), [&] { batch.find(balls.pairs); });
  EXPECT_FALSE(calls.pending);
  balls.expectFound(batch);
  EXPECT_EQ(batch.report().onDevice, 3u);
}

}  // namespace
}  // namespace cloudcontact::test::device_failure_test
