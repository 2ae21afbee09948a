// MovedContact: a pair's last contact, moved with the bodies instead of searched again. To first
// order in the bodies' relative motion, a point follows both bodies in the mean, its normal turns
// with both in the mean, and its depth grows by how far they approach each other along it. Shares
// of stiffness, patches and IDs stay.
//
// It holds as long as no point of either body has moved farther relative to the other than a
// tolerance, wherever the two may touch. What the contact lacks, as a corner that just arrives, is
// then no deeper than that. A pair that moves through the world as one is at rest.
#pragma once

#include <cloudcontact/contact/contact.h>

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
  // Counts a step in which move() answered.
  void age() { ++age_; }

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
  Pose poses_[2];  // at keep()
  Reach reaches_[2];
  double tolerance_ = 0;  // [m] 0 to `most`
  int age_ = 0;           // steps since keep()
  double free_ = 0;       // [m] of an empty contact: the bodies are at least this far apart
  ContactResult found_;
};

}  // namespace cloudcontact
