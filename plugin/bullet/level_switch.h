// LevelSwitch: the searches of a pair whose clouds have levels. Repeats a search with finer voxels
// where its contact asks for them, and keeps the pair's depth continuous where levels change, since
// a depth that jumps would feed energy in.
#pragma once

#include <cloudcontact/contact/contact_finder.h>

#include "bullet/pair_query.h"

namespace cloudcontact {

struct CloudContactSettings;

class LevelSwitch {
 public:
  // What is searched: `a` and `b` are those that `query` was read from.
  struct Pair {
    const CloudContactSettings& settings;
    const btCollisionObjectWrapper &a, &b;
    PairReader& reader;
    ContactFinder& finder;
  };

  // After a search of the query has found a contact: until it holds the tolerance. `step` [s]; 0: a
  // query that is no step, which leaves no trace.
  void settle(const Pair& pair, PairQuery& query, double step, ContactResult& found);
  // Gives the contact the depth that the levels of the last steps had. The difference fades away.
  void fade(ContactResult& found) const;
  bool fades() const { return left_ > 0; }

  double error() const { return error_; }           // [m] depthError() of the last contact
  std::size_t refined() const { return refined_; }  // searches that the last settle() repeated

  // For files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    archive(error_, offset_, left_, last_.depth, last_.inA, last_.inB, last_.normal);
  }

 private:
  // The last contact's deepest point, as both bodies carry it along.
  struct Deepest {
    double depth = 0;  // [m] 0: no contact
    Vec3 inA = Vec3::Zero(), inB = Vec3::Zero(), normal = Vec3::Zero();
  };
  static Deepest deepestOf(const PairQuery& query, const ContactResult& found);
  double movedDepth(const PairQuery& query) const;
  void jump(double by, double most, double step);

  double error_ = 0;
  std::size_t refined_ = 0;
  double offset_ = 0, left_ = 0;  // [m], and how long it lasts [s]
  Deepest last_;
};

}  // namespace cloudcontact
