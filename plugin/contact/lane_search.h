// One level's search: runs of samples in batches of lanes, measured by a target (a field or a
// shape), and what becomes of them.
//
// A target has
//   void nearBricks(std::vector<std::uint32_t>& near): numbers of the sample bricks that may touch;
//   int measure(Lanes& lanes): depth and normal of all lanes, with `a` a record of a plane, or none
//     and `b` what it says instead; the first lanes of lanes.several, as many as it returns, have
//     an edge of the target within them;
//   auto aside(const Lanes& lanes, int lane): a function from a place aside of a lane's sample [its
//     voxels] to depth [m] and normal there;
//   float deepAt(const SurfaceSample& s): the depth [m] of a sample below the band.
#pragma once

#include "field_lanes.h"

#include <algorithm>

namespace cloudcontact::search {

template <typename Target>
class LaneSearch {
 public:
  LaneSearch(const Direction& dir, Target& target, Candidates& candidates, HitColumns& hits)
      : dir_(dir),
        samples_(dir.samples.levels[dir.level].samples),
        target_(target),
        candidates_(candidates),
        hits_(hits) {}

  void run() {
    candidates_.next.clear();
    if (candidates_.all) {
      target_.nearBricks(candidates_.bricks);
      for (const std::uint32_t brick : candidates_.bricks)
        lookInto(dir_.samples.bricks.runs[brick]);
    } else {
      for (const SampleRun& run : candidates_.now) lookInto(run);
    }
    flush();
    std::swap(candidates_.now, candidates_.next);
    candidates_.all = false;
  }

 private:
  void lookInto(SampleRun run) {
    while (run.count > 0) {
      if (lanes_.count == kLanes) flush();
      const std::uint32_t room =
          std::min(run.count, static_cast<std::uint32_t>(kLanes - lanes_.count));
      for (std::uint32_t i = 0; i < room; ++i) lanes_.sample[lanes_.count++] = run.first + i;
      run.first += room;
      run.count -= room;
    }
  }

  void flush() {
    if (lanes_.count == 0) return;
    candidates_.asked += static_cast<std::size_t>(lanes_.count);
    const int divided = target_.measure(lanes_);
    classify(dir_, lanes_);
    for (int i = 0; i < divided; ++i) {
      const int lane = lanes_.several[i];
      lanes_.kind[lane] &= ~kWet;
      addParts(dir_, samples_[lanes_.sample[lane]], target_.aside(lanes_, lane), hits_);
    }
    sort();
    lanes_.count = 0;
  }

  // What becomes of each lane, by its kind.
  void sort() {
    int wet = 0;
    for (int i = 0; i < lanes_.count; ++i) {
      lanes_.wet[wet] = i;
      wet += lanes_.kind[i] & kWet;
      if (lanes_.kind[i] & (kDeep | kNearby)) {
        const SurfaceSample s = samples_[lanes_.sample[i]];
        if (lanes_.kind[i] & kNearby) handOn(dir_, lanes_.sample[i], last_, candidates_);
        if (lanes_.kind[i] & kDeep) addHit(dir_, s, target_.deepAt(s), V3::Zero(), true, hits_);
      }
    }
    std::int32_t dry[kLanes];
    const int missed = addHits(dir_, lanes_, wet, hits_, dry);
    if (dir_.level > 0 || dir_.misses.margin == 0) return;
    for (int i = 0; i < missed; ++i)
      addHit(dir_, samples_[lanes_.sample[dry[i]]], lanes_.depth[dry[i]],
             V3(lanes_.nx[dry[i]], lanes_.ny[dry[i]], lanes_.nz[dry[i]]), false, hits_);
  }

  const Direction& dir_;
  const SampleColumns& samples_;
  Target& target_;
  Candidates& candidates_;
  HitColumns& hits_;
  std::uint32_t last_ = kNoCell;
  Lanes lanes_;
};

}  // namespace cloudcontact::search
