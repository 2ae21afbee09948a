// How far a surface rises above each record's planes nearby, and planes for voxels too far outside
// to have any. A coarse sample stands for finer ones around it, so a search must know what the
// other surface does there: where it does not come near, the finer ones need not be asked.
#pragma once

#include "field/field_records.h"
#include "field/sample_set.h"

namespace cloudcontact {

// Writes ccBend() of all records near the surface, and ccPackOutside() of those farther outside.
// Without this they say CC_UNKNOWN_BEND and CC_NEAR_OUTSIDE.
void measureBends(const SampleSet& samples, FieldRecords& records, int threads);

}  // namespace cloudcontact
