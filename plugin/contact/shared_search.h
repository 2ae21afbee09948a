// One level's search shared out: consecutive runs of samples a share, each with lists of its own,
// joined in the order of the runs. What comes of it is that of LaneSearch::run() to the bit: hits
// have one order whatever the batches, and near misses that an earlier share would have left out
// are left out at the end (HitSearch::touchLightly).
#pragma once

#include "contact/lane_search.h"

#include <functional>

namespace cloudcontact::search {

// Samples a share; a level of fewer than two shares is not shared out.
constexpr std::size_t kShareSamples = 2048;

// Runs to shares; returns how many.
inline int cut(HitSearch::Shares& shares, std::size_t samples) {
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

inline void join(const HitSearch::Share& share, const Direction& dir, Candidates& candidates,
                 HitColumns& hits) {
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  candidates.asked += share.cells.asked;
  append(candidates.next, share.cells.next);
  append(candidates.deep, share.cells.deep);
  append(candidates.places, share.cells.places);
  candidates.parts.append(share.cells.parts, 0, share.cells.parts.size());
  append(dir.misses.list, share.misses.list);
  dir.misses.nearest = std::max(dir.misses.nearest, share.misses.nearest);
  hits.append(share.hits);
}

template <typename Target>
void searchShared(const Direction& dir, Target& target, Candidates& candidates, HitColumns& hits,
                  HitSearch::Shares& shares) {
  LaneSearch<Target> whole(dir, target, candidates, hits);
  if (!shares.run) return whole.run();
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
  const int count = cut(shares, samples);
  const auto look = [&](int i) {
    HitSearch::Share& share = shares.all[static_cast<std::size_t>(i)];
    const std::size_t first = i > 0 ? (&share - 1)->last : 0;
    share.misses.margin = dir.misses.margin;
    share.misses.within = dir.misses.within;
    share.misses.nearest = dir.misses.nearest;
    share.misses.list.clear();
    share.hits.clear();
    share.cells.asked = 0;
    const Direction own = dir.with(share.misses);
    LaneSearch<Target> part(own, target, share.cells, share.hits);
    part.clear();
    part.look(runs + first, runs + share.last);
  };
  (*shares.run)(count, std::cref(look));
  for (int i = 0; i < count; ++i)
    join(shares.all[static_cast<std::size_t>(i)], dir, candidates, hits);
  whole.finish();
}

}  // namespace cloudcontact::search
