// Samples of one body looked up in the other's field: bricks of samples first, by their bounding
// sphere against the other's brick distance, then each sample in one 8-byte fetch.
#include "field_lanes.h"

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
    int several[kLanes], count = 0;
    for (int i = 0; i < lanes_.count; ++i) {
      several[count] = i;
      count += ccPlaneCount({lanes_.a[i], 0}) > 1;
    }
    for (int first = 0, next = 0; first < count; first = next) {
      planes_.count = 0;
      for (; next < count && planes_.count <= PlaneLanes::kMost - CC_MAX_PLANES; ++next)
        ask(several[next]);
      findDepths(planes_);
      for (int i = first, plane = 0; i < next; ++i) plane = choose(several[i], plane);
    }
  }

  void ask(int lane) {
    const CcVoxel record{lanes_.a[lane], lanes_.b[lane]};
    const uint count = ccPlaneCount(record);
    for (uint k = 0; k < count; ++k) {
      const CcVoxel plane = other_.planes()[record.b + k];
      const int at = planes_.count++;
      planes_.a[at] = plane.a;
      planes_.b[at] = plane.b;
      planes_.x[at] = lanes_.x[lane];
      planes_.y[at] = lanes_.y[lane];
      planes_.z[at] = lanes_.z[lane];
    }
  }

  // The least of a lane's planes from `first` on, or the greatest where they unite; returns the
  // next lane's first.
  int choose(int lane, int first) {
    const CcVoxel record{lanes_.a[lane], lanes_.b[lane]};
    const int last = first + static_cast<int>(ccPlaneCount(record));
    const bool greatest = ccConcave(record) != 0;
    int best = first;
    for (int i = first + 1; i < last; ++i)
      if (greatest ? planes_.depth[i] > planes_.depth[best]
                   : planes_.depth[i] < planes_.depth[best])
        best = i;
    lanes_.depth[lane] = planes_.depth[best] * voxel_;
    lanes_.nx[lane] = planes_.nx[best];
    lanes_.ny[lane] = planes_.ny[best];
    lanes_.nz[lane] = planes_.nz[best];
    const float width = samples_.width[lanes_.sample[lane]];
    if (dir_.level < 2 && width > kWide && lanes_.depth[lane] > reachOf(dir_, width) &&
        edgeWithin(best, first, last, width * dir_.voxel / voxel_))
      parted_[divided_++] = lane;
    return last;
  }

  // Whether another of the planes may give the depth somewhere within a sample that wide.
  bool edgeWithin(int best, int first, int last, float width) const {
    const V3 n(planes_.nx[best], planes_.ny[best], planes_.nz[best]);
    for (int i = first; i < last; ++i) {
      const float apart = std::abs(planes_.depth[i] - planes_.depth[best]);
      const V3 other(planes_.nx[i], planes_.ny[i], planes_.nz[i]);
      if (apart > 0 && apart < kHalfDiagonal * width * (other - n).norm()) return true;
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
  PlaneLanes planes_;
};

}  // namespace

void searchField(const Direction& dir, const FieldData& other, Candidates& candidates,
                 HitColumns& hits) {
  FieldSearch(dir, other, candidates, hits).run();
}

}  // namespace cloudcontact::search
