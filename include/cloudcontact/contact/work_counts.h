// WorkCounts: what contacts took, in counts. They are equal on every machine, for any number of
// threads and any vector width, so that a search too many is seen where times would hide it
// (benchmarks/work.json).
#pragma once

#include <cloudcontact/base/span.h>

#include <cstddef>

namespace cloudcontact {

struct WorkCounts {
  std::size_t searches = 0;  // of a pair: for touches, for near misses, beside touches
  // Of samples, asked whether they may touch; and pairs of balls around them, for a gap.
  std::size_t bricks = 0;
  std::size_t samples = 0;  // looked up in the other body
  // Read besides the one plane of a sample's record: those of records with several, and where a
  // sample's end was looked up.
  std::size_t planes = 0;
  std::size_t voxels = 0;   // looked up for tissues and stated base vectors
  std::size_t hits = 0;     // found, those of levels that were too coarse included
  std::size_t scanned = 0;  // hits gone through to place points
  std::size_t tried = 0;    // hits whose distance from such a place was computed exactly

  WorkCounts& operator+=(const WorkCounts& other);
  WorkCounts& operator-=(const WorkCounts& other);  // of an earlier time
  // A count and its name.
  struct Named {
    const char* name;
    std::size_t WorkCounts::*count;
  };
  static Span<const Named> all();  // of the counts above, in their order
};

bool operator==(const WorkCounts& a, const WorkCounts& b);
inline bool operator!=(const WorkCounts& a, const WorkCounts& b) {
  return !(a == b);
}

}  // namespace cloudcontact
