// Contacts are stored once while there is no visible change, and each frame shows the right ones.
#include "replay/replay_contacts.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cloudcontact::program::replay_contacts_test {
namespace {

constexpr double kStill = 1e-4;  // [m]

// Body 0 rests on the fixed body 2 with four points; body 1 slides on it under growing pressure.
ContactsNow at(double time) {
  ContactsNow now;
  now.patches = {{0, 2, 0, 4}, {2, 1, 4, 1}};
  for (int k = 0; k < 4; ++k)
    now.points.push_back({Vec3(k % 2, k / 2, 1e-7 * std::sin(40 * time + k)), -Vec3::UnitZ(),
                          Vec3(0, 0, -2.5 - 1e-3 * std::sin(50 * time)), 1e-5});
  now.points.push_back(
      {Vec3(0.002 * time, 0, 0), Vec3::UnitZ(), Vec3(0, 0, 3 + time), 1e-5 * (1 + time)});
  return now;
}

// Checks the number of points in a frame, and that each is within the invisible difference.
void expectShown(const ReplayContacts& contacts, std::size_t frame, double time) {
  const ContactsNow truth = at(time);
  const auto shown = contacts.shownAt(frame);
  ASSERT_EQ(shown.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    const ReplayPatch& patch = contacts.patches()[shown[k]];
    EXPECT_EQ(patch.a, 2);  // the fixed body comes first
    EXPECT_EQ(patch.b, int(k));
    EXPECT_NEAR(patch.normal.z(), 1, 1e-6);
    const auto points = contacts.of(patch);
    const auto expected = truth.of(truth.patches[k]);
    ASSERT_EQ(points.size(), expected.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 up = (k == 0 ? -1 : 1) * expected[i].force;  // on the moving body
      EXPECT_LE((points[i].position.cast<double>() - expected[i].position).norm(), 1.01 * kStill);
      EXPECT_LE((points[i].force.cast<double>() - up).norm(), 0.006 * up.norm());
      EXPECT_NEAR(points[i].depth, expected[i].depth, 0.006 * expected[i].depth);
    }
  }
}

ReplayContacts recorded(int frames) {
  ReplayContacts contacts(kStill);
  for (int f = 0; f < frames; ++f) contacts.add(at(f / 60.0), {false, false, true});
  return contacts;
}

TEST(ReplayContacts, AreThoseOfEachFrame) {
  const ReplayContacts contacts = recorded(300);
  ASSERT_EQ(contacts.frames(), 300u);
  for (std::size_t f = 0; f < 300; ++f) expectShown(contacts, f, double(f) / 60);
}

TEST(ReplayContacts, RestingContactsAreStoredOnce) {
  const ReplayContacts contacts = recorded(300);
  std::size_t resting = 0, sliding = 0;
  for (const ReplayPatch& patch : contacts.patches()) ++(patch.b == 0 ? resting : sliding);
  EXPECT_EQ(resting, 1u);
  EXPECT_GT(sliding, 40u);  // its force grows by 170 % in steps of half a percent at most
  EXPECT_EQ(contacts.points().size(), 4 * resting + sliding);
}

TEST(ReplayContacts, ThinningKeepsEveryOtherFrame) {
  ReplayContacts contacts = recorded(301);
  const std::size_t before = contacts.patches().size();
  contacts.thin();
  ASSERT_EQ(contacts.frames(), 151u);
  for (std::size_t f = 0; f < 151; ++f) expectShown(contacts, f, double(f) / 30);
  EXPECT_LE(contacts.patches().size(), before);
  contacts.add(at(301 / 60.0), {false, false, true});  // goes on
  expectShown(contacts, 151, 301 / 60.0);
}

// When a contact ends, the others move up in Bullet's list.
TEST(ReplayContacts, EndedContactsAreNotShown) {
  ReplayContacts contacts = recorded(10);
  ContactsNow now = at(10 / 60.0);
  now.patches.erase(now.patches.begin());
  contacts.add(now, {false, false, true});
  ASSERT_EQ(contacts.shownAt(10).size(), 1u);
  EXPECT_EQ(contacts.patches()[contacts.shownAt(10)[0]].b, 1);
  contacts.add({}, {false, false, true});
  EXPECT_TRUE(contacts.shownAt(11).empty());
}

}  // namespace
}  // namespace cloudcontact::program::replay_contacts_test
