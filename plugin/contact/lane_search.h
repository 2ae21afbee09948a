// The search of one level: batches of samples measured by a target (a field or a shape). A large
// level is shared out: each task takes consecutive runs of samples and collects hits of its own,
// and the tasks' hits are joined in the order of the runs.
//
// The order of the hits does not depend on batches or tasks: first whole samples by number, then
// samples below the band, then parts of samples that lie over an edge. So sums over them are the
// same to the bit for any number of threads, and on a device.
//
// search_targets.h: what a target is.
#pragma once

#include "contact/field_lanes.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace cloudcontact::search {

constexpr std::uint32_t kNoCell = ~0u;

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
    clear();
    eachRun([this](const SampleRun& run) { lookInto(run); });
    flush();
    finish();
  }

  // The steps of run(), for searchShared().
  void clear() {
    candidates_.next.clear();
    candidates_.deep.clear();
    candidates_.parts.clear();
    candidates_.places.clear();
    candidates_.touched.clear();
  }
  // Visits whole bricks, or the finer samples of the cells that the coarser level found near. The
  // samples of a cell are consecutive.
  template <typename Visit>
  void eachRun(const Visit& visit) {
    if (candidates_.all) return eachBrick(visit);
    for (const SampleRun& run : candidates_.runs) visit(run);
  }
  void look(const SampleRun* first, const SampleRun* last) {
    for (; first != last; ++first) lookInto(*first);
    flush();
  }
  // Adds what follows all whole samples.
  void finish() {
    for (const std::uint32_t k : candidates_.deep) {
      const SurfaceSample s = samples_[k];
      hits_.push_back(hitOf(dir_, s, target_.deepAt(s), V3::Zero(), true));
    }
    takeParts();
    if (dir_.level > 0) findFiner();
    candidates_.all = false;
  }

 private:
  template <typename Visit>
  void eachBrick(const Visit& visit) {
    target_.nearBricks(dir_.owned ? kOwnedAside : 0.0f, candidates_.bricks);
    candidates_.work.bricks += dir_.samples.bricks.runs.size();
    if (candidates_.coarse) {
      candidates_.coarse->begin(samples_.size());
      candidates_.coarse->bricks.assign(candidates_.bricks.begin(), candidates_.bricks.end());
    }
    for (const std::uint32_t brick : candidates_.bricks) visit(dir_.samples.bricks.runs[brick]);
  }

  // The next finer level's samples: those in the cells of what is near.
  void findFiner() {
    const SampleLevel& level = dir_.samples.levels[dir_.level];
    candidates_.runs.clear();
    std::uint32_t last = kNoCell;
    for (const std::uint32_t sample : candidates_.next) {
      const std::uint32_t cell = level.cellOf[sample];
      if (cell != last) candidates_.runs.push_back(level.finer[cell]);
      last = cell;
    }
  }

  void lookInto(SampleRun run) {
    while (run.count > 0) {
      if (lanes_.full()) flush();
      const std::uint32_t some = lanes_.add(run);
      run.first += some;
      run.count -= some;
    }
  }

  void flush() {
    if (lanes_.count == 0) return;
    candidates_.work.samples += static_cast<std::size_t>(lanes_.count);
    // With enough hits there is no finer level.
    const bool finer = hits_.size() < dir_.needed;
    loadSamples(dir_, finer, lanes_);
    const int divided = target_.measure(finer, lanes_);
    classify(dir_, finer, lanes_);
    if (finer && candidates_.coarse && dir_.level == kLevels - 1) keepCoarse(*candidates_.coarse);
    const std::size_t touched = candidates_.touched.size(), hits = hits_.size();
    if (dir_.owned) keepTouched(finer);
    for (int i = 0; i < divided; ++i) {
      lanes_.kind[lanes_.several[i]] &= ~CC_WET;
      divide(lanes_.several[i]);
    }
    sort(finer);
    if (dir_.owned) nameHits(touched, hits);
    countPlanes();
    lanes_.clear();
  }

  void countPlanes() { candidates_.work.planes += std::exchange(lanes_.planes, 0); }

  // Where these are, finer samples may be touched, too.
  void keepTouched(bool finer) {
    std::int32_t list[kLanes];
    const int found = findTouched(dir_, lanes_, list);
    for (int n = 0; n < found; ++n) {
      const int i = list[n];
      const std::uint32_t k = lanes_.sample[i];
      const std::uint32_t planes = ccPlaneCount({lanes_.a[i], lanes_.b[i]});
      TouchedSample one{k, lanes_.depth[i], {lanes_.nx[i], lanes_.ny[i], lanes_.nz[i]}};
      if (planes == 0) one.depth = target_.deepAt(samples_[k]), one.other.setZero();
      one.plain = planes == 1;
      one.hit = static_cast<std::uint32_t>(i);  // the lane, for nameHits()
      candidates_.touched.push_back(one);
      if (finer && dir_.level > 0) lanes_.kind[i] |= CC_NEARBY;
    }
  }

  // Names the hits of what these lanes have added to the touched samples. `hits`: there were
  // before.
  void nameHits(std::size_t touched, std::size_t hits) {
    std::uint32_t hitOf[kLanes];
    std::fill_n(hitOf, lanes_.count, TouchedSample::kNoHit);
    for (std::size_t i = hits; i < hits_.size(); ++i)
      hitOf[lanes_.wet[i - hits]] = static_cast<std::uint32_t>(i);
    for (std::size_t i = touched; i < candidates_.touched.size(); ++i)
      candidates_.touched[i].hit = hitOf[candidates_.touched[i].hit];
  }

  void keepCoarse(CoarseFound& coarse) {
    float estimates[kLanes], depths[kLanes];
    estimateNearest(dir_, lanes_, estimates, depths);
    int from = 0;
    for (int r = 0; r < lanes_.runs; ++r) {
      const SampleRun run = lanes_.run[r];
      std::copy_n(estimates + from, run.count, coarse.estimate.data() + run.first);
      std::copy_n(depths + from, run.count, coarse.depth.data() + run.first);
      from += static_cast<int>(run.count);
    }
  }

  // Sorts the lanes by kind.
  void sort(bool finer) {
    const int count = lanes_.count;
    std::uint32_t some[kLanes];
    const auto append = [&](std::int32_t kind, std::vector<std::uint32_t>& to) {
      const int found = listSet(lanes_.kind, kind, count, lanes_.sample, some);
      to.insert(to.end(), some, some + found);
    };
    if (finer) append(CC_NEARBY, candidates_.next);
    append(CC_DEEP, candidates_.deep);
    take(lanes_, samples_, listSet<std::int32_t>(lanes_.kind, CC_WET, count, nullptr, lanes_.wet));
  }

  // Divides a wide sample: over an edge of the other body the depth is not linear. Without this,
  // crossed edges turn by 11 deg at a depth of half a voxel.
  void divide(int lane) {
    const SurfaceSample s = samples_[lanes_.sample[lane]];
    const int along = ccPartsAlong(s.width);
    float t1[3], t2[3];
    ccTangents(s.normal, t1, t2);
    SurfaceSample part = s;
    part.width = s.width / static_cast<float>(along);
    part.area = s.area / static_cast<float>(along * along);
    const Eigen::Map<const V3> middle(s.position);
    for (int k = 0; k < along * along; ++k) {
      V3 aside;
      ccPartAside(part.width, along, k, t1, t2, aside.data());
      const V3 moved = turned(dir_.toOther.turn, aside);
      Eigen::Map<V3>(part.position) = middle + aside;
      candidates_.parts.push_back(part);
      candidates_.places.push_back({{lanes_.a[lane], lanes_.b[lane]},
                                    lanes_.x[lane] + moved.x(),
                                    lanes_.y[lane] + moved.y(),
                                    lanes_.z[lane] + moved.z()});
    }
  }

  void takeParts() {
    const std::size_t all = candidates_.places.size();
    for (std::size_t first = 0; first < all; first += static_cast<std::size_t>(lanes_.count)) {
      lanes_.count = static_cast<int>(std::min<std::size_t>(kLanes, all - first));
      for (int i = 0; i < lanes_.count; ++i) {
        const std::size_t k = first + static_cast<std::size_t>(i);
        const Part& part = candidates_.places[k];
        lanes_.sample[i] = static_cast<std::uint32_t>(k);
        lanes_.a[i] = part.record.a;
        lanes_.b[i] = part.record.b;
        lanes_.x[i] = part.x;
        lanes_.y[i] = part.y;
        lanes_.z[i] = part.z;
        lanes_.wet[i] = i;
      }
      target_.measureParts(lanes_, candidates_.parts);
      take(lanes_, candidates_.parts, lanes_.count);
    }
    countPlanes();
    lanes_.count = 0;
  }

  // Adds the hits among the wet lanes.
  void take(Lanes& lanes, const SampleColumns& samples, int wet) {
    // Nearly all lanes that may be hits are hits.
    const FieldData* const other = target_.field();
    if (addHits(dir_, samples, other, lanes, wet, hits_)) return;
    addHits(dir_, samples, other, lanes, hitsFirst(dir_, samples, lanes, wet), hits_);
  }

  const Direction& dir_;
  const SampleColumns& samples_;
  Target& target_;
  Candidates& candidates_;
  HitColumns& hits_;
  Lanes lanes_;
};

