// Passing a level, and a list's memory.
#include "contact/verlet_list.h"

#include "contact/field_lanes.h"

namespace cloudcontact {

using namespace search;

namespace {

// Whether finer samples may touch for which sample k stands.
bool finerAreNear(const Direction& dir, const FieldData& other, std::size_t k,
                  std::size_t& planes) {
  const SampleLevel& of = dir.samples.levels[dir.level];
  const float at[3] = {of.samples.x[k], of.samples.y[k], of.samples.z[k]};
  float x[3];
  ccApply(&dir.toOther, at, x);
  CcPlace place;
  const CcVoxel record = recordAt(other, x, place);
  const CcLimits limits = dir.limits();
  const auto voxel = static_cast<float>(other.cloud().voxelSize());
  const std::uint32_t count = ccPlaneCount(record);
  if (count == 0) return ccKindOf(&limits, record, 0, 0) & CC_NEARBY;
  planes += count > 1 ? count : 0;
  const CcDepth d = ccVoxelDepth(record, other.planes(), place.r);
  const CcCluster cluster = of.clusters[k];
  return ccNearByPlanes(&limits, dir.turnToOther, &cluster, record, other.planes(), place.r,
                        d.depth * voxel, d.normal, voxel);
}

// Appends a run; what follows the last one lengthens it.
void append(SampleRun run, std::vector<SampleRun>& to) {
  if (!to.empty() && to.back().first + to.back().count == run.first)
    to.back().count += run.count;
  else
    to.push_back(run);
}

}  // namespace

// Each sample by itself: there are few, and most of what searching them side by side takes is
// beginning to do so.
void VerletList::pass(const Direction& dir, const FieldData& other, float age,
                      Candidates& candidates) const {
  const Passed& level = passed[dir.level];
  const LargeVector<SampleRun>& finer = set.levels[dir.level].finer;
  if (candidates.all)
    candidates.runs.assign(1, {0, static_cast<std::uint32_t>(level.cells.size())});
  candidates.all = false;
  const auto isNear = [&](std::uint32_t sample) {
    if (age < level.until[sample]) return level.near[sample] != 0;
    ++candidates.work.samples;
    return finerAreNear(dir, other, sample, candidates.work.planes);
  };
  candidates.finer.clear();
  for (const SampleRun& run : candidates.runs)
    for (std::uint32_t cell = run.first; cell < run.first + run.count; ++cell) {
      const SampleRun asked = level.cells[cell];
      bool near = asked.count == 0;
      for (std::uint32_t i = 0; i < asked.count && !near; ++i) near = isNear(asked.first + i);
      if (near) append(finer[cell], candidates.finer);
    }
  std::swap(candidates.runs, candidates.finer);
}

void VerletList::choose(float age, Candidates& candidates) const {
  if (candidates.all) candidates.runs.assign(1, {0, static_cast<std::uint32_t>(dry.size())});
  candidates.all = false;
  candidates.finer.clear();
  for (const SampleRun& run : candidates.runs)
    for (std::uint32_t k = run.first; k < run.first + run.count; ++k)
      if (dry[k] <= age) append({k, 1}, candidates.finer);
  std::swap(candidates.runs, candidates.finer);
}

void VerletList::clear() {
  dry.clear();
  for (int level = 0; level < kLevels; ++level) {
    SampleLevel& of = set.levels[level];
    of.samples.clear(), of.clusters.clear(), of.cellOf.clear(), of.finer.clear();
    passed[level].cells.clear(), passed[level].until.clear(), passed[level].near.clear();
  }
}

// Of a coarse level most cells are surely near, and none of their samples is asked.
void VerletList::reserve(int level, std::size_t count) {
  constexpr std::size_t kPerAsked = 4;
  for (int k = kLevels - 1; k >= level; --k) {
    SampleLevel& of = set.levels[k];
    const std::size_t copies = k == level ? count : count / kPerAsked;
    if (of.samples.x.capacity() < copies) of.samples.reserve(copies);
    if (k == level) {
      dry.reserve(count);
      continue;
    }
    of.clusters.reserve(copies), of.cellOf.reserve(copies);
    passed[k].until.reserve(copies), passed[k].near.reserve(copies);
    of.finer.reserve(count), passed[k].cells.reserve(count);
  }
}

std::size_t VerletList::bytes() const {
  std::size_t sum = sizeof(float) * dry.capacity();
  for (int level = 0; level < kLevels; ++level) {
    const SampleLevel& of = set.levels[level];
    sum += 8 * sizeof(float) * of.samples.x.capacity() +
           7 * sizeof(float) * of.clusters.rise.capacity() +
           sizeof(std::uint32_t) * of.cellOf.capacity() +
           sizeof(SampleRun) * (of.finer.capacity() + passed[level].cells.capacity()) +
           sizeof(float) * passed[level].until.capacity() + passed[level].near.capacity();
  }
  return sum;
}

}  // namespace cloudcontact
