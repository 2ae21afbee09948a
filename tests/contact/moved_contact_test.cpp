// A contact that is moved with its bodies against the contact that a search finds there: where the
// bodies move as one, where they approach, slide and turn; when it no longer holds; swapped.
#include "contact/moved_contact.h"

#include <cloudcontact/contact/contact_finder.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "contact/contact_cases.h"
#include "field/mesh_field.h"

namespace cloudcontact::testing::moved_contact_test {
namespace {

constexpr double kVoxel = 1e-3, kTolerance = 0.02 * kVoxel;

Pose at(const Vec3& position, const Vec3& turn = Vec3::Zero()) {
  Pose pose;
  pose.position = position;
  if (turn.norm() > 0) pose.orientation = Eigen::AngleAxisd(turn.norm(), turn.normalized());
  return pose;
}

// A slab and a block on it, or a ball, pressed in by a third of a voxel.
class MovedContactTest : public ::testing::TestWithParam<bool> {
 protected:
  MovedContactTest() {
    static const auto slab = fieldOf(boxMesh({0.05, 0.04, 0.01}), kVoxel);
    static const auto block = fieldOf(boxMesh({0.02, 0.016, 0.012}), kVoxel);
    static const auto ball = fieldOf(sphereMesh(0.01, 1e-5), kVoxel);
    top_.field = GetParam() ? ball.get() : block.get();
    base_.field = slab.get();
    const double height = GetParam() ? 0.01 : 0.006;
    top_.pose = at({0.003, 0.002, 0.005 + height - 0.3 * kVoxel}, {0, 0, 0.3});
    settings_.margin = kVoxel;
    settings_.law = KelvinVoigt{1e4, 3};
    found_ = finder_.find(top_, base_, settings_);
    trust(moved_, top_, base_, found_);
  }
  // Kept until its tolerance has grown to kTolerance: the contact foretells itself.
  void trust(MovedContact& kept, const ContactBody& a, const ContactBody& b,
             const ContactResult& found) const {
    for (int i = 0; i < 9; ++i) kept.keep(a, b, settings_, kTolerance, kVoxel, found);
  }
  ContactBody moved(const ContactBody& body, const Pose& motion) const {
    ContactBody there = body;
    there.pose = motion * body.pose;
    return there;
  }
  static ContactResult moved(const MovedContact& kept, const ContactBody& a, const ContactBody& b) {
    ContactResult there;
    kept.move(a, b, there);
    return there;
  }
  // The force on the base and its moment about the touch, without motion.
  Wrench pushOf(const ContactResult& contact) const {
    Wrench push = wrenchOnB(contact, {}, {});
    push.torque -= Vec3(0.003, 0.002, 0.005).cross(push.force);
    return push;
  }

