// Sums of hits, four numbers at a time (kernels/hit_sums.h). In double, which costs no more than
// float here, and in lengths of the hits' own size.
#include "sums.h"

#include "simd.h"

#include <cstddef>
#include <cstring>

namespace cloudcontact {

namespace {

CcAdded added(const CcAdding& from) {
  CcAdded sums;
  static_assert(offsetof(CcAdding, middle) == CC_ADDED_FOURS * sizeof(CcFour));
  std::memcpy(&sums, &from, CC_ADDED_FOURS * sizeof(CcFour));
  sums.middle = from.middle;
  sums.deepest = static_cast<double>(from.deepest);
  return sums;
}

}  // namespace

CC_LANES void addHits(const HitColumns& hits, const float* gate, const std::uint32_t* first,
                      const std::uint32_t* last, bool oneSided, double unit, Sums& sums) {
  const HitColumns::Columns<const float> c = hits.columns();
  const Vec3 origin = sums.origin;
  const double perUnit = 1 / unit;
  while (first != last) {
    CcAdding adding = ccNothingAdded();
    const Side side = hits.side(*first);
    const std::uint32_t* end = first;
    for (; end != last && hits.side(*end) == side; ++end) {
      const std::size_t i = *end;
      const float at[3] = {c.x[i], c.y[i], c.z[i]}, own[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]},
                  other[3] = {c.otherX[i], c.otherY[i], c.otherZ[i]};
      const CcWet wet{c.share[i], 0, c.depth1[i], c.depth2[i], c.depth3[i]};
      if (oneSided)
        ccAddHit(&adding, at, own, other, c.area[i], &wet, c.depth[i], gate[i], origin.data(),
                 perUnit, 1);
      else
        ccAddHit(&adding, at, own, other, c.area[i], &wet, c.depth[i], gate[i], origin.data(),
                 perUnit, 0);
      if (hits.deep(i)) sums.deep += static_cast<double>(c.area[i]) * c.depth1[i];
    }
    const CcAdded all = added(adding);
    ccGive(reinterpret_cast<CcSums*>(&sums), &all, static_cast<int>(end - first), oneSided, side,
           unit);
    first = end;
  }
}

void Sums::add(const Sums& other) {
  ccJoinSums(reinterpret_cast<CcSums*>(this), reinterpret_cast<const CcSums*>(&other));
}

}  // namespace cloudcontact
