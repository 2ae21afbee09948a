// How far a surface rises above each record's planes nearby. A coarse sample stands for finer ones
// around it, so a search must know what the other surface does there: where it hardly bends, the
// finer ones need not be asked.
#pragma once

#include "field/field_records.h"
#include "field/sample_set.h"

namespace cloudcontact {

// Writes ccBend() of all records near the surface. Without this they say the most, CC_MOST_BEND.
void measureBends(const SampleSet& samples, FieldRecords& records);

}  // namespace cloudcontact
