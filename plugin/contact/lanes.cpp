// Samples into lanes: a run at a time, a vector at a time.
#include "contact/lanes.h"

#include "base/simd.h"

#include <algorithm>
#include <cstring>

namespace cloudcontact::search {

namespace {

// One column of a level, and where it goes.
struct Column {
  const float* from;
  float* to;
};

constexpr int kColumns = 14;

int columnsOf(const SampleLevel& level, bool coarse, LaneSamples& own, Column* columns) {
  const SampleColumns& s = level.samples;
  const Column all[] = {{s.x.data(), own.x},        {s.y.data(), own.y},   {s.z.data(), own.z},
                        {s.nx.data(), own.nx},      {s.ny.data(), own.ny}, {s.nz.data(), own.nz},
                        {s.width.data(), own.width}};
  int count = 0;
  for (const Column& column : all) columns[count++] = column;
  if (!coarse) return count;
  columns[count++] = {level.clusters.rise.data(), own.rise};
  for (int k = 0; k < 6; ++k) columns[count++] = {level.clusters.spread[k].data(), own.spread[k]};
  return count;
}

}  // namespace

CC_LANES void loadSamples(const Direction& dir, bool beside, Lanes& lanes) {
  const SampleLevel& level = dir.samples.levels[dir.level];
  Column columns[kColumns];
  const int count = columnsOf(level, beside && dir.level > 0, lanes.own, columns);
  const std::uint32_t all = static_cast<std::uint32_t>(level.samples.size());
  int at = 0;
  for (int r = 0; r < lanes.runs; ++r) {
    const SampleRun run = lanes.run[r];
    for (std::uint32_t i = 0; i < run.count; ++i)
      lanes.sample[static_cast<std::uint32_t>(at) + i] = run.first + i;
    for (std::uint32_t done = 0; done < run.count; done += kVector) {
      const std::uint32_t first = run.first + done, to = static_cast<std::uint32_t>(at) + done;
      // Past the run's end a whole vector is read where the level has one.
      if (first + kVector <= all) {
        for (int c = 0; c < count; ++c)
          std::memcpy(columns[c].to + to, columns[c].from + first, kVector * sizeof(float));
      } else {
        for (int c = 0; c < count; ++c)
          std::copy_n(columns[c].from + first, all - first, columns[c].to + to);
      }
    }
    at += static_cast<int>(run.count);
  }
  pad(lanes.sample, lanes.count);
  for (int c = 0; c < count; ++c) pad(columns[c].to, lanes.count);
}

}  // namespace cloudcontact::search
