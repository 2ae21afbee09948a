// Samples of one body looked up in the other's field: bricks of samples first, by their bounding
// sphere against the other's brick distance, then each sample in one 8-byte fetch.
#include "field_lanes.h"

#include <algorithm>

namespace cloudcontact::search {

namespace {

constexpr float kBeyondBand = 5.5f;  // depth given to a sample below the band's last layer [voxels]

// Samples of the runs that are looked at, in batches.
class FieldSearch {
 public:
  FieldSearch(const Direction& dir, const FieldData& other, Candidates& candidates,
              HitColumns& hits)
      : dir_(dir),
        samples_(dir.samples.levels[dir.level].samples),
        other_(other),
        candidates_(candidates),
        hits_(hits),
        voxel_(static_cast<float>(other.cloud().voxelSize())) {}

  void run() {
    candidates_.next.clear();
    if (candidates_.all) {
      nearBricks(dir_, other_, candidates_.bricks);
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
      const std::uint32_t room = std::min<std::uint32_t>(
          run.count, static_cast<std::uint32_t>(kLanes - lanes_.count));
      for (std::uint32_t i = 0; i < room; ++i) lanes_.sample[lanes_.count++] = run.first + i;
      run.first += room;
      run.count -= room;
    }
  }

  void flush() {
    if (lanes_.count == 0) return;
    findRecords(dir_, other_, lanes_);
    findDepths(voxel_, lanes_);
    takeSeveral();
    classify(dir_, lanes_);
    for (int i = 0; i < divided_; ++i) takeParts(parted_[i]);
    sort();
    lanes_.count = 0;
  }

  // Lanes whose record has several planes: the one that counts gives depth and normal.
  void takeSeveral() {
    divided_ = 0;
    int count = 0;
    for (int i = 0; i < lanes_.count; ++i) {
      lanes_.several[count] = i;
      count += (lanes_.a[i] >> 28 & 7) > 1;
    }
    if (count == 0) return;
    choosePlanes(other_, voxel_, count, lanes_);
    if (dir_.level == 2) return;
    for (int i = 0; i < count; ++i) {
      const int lane = lanes_.several[i];
      const float width = samples_.width[lanes_.sample[lane]];
      if (width > kWide && lanes_.depth[lane] > reachOf(dir_, width) &&
          edgeWithin(lane, width * dir_.voxel / voxel_))
        parted_[divided_++] = lane;
    }
  }

  // Whether another of the record's planes may give the depth somewhere within a sample that wide.
  bool edgeWithin(int lane, float width) const {
    const V3 n(lanes_.nx[lane], lanes_.ny[lane], lanes_.nz[lane]);
    const float r[3] = {lanes_.x[lane], lanes_.y[lane], lanes_.z[lane]};
    const CcVoxel record{lanes_.a[lane], lanes_.b[lane]};
    for (uint k = 0; k < ccPlaneCount(record); ++k) {
      const CcDepth d = ccPlaneDepth(other_.planes()[record.b + k], r);
      const V3 m(d.normal[0], d.normal[1], d.normal[2]);
      const float apart = std::abs(d.depth * voxel_ - lanes_.depth[lane]);
      if (apart > 0 && apart < kHalfDiagonal * width * (m - n).norm() * voxel_) return true;
    }
    return false;
  }

  void takeParts(int lane) {
    lanes_.kind[lane] &= ~kWet;
    const CcVoxel record{lanes_.a[lane], lanes_.b[lane]};
    const V3 r(lanes_.x[lane], lanes_.y[lane], lanes_.z[lane]);
    const auto at = [&](const V3& aside) {
      const V3 x = r + turned(dir_.toOther.turn, aside);
      const CcDepth there = ccVoxelDepth(record, other_.planes(), x.data());
      return std::pair(there.depth * voxel_, V3(there.normal[0], there.normal[1], there.normal[2]));
    };
    addParts(dir_, samples_[lanes_.sample[lane]], at, hits_);
  }

  // What becomes of each lane, by its kind.
  void sort() {
    int wet = 0;
    for (int i = 0; i < lanes_.count; ++i) {
      lanes_.wet[wet] = i;
      wet += lanes_.kind[i] & kWet;
      if (lanes_.kind[i] & (kDeep | kNearby)) {
        if (lanes_.kind[i] & kNearby) handOn(dir_, lanes_.sample[i], last_, candidates_);
        if (lanes_.kind[i] & kDeep) takeDeep(i);
      }
    }
    std::int32_t dry[kLanes];
    const int missed = addHits(dir_, lanes_, wet, hits_, dry);
    if (dir_.level > 0 || dir_.misses.margin == 0) return;
    for (int i = 0; i < missed; ++i)
      addHit(dir_, samples_[lanes_.sample[dry[i]]], lanes_.depth[dry[i]],
             V3(lanes_.nx[dry[i]], lanes_.ny[dry[i]], lanes_.nz[dry[i]]), false, hits_);
  }

  void takeDeep(int lane) {
    const SurfaceSample s = samples_[lanes_.sample[lane]];
    const V3 x = applied(dir_.toOther, V3(s.position[0], s.position[1], s.position[2]));
    const CcPlace place = ccPlaceOf(other_.records().bricks(), x.data());
    const int deeper =
        std::max(0, static_cast<int>(
                        other_.brickDistance()[static_cast<std::size_t>(place.brick)]) -
                        1);
    addHit(dir_, s, (kBeyondBand + static_cast<float>(deeper * kBrickEdge)) * voxel_, V3::Zero(),
           true, hits_);
  }

  const Direction& dir_;
  const SampleColumns& samples_;
  const FieldData& other_;
  Candidates& candidates_;
  HitColumns& hits_;
  float voxel_;  // of the other body [m]
  std::uint32_t last_ = kNoCell;
  int divided_ = 0;
  int parted_[kLanes];  // lanes that are taken in parts
  Lanes lanes_;
};

}  // namespace

void searchField(const Direction& dir, const FieldData& other, Candidates& candidates,
                 HitColumns& hits) {
  FieldSearch(dir, other, candidates, hits).run();
}

}  // namespace cloudcontact::search