  ContactFinder finder_, other_;
  ContactSettings settings_;
  ContactBody top_, base_;
  ContactResult found_;
  MovedContact moved_;
};

TEST_P(MovedContactTest, FollowsAPairThatMovesAsOne) {
  const Pose motion = at({0.4, -0.2, 0.1}, {0.7, -0.4, 1.1});
  const ContactBody a = moved(top_, motion), b = moved(base_, motion);
  ASSERT_TRUE(moved_.holds(a, b, settings_.margin));
  const ContactResult there = moved(moved_, a, b);
  ASSERT_EQ(there.points.size(), found_.points.size());
  ASSERT_GT(there.points.size(), 0u);
  for (std::size_t i = 0; i < there.points.size(); ++i) {
    const ContactPoint &p = there.points[i], &q = found_.points[i];
    EXPECT_LT((p.position - motion.toWorld(q.position)).norm(), 1e-12);
    EXPECT_LT((p.normal - motion.orientation * q.normal).norm(), 1e-12);
    EXPECT_NEAR(p.depth, q.depth, 1e-12);
    EXPECT_EQ(p.stiffness, q.stiffness);
    EXPECT_EQ(p.id, q.id);
  }
}

// Force within a hundredth of that of a voxel's depth, which the motion itself changes by twice
// that; the moment likewise, over the block's half width.
TEST_P(MovedContactTest, AgreesWithASearch) {
  const double far = 0.9 * kTolerance;
  const Pose motions[] = {at({0, 0, -far}),
                          at({0, 0, far}),
                          at({far, 0, 0}),
                          at({0.5 * far, -0.6 * far, 0.4 * far}),
                          at(Vec3(0, 0, 0), {0.4 * far / 0.03, 0, 0}),
                          at(Vec3(0, 0, 0), {0, -0.4 * far / 0.03, 0.3 * far / 0.03})};
  const double hard = sharedSpring(settings_.law).stiffness * kVoxel;
  for (const Pose& motion : motions) {
    ContactBody a = top_;
    a.pose.position += motion.position;
    a.pose.orientation = motion.orientation * a.pose.orientation;
    ASSERT_TRUE(moved_.holds(a, base_, settings_.margin));
    const Wrench push = pushOf(moved(moved_, a, base_));
    const Wrench truth = pushOf(other_.find(a, base_, settings_));
    EXPECT_LT((push.force - truth.force).norm(), 0.01 * hard) << motion.position.transpose();
    EXPECT_LT((push.torque - truth.torque).norm(), 0.01 * hard * 0.01);
  }
}

// The depth of each point grows by just how far the bodies approach.
TEST_P(MovedContactTest, DepthGrowsByTheApproach) {
  ContactBody a = top_;
  a.pose.position.z() -= 0.5 * kTolerance;
  const ContactResult there = moved(moved_, a, base_);
  for (std::size_t i = 0; i < there.points.size(); ++i) {
    const double approach = -0.5 * kTolerance * found_.points[i].normal.z();
    EXPECT_NEAR(there.points[i].depth - found_.points[i].depth, approach, 1e-12);
    EXPECT_NEAR(there.points[i].position.z() - found_.points[i].position.z(), -0.25 * kTolerance,
                1e-12);
  }
}

// Patches that touched when they were found are no near misses after a lift. Else no patch would
// bear the pair's spring.
TEST_P(MovedContactTest, ATouchThatIsLiftedIsNotBesideOne) {
  ContactBody light = top_, lifted = top_;
  light.pose.position.z() += 0.299 * kVoxel;
  lifted.pose.position.z() += 0.299 * kVoxel + 0.9 * kTolerance;
  const ContactResult found = finder_.find(light, base_, settings_);
  ASSERT_GT(found.samples, 0u);
  MovedContact kept;
  trust(kept, light, base_, found);
  const ContactResult there = moved(kept, lifted, base_);
  ASSERT_FALSE(there.patches.empty());
  for (const Patch& patch : there.patches) {
    EXPECT_LT(patch.depth, 0);
    EXPECT_FALSE(patch.beside);
  }
  EXPECT_NEAR(depthOf(there), depthOf(found) - 0.9 * kTolerance, 0.01 * kTolerance);
}

// A touch that is hardly deep holds for a part of its depth, a stiff body's sag.
TEST_P(MovedContactTest, ALightTouchHoldsForAPartOfItsDepth) {
  const double depth = 0.01 * kVoxel;
  ContactBody light = top_;
  light.pose.position.z() += 0.3 * kVoxel - depth;
  const ContactResult found = finder_.find(light, base_, settings_);
  ASSERT_GT(found.samples, 0u);
  MovedContact kept;
  trust(kept, light, base_, found);
  ContactBody near = light, far = light;
  near.pose.position.z() += 0.1 * depth;
  far.pose.position.z() += 0.5 * depth;
  EXPECT_TRUE(kept.holds(near, base_, settings_.margin));
  EXPECT_FALSE(kept.holds(far, base_, settings_.margin));
}

TEST_P(MovedContactTest, HoldsAsFarAsItsTolerance) {
  const Vec3 ways[] = {Vec3::UnitX(), Vec3::UnitZ(), Vec3(1, -2, 0.5).normalized()};
  for (const Vec3& way : ways)
    for (const bool mine : {false, true}) {
      ContactBody near[] = {top_, base_}, far[] = {top_, base_};
      near[mine].pose.position += 0.999 * kTolerance * way;
      far[mine].pose.position += 1.001 * kTolerance * way;
      EXPECT_TRUE(moved_.holds(near[0], near[1], settings_.margin));
      EXPECT_FALSE(moved_.holds(far[0], far[1], settings_.margin));
    }
  // A turn about the touch lifts the far corners of the block, where nothing has touched yet.
  ContactBody turned = top_;
  turned.pose.orientation =
      Eigen::AngleAxisd(3 * kTolerance / 0.02, Vec3::UnitY()) * turned.pose.orientation;
  EXPECT_FALSE(moved_.holds(turned, base_, settings_.margin));
  moved_.drop();
  EXPECT_FALSE(moved_.holds(top_, base_, settings_.margin));
}

TEST_P(MovedContactTest, IsTheSameForSwappedBodies) {
  ContactFinder finder;
  MovedContact other;
  trust(other, base_, top_, finder.find(base_, top_, settings_));
  ContactBody a = top_, b = base_;
  a.pose.position += Vec3(0.3, -0.4, -0.5) * kTolerance;
  b.pose.orientation = Eigen::AngleAxisd(0.1 * kTolerance / 0.03, Vec3(1, 2, 3).normalized());
  EXPECT_EQ(moved_.holds(a, b, settings_.margin), other.holds(b, a, settings_.margin));
  const Wrench push = pushOf(moved(moved_, a, b)), back = pushOf(moved(other, b, a));
  EXPECT_LT((push.force + back.force).norm(), 1e-5 * push.force.norm());
  EXPECT_LT((push.torque + back.torque).norm(), 1e-5 * push.force.norm() * 0.01);
}

// Apart by 1.4 voxels, with a margin of one: nothing is near until the motion uses up the rest.
TEST_P(MovedContactTest, NothingAppearsBeforeTheGapIsUsedUp) {
  ContactBody a = top_;
  a.pose.position.z() += 1.7 * kVoxel;
  ContactSettings wide = settings_;
  wide.margin = 2 * kVoxel;
  MovedContact apart;
  apart.keep(a, base_, wide, kTolerance, kVoxel, {});
  for (const double down : {0.0, 0.3, 0.8, 0.99}) {
    ContactBody lower = a;
    lower.pose.position.z() -= down * kVoxel;
    EXPECT_TRUE(apart.holds(lower, base_, kVoxel)) << down;
  }
  a.pose.position.z() -= 1.1 * kVoxel;
  EXPECT_FALSE(apart.holds(a, base_, kVoxel));
}

// A contact that is found where the moved one was not expected costs the pair its tolerance.
TEST_P(MovedContactTest, IsNotTrustedWhereItWasWrong) {
  ContactBody a = top_;
  a.pose.position.x() += 0.1 * kTolerance;
  EXPECT_TRUE(moved_.holds(a, base_, settings_.margin));
  ContactResult stiffer = found_;
  for (ContactPoint& p : stiffer.points) p.depth += 0.1 * kTolerance;
  for (int i = 0; i < 2; ++i) {
    moved_.keep(top_, base_, settings_, kTolerance, kVoxel, i == 0 ? stiffer : found_);
    a.pose.position.x() = top_.pose.position.x() + 0.3 * kTolerance;
    EXPECT_FALSE(moved_.holds(a, base_, settings_.margin));
  }
  trust(moved_, top_, base_, found_);
  EXPECT_TRUE(moved_.holds(a, base_, settings_.margin));
}

// A pair that hardly moves is searched now and then, so that it comes to the rest of the fresh one.
// One that has not moved is where it was searched.
TEST_P(MovedContactTest, GrowsOld) {
  ContactBody near = top_;
  near.pose.position.z() -= 0.1 * kTolerance;
  int held = 0;
  for (; moved_.holds(near, base_, settings_.margin) && held < 1000; ++held)
    moved_.age(near, base_);
  EXPECT_GT(held, 20);
  EXPECT_LT(held, 200);
  EXPECT_TRUE(moved_.holds(top_, base_, settings_.margin));
}

// What turns about its touch presses elsewhere, and what slides over a bend does: the center of
// pressure of a ball rolls on by its radius times the turn. The truth is what searches of all
// samples find on both sides. Of points that only follow the bodies, the ball's moment changes by
// an eighth of that, and its force leans with half of the turn.
struct Curved {
  std::string name;
  std::shared_ptr<const SurfaceField> a, b;
  Pose at;
  Vec3 touch;  // world [m]
};

// Balls beside each other as one body.
Mesh threeBalls(double radius, double apart) {
  Mesh all;
  for (int i = 0; i < 3; ++i) {
    const Mesh ball = sphereMesh(radius, 1e-5);
    const double angle = 2 * std::numbers::pi / 3 * i;
    const int first = static_cast<int>(all.vertices.size());
    for (const Vec3& v : ball.vertices)
      all.vertices.push_back(v + apart * Vec3(std::cos(angle), std::sin(angle), 0));
    for (Eigen::Vector3i t : ball.triangles) all.triangles.push_back(t.array() + first);
  }
  return all;
}

std::vector<Curved> curvedPairs() {
  const auto slab = fieldOf(boxMesh({0.05, 0.05, 0.012}), kVoxel);
  const auto ball = fieldOf(sphereMesh(0.012, 1e-5), kVoxel);
  const auto ring = [](double angle, double s) {
    const double turn = 2 * std::numbers::pi * s, r = 0.02 + 0.008 * std::cos(turn);
    return Vec3(r * std::cos(angle), r * std::sin(angle), 0.008 * std::sin(turn));
  };
  const auto link = fieldOf(revolvedMesh(160, 64, true, ring), kVoxel);
  const double over = 0.5 * kVoxel;
  return {{"a ball on a slab",
           ball,
           slab,
           at({0.0031, 0.0017, 0.018 - over}),
           {0.0031, 0.0017, 0.006 - over / 2}},
          {"a link in a link",
           link,
           link,
           at({0.024 + over, 0, 0}, std::numbers::pi / 2 * Vec3::UnitX()),
           {0.012 + over / 2, 0, 0}}};
}

// By how much the push of a pair changes from one side of a motion to the other, about its touch.
struct Change {
  Wrench moved, searched;
};

Change changeBy(const Pose& motion, const Curved& pair) {
  ContactSettings all;
  all.samples = SIZE_MAX;
  all.law = KelvinVoigt{1e4, 0};
  ContactBody a{}, b{};
  a.field = pair.a.get(), b.field = pair.b.get(), a.pose = pair.at;
  ContactFinder finder;
  MovedContact kept;
  kept.keep(a, b, all, kTolerance, kVoxel, finder.find(a, b, all));
  Change change;
  const auto add = [&](double sign, const ContactResult& contact, Wrench& to) {
    const Wrench push = wrenchOnB(contact, {}, {});
    to.force += sign * push.force;
    to.torque += sign * (push.torque - pair.touch.cross(push.force));
  };
  for (const double sign : {1.0, -1.0}) {
    ContactBody there = a;
    there.pose = (sign > 0 ? motion : motion.inverse()) * a.pose;
    ContactResult contact;
    kept.move(there, b, contact);
    add(sign, contact, change.moved);
    add(sign, finder.find(there, b, all), change.searched);
  }
  return change;
}

Pose turnAbout(const Vec3& place, const Vec3& turn) {
  Pose motion = at(Vec3::Zero(), turn);
  motion.position = place - motion.orientation * place;
  return motion;
}

TEST(MovedContact, RollsAndSlidesAsSearchesFind) {
  const double turn = 0.01, slide = 0.1 * kVoxel, force = 1e4 * 0.5 * kVoxel;
  for (const Curved& pair : curvedPairs())
    for (int k = 0; k < 6; ++k) {
      const Vec3 way = Vec3::Unit(k % 3);
      const Change change =
          changeBy(k < 3 ? turnAbout(pair.touch, turn * way) : at(slide * way), pair);
      const Wrench &is = change.moved, &truth = change.searched;
      EXPECT_LT((is.torque - truth.torque).norm(),
                0.06 * truth.torque.norm() + 0.05 * force * slide)
          << pair.name << ", " << k;
      EXPECT_LT((is.force - truth.force).norm(), 0.12 * truth.force.norm() + 0.6 * force * turn)
          << pair.name << ", " << k;
    }
}

// What rocks on balls: the force goes over from ball to ball by their volumes, which change twice
// as fast as their depths.
TEST(MovedContact, RocksOnBallsAsSearchesFind) {
  const double over = 0.5 * kVoxel;
  const Curved stool{"three balls on a slab",
                     fieldOf(threeBalls(0.008, 0.014), kVoxel),
                     fieldOf(boxMesh({0.05, 0.05, 0.012}), kVoxel),
                     at({0.0013, 0.0007, 0.014 - over}),
                     {0.0013, 0.0007, 0.006 - over / 2}};
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.6, 0.8, 0)}) {
    const Change change = changeBy(turnAbout(stool.touch, 0.003 * axis), stool);
    EXPECT_LT((change.moved.torque - change.searched.torque).norm(),
              0.1 * change.searched.torque.norm())
        << axis.transpose();
  }
}

