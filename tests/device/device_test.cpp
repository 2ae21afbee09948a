// Which device a batch uses, and the message if there is none.
#include <cloudcontact/device/contact_batch.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "device/skip_without_device.h"

namespace cloudcontact::device_test {
namespace {

// The loader reads its list of drivers once per process, so each test runs in its own process
// (gtest_discover_tests).
TEST(Device, WithoutOneTheBatchFallsBackToCpu) {
  ::setenv("OCL_ICD_VENDORS", CLOUDCONTACT_SOURCE_DIR "/kernels", 1);  // no *.icd there
  ContactBatch batch({Backend::OpenCl, 1, false});
  EXPECT_EQ(batch.backend(), Backend::Cpu);
  EXPECT_NE(batch.message().find("on the CPU"), std::string::npos) << batch.message();
  EXPECT_NE(batch.message().find("OpenCL"), std::string::npos) << batch.message();
  EXPECT_NE(batch.message().find("install"), std::string::npos) << batch.message();
  EXPECT_TRUE(batch.device().empty());
  EXPECT_TRUE(batch.find({}).empty());
}

TEST(Device, CpuByChoiceHasNoMessage) {
  ContactBatch batch;
  EXPECT_EQ(batch.backend(), Backend::Cpu);
  EXPECT_TRUE(batch.message().empty());
}

TEST(Device, PassesItsSelfTest) {
  ContactBatch batch({Backend::OpenCl, 1, false});
  SKIP_WITHOUT(batch);
  EXPECT_FALSE(batch.device().empty());
  EXPECT_TRUE(batch.message().empty());
  EXPECT_TRUE(batch.find({}).empty());
}

}  // namespace
}  // namespace cloudcontact::device_test
