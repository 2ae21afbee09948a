// The laboratory's cases on OpenCL: contacts equal to the CPU's to the bit, in every pose.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/voxels/digitize.h>

#include <deque>
#include <memory>

#include "contact/same_contact.h"
#include "device/skip_without_device.h"
#include "lab/cases.h"
#include "lab/lab_meshes.h"

namespace cloudcontact::testing::lab_device_test {
namespace {

using namespace program::lab;

constexpr double kVoxels = 12;  // size of a case / voxel

// The pairs of all cases, with the fields and shapes that they refer to.
struct Laboratory {
  std::vector<std::shared_ptr<const SurfaceField>> fields;
  std::deque<Solid> shapes;
  std::vector<BatchPair> pairs;
  std::vector<std::string> names;

  ContactBody bodyOf(const LabBody& body, double voxel) {
    ContactBody made{};
    made.pose = body.grid;
    if (!body.mesh) {
      made.pose = Pose{};
      made.shape = &shapes.emplace_back(*body.shape);
      return made;
    }
    DigitizeSettings settings;
    settings.voxelSize = voxel;
    fields.push_back(SurfaceField::build(
        digitize(moved(body.mesh(0.01 * voxel), body.grid.inverse()), settings)));
    made.field = fields.back().get();
    return made;
  }

  Laboratory() {
    for (const LabCase& one : allCases()) {
      const Instance instance = one.make(1);
      const double voxel = one.size / kVoxels;
      const ContactBody a = bodyOf(instance.a, voxel), b = bodyOf(instance.b, voxel);
      for (const Placement& placement : instance.placements) {
        BatchPair& pair = pairs.emplace_back(BatchPair{a, b, {}});
        pair.b.pose = placement.b * b.pose;
        names.push_back(one.family + ", " + one.name);
      }
    }
  }
};

TEST(Laboratory, OnOpenClEqualsTheCpu) {
  ContactBatch batch({Backend::OpenCl, 2});
  SKIP_WITHOUT(batch);
  const Laboratory laboratory;
  // The first call sizes the buffers; in the second every pair has room.
  batch.find(laboratory.pairs);
  const auto results = batch.find(laboratory.pairs);
  std::size_t touching = 0;
  for (std::size_t k = 0; k < laboratory.pairs.size(); ++k) {
    SCOPED_TRACE(laboratory.names[k]);
    const BatchPair& pair = laboratory.pairs[k];
    ContactFinder finder;
    finder.find(pair.a, pair.b, pair.settings);
    const ContactResult& want = finder.find(pair.a, pair.b, pair.settings);
    expectSame(*results[k], want);
    touching += !want.points.empty();
  }
  const BatchReport& report = batch.report();
  std::printf("%zu pairs, %zu touch: %zu on the device, of the others %zu shapes, %zu no room\n",
              laboratory.pairs.size(), touching, report.onDevice, report.shapes, report.noRoom);
  EXPECT_EQ(touching, laboratory.pairs.size());
  EXPECT_EQ(report.onDevice + report.shapes, laboratory.pairs.size());
}

}  // namespace
}  // namespace cloudcontact::testing::lab_device_test
