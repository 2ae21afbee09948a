// A device that fails half-way: what callers are told, and what is left.
#include <cloudcontact/device_cut.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "device_wanted.h"
#include "opencl_faults.h"
#include "small_clouds.h"
#include "test_meshes.h"

namespace cloudcontact::test {
namespace {

const TissueTable kBone{{"bone", 2e4, .4, 3e9, 2970}};

#define SKIP_WITHOUT(runner)                                  \
  if (mayDoWithout(runner)) GTEST_SKIP() << runner.message(); \
  ASSERT_EQ(runner.backend(), Backend::OpenCl) << runner.message()

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

}  // namespace
}  // namespace cloudcontact::test
