// StayingApart: whether a pair that had nothing in its last step can have anything in this one.
// Most pairs of a heap whose boxes meet cannot, and cost no query.
#pragma once

#include "bullet/pair_query.h"
#include "contact/kept_gap.h"

struct btDispatcherInfo;

namespace cloudcontact {

class StayingApart {
 public:
  // After a step; `clear`: its query found nothing, and no other step would have to be told.
  void keep(const PairQuery& query, bool clear);
  void forget() { voxel_ = 0; }
  // Whether the bodies are too far from each other for this step to find more, by their boxes or by
  // the gap that is kept. Such a step changes nothing.
  bool holds(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
             const btDispatcherInfo& info) const;
  std::size_t compared() const { return gap_.compared(); }  // see KeptGap

 private:
  double voxel_ = 0;  // [m] of the last step's query; 0: it found something
  KeptGap gap_;       // of two clouds, while these live
  std::shared_ptr<const void> lives_[2];
};

}  // namespace cloudcontact