// Samples in a share. A level of fewer than two shares is not shared out.
constexpr std::size_t kShareSamples = 2048;

// Assigns the runs to shares and returns the number of shares.
inline int assignRuns(Shares& shares, std::size_t samples) {
  const std::size_t count = samples / kShareSamples;
  if (shares.all.size() < count) shares.all.resize(count);
  std::size_t run = 0, seen = 0;
  for (std::size_t i = 0; i < count; ++i) {
    while (run < shares.runs.size() && seen * count < (i + 1) * samples)
      seen += shares.runs[run++].count;
    shares.all[i].last = run;
  }
  return static_cast<int>(count);
}

// Appends a share's results.
inline void join(const Share& share, Candidates& candidates, HitColumns& hits) {
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  candidates.work += share.candidates.work;
  append(candidates.next, share.candidates.next);
  append(candidates.deep, share.candidates.deep);
  const std::size_t touched = candidates.touched.size();
  append(candidates.touched, share.candidates.touched);
  for (std::size_t i = touched; i < candidates.touched.size(); ++i)
    if (std::uint32_t& hit = candidates.touched[i].hit; hit != TouchedSample::kNoHit)
      hit += static_cast<std::uint32_t>(hits.size());
  append(candidates.places, share.candidates.places);
  candidates.parts.append(share.candidates.parts, 0, share.candidates.parts.size());
  hits.append(share.hits);
}

