// Looks cells up in a sorted list: a contact has tens of bins.
#include "contact/patch_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloudcontact {

void PatchMap::read(const std::vector<Binner::Bin>& bins, double cell) {
  perCell_ = 1 / cell;
  entries_.clear();
  latest_ = {{}, 0, 0};
  for (const Binner::Bin& bin : bins)
    if (bin.patch >= 0) entries_.push_back({{bin.cell[0], bin.cell[1], bin.cell[2]}, &bin});
  // Bins have a fixed order in memory, so equal cells keep it.
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.bin < b.bin;
  });
}

PatchMap::Run PatchMap::runOf(const Cell& cell) const {
  if (latest_.cell == cell && latest_.last > latest_.first) return latest_;
  const auto first =
      std::lower_bound(entries_.begin(), entries_.end(), cell,
                       [](const Entry& entry, const Cell& wanted) { return entry.cell < wanted; });
  auto last = first;
  while (last != entries_.end() && last->cell == cell) ++last;
  const auto index = [&](auto at) { return static_cast<std::size_t>(at - entries_.begin()); };
  return {cell, index(first), index(last)};
}

void PatchMap::consider(const Run& run, int side, const Vec3& normal, double& best,
                        int& patch) const {
  for (std::size_t k = run.first; k < run.last; ++k) {
    const Binner::Bin& bin = *entries_[k].bin;
    const CcVec& n = bin.faces.normal[side];
    const double along = n.x * normal.x() + n.y * normal.y() + n.z * normal.z();
    const double agrees =
        normal.isZero() ? bin.weight : along / std::max(bin.faces.length[side], 1e-300);
    if (agrees <= best) continue;
    best = agrees;
    patch = bin.patch;
  }
}

int PatchMap::of(const Vec3& place, int side, const Vec3& normal) const {
  const auto cellOf = [this](double x) {
    return static_cast<std::int32_t>(std::floor(x * perCell_));
  };
  const Cell own{cellOf(place.x()), cellOf(place.y()), cellOf(place.z())};
  double best = -std::numeric_limits<double>::infinity();
  int patch = -1;
  const Run run = runOf(own);
  if (run.last > run.first) {
    latest_ = run;
    if (run.last - run.first == 1) return entries_[run.first].bin->patch;
    consider(run, side, normal, best, patch);
    return patch;
  }
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        consider(runOf({own[0] + x, own[1] + y, own[2] + z}), side, normal, best, patch);
  return patch;
}

}  // namespace cloudcontact
