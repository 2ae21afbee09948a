// Many samples side by side, on their way into another body. What is known of each is in a column
// of its own, so that a loop over the columns becomes vector instructions (base/simd.h).
#pragma once

#include "contact/sample_search.h"

namespace cloudcontact::search {

constexpr int kLanes = 256, kVector = 16;

// Loops run over whole vectors. The lanes after the last repeat it and are not used.
constexpr int padded(int count) {
  return (count + kVector - 1) & ~(kVector - 1);
}
template <typename Number>
void pad(Number* lanes, int count) {
  for (int i = count; i < padded(count); ++i) lanes[i] = lanes[count - 1];
}

// The samples of some lanes, copied: a loop that reads them from where they are stored needs a
// gather for each number, which took half of a query's time.
struct LaneSamples {
  static constexpr int kRoom = kLanes + kVector;  // a copy may write a vector too many

  float x[kRoom], y[kRoom], z[kRoom];     // [voxels], grid's frame
  float nx[kRoom], ny[kRoom], nz[kRoom];  // outward unit vector
  float width[kRoom];
  float rise[kRoom], spread[6][kRoom];  // of coarse samples (CcCluster)

  CcCluster cluster(int i) const {
    return {rise[i],
            {spread[0][i], spread[1][i], spread[2][i], spread[3][i], spread[4][i], spread[5][i]}};
  }
};

struct Lanes {
  int count = 0;
  int runs = 0;
  std::size_t planes = 0;  // WorkCounts::planes of all lanes so far
  SampleRun run[kLanes];   // the lanes' samples, in the lanes' order
  std::uint32_t sample[kLanes];
  LaneSamples own;
  std::int32_t record[kLanes];                // number of the record
  float x[kLanes], y[kLanes], z[kLanes];      // from the voxel's center [voxels]
  std::uint32_t a[kLanes], b[kLanes];         // the record (kernels/contact/field_voxel.h)
  float depth[kLanes];                        // [m]
  float nx[kLanes], ny[kLanes], nz[kLanes];   // of the plane that gives the depth
  float facing[kLanes];                       // cosine between the two normals
  float beside[kLanes];                       // ccDepthBeside() of coarse samples [own voxels]
  std::int32_t kind[kLanes];                  // CC_WET and so on
  std::int32_t wet[kLanes], several[kLanes];  // numbers of lanes: hits; records of several planes

  bool full() const { return count == kLanes; }
  void clear() { count = runs = 0; }
  // Adds the first samples of the run, as many as there is room for; returns how many.
  std::uint32_t add(SampleRun from) {
    const std::uint32_t room = static_cast<std::uint32_t>(kLanes - count),
                        some = from.count < room ? from.count : room;
    if (some == 0) return 0;
    SampleRun* const last = run + runs - 1;
    if (runs > 0 && last->first + last->count == from.first)
      last->count += some;
    else
      run[runs++] = {from.first, some};
    count += static_cast<int>(some);
    return some;
  }
};

// Copies the lanes' samples; `beside`: with what coarse ones stand for.
void loadSamples(const Direction& dir, bool beside, Lanes& lanes);

// Lists the lanes whose flags are set, in their order; returns how many. Most vectors of lanes hold
// none. Without branches inside them, which a processor cannot predict.
template <typename Number>
int listSet(const std::int32_t* flags, std::int32_t mask, int count, const Number* numbers,
            Number* list) {
  int found = 0;
  for (int first = 0; first < count; first += kVector) {
    const int last = first + kVector < count ? first + kVector : count;
    std::int32_t any = 0;
    for (int i = first; i < last; ++i) any |= flags[i];
    if ((any & mask) == 0) continue;
    for (int i = first; i < last; ++i) {
      list[found] = numbers ? numbers[i] : static_cast<Number>(i);
      found += (flags[i] & mask) != 0;
    }
  }
  return found;
}

}  // namespace cloudcontact::search