// What stands on a near patch, some of whose points are in while the patch is not in the mean: once
// all are in, the force grows by k times the approach, as of any pair.
TEST(MovedContact, WhatWasNearIsPressedByTheWholeSpring) {
  const auto block = fieldOf(boxMesh({0.02, 0.016, 0.012}), kVoxel);
  const Solid plane = HalfSpace{};
  ContactBody top, base;
  top.field = block.get();
  base.shape = &plane;
  top.pose = at({0, 0, 0.006 + 0.02 * kVoxel});
  ContactSettings settings;
  settings.margin = kVoxel;
  settings.law = KelvinVoigt{1e4, 0};
  ContactFinder finder;
  ContactResult near = finder.find(top, base, settings);
  ASSERT_EQ(near.samples, 0u);
  ASSERT_EQ(near.patches.size(), 1u);
  for (ContactPoint& p : near.points) p.depth += (p.position.y() > 0 ? 0.03 : 0) * kVoxel;
  MovedContact kept;
  for (int i = 0; i < 9; ++i) kept.keep(top, base, settings, kTolerance, kVoxel, near);
  const auto forceAt = [&](double in) {
    ContactBody there = top;
    there.pose.position.z() -= in * kVoxel;
    ContactResult moved;
    kept.move(there, base, moved);
    double force = 0;
    for (const ContactPoint& p : moved.points) force += p.stiffness * std::max(0.0, p.depth);
    return force;
  };
  const double k = 1e4, first = forceAt(0.06), second = forceAt(0.09);
  EXPECT_NEAR(first, k * 0.055 * kVoxel, 0.02 * k * 0.055 * kVoxel);
  EXPECT_NEAR(second - first, k * 0.03 * kVoxel, 1e-3 * k * 0.03 * kVoxel);
}

INSTANTIATE_TEST_SUITE_P(Shapes, MovedContactTest, ::testing::Bool(),
                         [](const auto& which) { return which.param ? "Ball" : "Block"; });

}  // namespace
}  // namespace cloudcontact::testing::moved_contact_test
