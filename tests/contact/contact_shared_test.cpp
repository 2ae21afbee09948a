// A large search divided into tasks finds the same bits, whatever the order of the tasks.
#include <cloudcontact/contact/paper_body.h>
#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::contact_shared_test {
namespace {

constexpr double kVoxel = 1e-3;

struct Runner {
  const char* name;
  TaskRunner run;
};

// Runs the tasks in reverse order, and all at the same time.
const Runner kRunners[] = {{"backwards",
                            [](int count, const std::function<void(int)>& task) {
                              for (int i = count - 1; i >= 0; --i) task(i);
                            }},
                           {"at once", [](int count, const std::function<void(int)>& task) {
                              std::vector<std::jthread> threads;
                              for (int i = 0; i < count; ++i)
                                threads.emplace_back([&task, i] { task(i); });
                            }}};

void append(std::vector<double>& bits, const Vec3& v) {
  bits.insert(bits.end(), {v.x(), v.y(), v.z()});
}

std::vector<double> bitsOf(const ContactResult& found) {
  std::vector<double> bits{double(found.samples), double(found.patches.size())};
  for (const Patch& p : found.patches) {
    append(bits, p.position);
    append(bits, p.normal);
    bits.insert(bits.end(), {p.depth, p.stiffness, p.damping, p.area, p.confidence, double(p.doubt),
                             double(p.firstPoint), double(p.points)});
  }
  for (const ContactPoint& p : found.points) {
    append(bits, p.position);
    append(bits, p.normal);
    bits.insert(bits.end(), {p.depth, p.stiffness, p.damping, double(p.id), double(p.patch)});
  }
  return bits;
}

class SharedSearch : public ::testing::Test {
 protected:
  // Two crossed slabs with 25,000 samples per face, on different grids.
  static const Body& slab() {
    static const Body body = [] {
      BodyMaker maker{kVoxel, Random(5)};
      return maker.box(Vec3(160, 150, 16));
    }();
    return body;
  }
  static ContactBody at(const Vec3& voxels, double turn) {
    Pose pose;
    pose.position = kVoxel * voxels;
    pose.orientation = Eigen::AngleAxisd(turn, Vec3::UnitZ());
    return slab().at(pose);
  }

  void expectSame(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                  bool touches = true) {
    ContactFinder alone;
    const std::vector<double> wanted = bitsOf(alone.find(a, b, settings));
    EXPECT_GT(wanted[1], 0) << "no patches";
    EXPECT_EQ(wanted[0] > 0, touches);
    for (const Runner& runner : kRunners) {
      ContactFinder finder;
      for (int again = 0; again < 2; ++again) {
        int shared = 0;
        const TaskRunner counting = [&](int count, const std::function<void(int)>& task) {
          shared += count;
          runner.run(count, task);
        };
        ContactResult result;
        finder.search(a, b, settings, result, &counting);
        finder.giveIds(result);
        const std::vector<double> found = bitsOf(result);
        EXPECT_GT(shared, 3) << "nothing was shared out";
        ASSERT_EQ(found.size(), wanted.size()) << runner.name;
        EXPECT_EQ(std::memcmp(found.data(), wanted.data(), sizeof(double) * wanted.size()), 0)
            << runner.name;
      }
    }
  }
};

ContactSettings foundation() {
  ContactSettings settings;
  settings.law = Foundation{1e9, 1e5};  // uses all samples
  return settings;
}

TEST_F(SharedSearch, FacesAndEdges) {
  expectSame(at({0, 0, 0}, 0), at({11, 7, 15.4}, 0.4), foundation());
}

TEST_F(SharedSearch, SamplesBelowTheBand) {
  expectSame(at({0, 0, 0}, 0), at({11, 7, 8.2}, 0.4), foundation());
}

TEST_F(SharedSearch, AShapeBeside) {
  const Body box = BodyMaker::shape(Box{kVoxel * Vec3(90, 90, 10)});
  Pose pose;
  pose.position = kVoxel * Vec3(20, 11, 17.5);
  pose.orientation = Eigen::AngleAxisd(0.3, Vec3::UnitZ());
  expectSame(at({0, 0, 0}, 0), box.at(pose), foundation());
}

// The hits by which voxels find their patches are found by several tasks.
TEST_F(SharedSearch, StatedWindows) {
  const PaperBody paper = paperBody(slab().field->cloud(), {});
  ContactBody a = at({0, 0, 0}, 0), b = at({11, 7, 8.2}, 0.4);
  a.paper = b.paper = &paper;
  expectSame(a, b, foundation());
  b = at({11, 7, 15.4}, 0.4);
  b.paper = &paper;
  expectSame(a, b, foundation());
}

}  // namespace
}  // namespace cloudcontact::testing::contact_shared_test
