// WayOut: how a body leaves a cloud that it is deep in, or wholly, where no surface is near enough
// to tell a normal.
//
// Points of the smaller body are moved on straight lines through the other's voxels. The length of
// a way is that of the first place where none of them is in matter. Of 26 directions of the cloud's
// frame the shortest is taken, and turned to shorter ones nearby.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <stdexcept>
#include <vector>

namespace cloudcontact {

class WayOut {
 public:
  // Whether half of the smaller body's points are in the larger one, which is a field, or a smaller
  // shape's middle. False for
  // pairs that WayOut does not answer: a cloud in a shape, whose surface is known at any depth.
  bool isInside(const ContactBody& a, const ContactBody& b);

  // Finds the shortest way, or follows the last one, which has turned with the bodies. False if the
  // bodies are apart.
  bool find(const ContactBody& a, const ContactBody& b);
  bool follow(const ContactBody& a, const ContactBody& b);
  // Of the last find() or follow(): a point with the way as its depth, in the smaller body's
  // middle.
  const ContactPoint& push() const { return push_; }
  double length() const { return length_; }  // [m], to a voxel
  // What follow() goes on from, for files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    archive(direction_, steps_);
    if (!direction_.allFinite() || steps_ < 0 || steps_ > kMostSteps)
      throw std::runtime_error("a record has a way out that is none");
  }

 private:
  bool set(const ContactBody& a, const ContactBody& b);
  bool inMatter(const Vec3& x) const;
  // [voxels] `most` if it is not shorter.
  int lengthOf(const Vec3& direction, int most);
  void turn();
  void write(const ContactBody& a, const ContactBody& b);

  static constexpr int kMostSteps = 1 << 16;  // more than a cloud's diagonal has voxels

  const SurfaceField* field_ = nullptr;
  bool bMoves_ = false;       // the smaller body is B
  std::vector<Vec3> points_;  // of the smaller body, in voxels of the field's grid
  std::vector<char> taken_;
  Vec3 direction_ = Vec3::UnitZ();  // of the field's frame
  int steps_ = 0;
  double length_ = 0;
  ContactPoint push_;
};

}  // namespace cloudcontact
