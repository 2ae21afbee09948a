// MovedContact: a pair's last contact, moved with the bodies instead of searched again. To first
// order in the bodies' relative motion it is what a search would find (PatchTangent): a point
// follows both bodies in the mean, its depth grows by how far they approach each other along its
// normal, and patches share the pair's force by their volumes. Under what rolls, points and normals
// move on as the center of pressure does; without that a contact has an eighth of its stiffness
// against rolling, and links that hang from each other swing. Patches and IDs stay.
//
// It holds as long as no point of either body has moved farther relative to the other than a
// tolerance, wherever the two may touch. What the contact lacks, as a corner that just arrives, is
// then no deeper than that. A pair that moves through the world as one is at rest.
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/contact_archive.h"

namespace cloudcontact {

class MovedContact {
 public:
  // Keeps a contact that was searched with these bodies and settings. `most` [m]: the tolerance of
  // a pair whose moved contacts prove right; `voxel` [m].
  void keep(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
            double most, double voxel, const ContactResult& found);
  void drop() { kept_ = false; }
  // Whether the kept contact, moved, answers for the bodies where they are now. Fields, shapes and
  // laws must be those of keep().
  bool holds(const ContactBody& a, const ContactBody& b, double margin) const;
  // That contact.
  void move(const ContactBody& a, const ContactBody& b, ContactResult& there) const;
  std::size_t bytesKept() const { return found_.bytesKept(); }
  // By how much a depth of the moved contact may be wrong [m].
  double error(double voxel) const;
  // Counts a step in which move() answered, unless the bodies are where they were searched.
  void age(const ContactBody& a, const ContactBody& b) { age_ += !(moved(a, b) <= still_); }
  // For files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    archive(kept_, byArea_, tolerance_, limit_, still_, age_, free_);
    if (!kept_) return;
    for (int side = 0; side < 2; ++side) {
      archive(poses_[side].position, poses_[side].orientation.coeffs());
      archive(reaches_[side].center, reaches_[side].half);
    }
    contactIn(archive, found_);
  }

 private:
  // A box in one body's frame, outside of which the bodies cannot touch.
  struct Reach {
    Vec3 center = Vec3::Zero(), half = Vec3::Zero();
  };
  static Reach reachOf(const ContactBody& own, const ContactBody& other, double around);
  static double farthest(const Reach& reach, const Pose& motion);
  double moved(const ContactBody& a, const ContactBody& b) const;
  void learn(const ContactBody& a, const ContactBody& b, double most, double voxel,
             const ContactResult& found);

  bool kept_ = false;
  bool byArea_ = false;  // the law is a Foundation
  Pose poses_[2];        // at keep()
  Reach reaches_[2];
  double tolerance_ = 0;  // [m] 0 to `most`
  double limit_ = 0;      // [m] of the motion, by the depth
  double still_ = 0;      // [m] what has moved by less has not moved
  int age_ = 0;           // steps since keep() in which the pair had moved
  double free_ = 0;       // [m] of an empty contact: the bodies are at least this far apart
  ContactResult found_;
};

}  // namespace cloudcontact
