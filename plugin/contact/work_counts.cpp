// The counts by name.
#include <cloudcontact/contact/work_counts.h>

namespace cloudcontact {

Span<const WorkCounts::Named> WorkCounts::all() {
  static constexpr Named kAll[] = {
      {"searches", &WorkCounts::searches}, {"bricks", &WorkCounts::bricks},
      {"samples", &WorkCounts::samples},   {"planes", &WorkCounts::planes},
      {"voxels", &WorkCounts::voxels},     {"hits", &WorkCounts::hits},
      {"scanned", &WorkCounts::scanned},   {"tried", &WorkCounts::tried}};
  return kAll;
}

WorkCounts& WorkCounts::operator+=(const WorkCounts& other) {
  for (const Named& each : all()) this->*each.count += other.*each.count;
  return *this;
}

WorkCounts& WorkCounts::operator-=(const WorkCounts& other) {
  for (const Named& each : all()) this->*each.count -= other.*each.count;
  return *this;
}

bool operator==(const WorkCounts& a, const WorkCounts& b) {
  bool equal = true;
  for (const WorkCounts::Named& each : WorkCounts::all())
    equal = equal && a.*each.count == b.*each.count;
  return equal;
}

}  // namespace cloudcontact