template <typename Target>
void searchShared(const Direction& dir, Target& target, Candidates& candidates, HitColumns& hits,
                  Shares& shares) {
  LaneSearch<Target> whole(dir, target, candidates, hits);
  if (!shares.runner) return whole.run();
  whole.clear();
  shares.runs.clear();
  std::size_t samples = 0;
  whole.eachRun([&](const SampleRun& run) {
    shares.runs.push_back(run);
    samples += run.count;
  });
  const SampleRun* const runs = shares.runs.data();
  if (samples < 2 * kShareSamples) {
    whole.look(runs, runs + shares.runs.size());
    return whole.finish();
  }
  const int count = assignRuns(shares, samples);
  const auto look = [&](int i) {
    Share& share = shares.all[static_cast<std::size_t>(i)];
    const std::size_t first = i > 0 ? (&share - 1)->last : 0;
    share.hits.clear();
    share.candidates.work = {};
    share.candidates.coarse = candidates.coarse;
    LaneSearch<Target> part(dir, target, share.candidates, share.hits);
    part.clear();
    part.look(runs + first, runs + share.last);
  };
  (*shares.runner)(count, std::cref(look));
  for (int i = 0; i < count; ++i) join(shares.all[static_cast<std::size_t>(i)], candidates, hits);
  whole.finish();
}

}  // namespace cloudcontact::search
