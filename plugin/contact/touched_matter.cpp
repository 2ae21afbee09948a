// What either body has in the other, patch by patch.
#include "contact/touched_matter.h"

#include <cloudcontact/contact/paper_body.h>

#include "contact/voxel_sums.h"

namespace cloudcontact {

TouchedMatter::TouchedMatter() : sums_(std::make_unique<VoxelSums>()) {}
TouchedMatter::~TouchedMatter() = default;

bool TouchedMatter::wanted(const ContactBody& a, const ContactBody& b) {
  return a.tissues || b.tissues || a.paper || b.paper;
}

std::span<const PatchMatter> TouchedMatter::of(const ContactBody& a, const ContactBody& b,
                                               const PairFrame& frame, const HitSearch& search,
                                               const FoundHits& found) {
  matter_.assign(found.binner.patches().size(), {});
  const ContactBody* const bodies[2] = {&a, &b};
  for (const Side side : {kA, kB}) {
    const ContactBody &own = *bodies[side], &other = *bodies[1 - side];
    if (found.hits.empty() || !wantsVoxels(own)) continue;
    sums_->begin(own, other, side, frame, found);
    std::span<const search::TouchedSample> touched = search.touched(side);
    if (found.gap > 0) {
      sums_->addNear();
      touched = {};
    } else if (areaOf(other)) {
      sums_->touchedByArea(touched_);
      touched = touched_;
    }
    sums_->add(touched);
    sums_->finish(matter_);
    work_.voxels += sums_->takeLookups();
  }
  return matter_;
}

KelvinVoigt springOf(const PatchMatter& matter, const ContactBody& a, const ContactBody& b) {
  const auto of = [&](const ContactBody& body, int side) -> std::optional<KelvinVoigt> {
    if (!body.tissues) return body.spring;
    const double n = matter.count[side];
    const Tissue& first = body.tissues->front();
    if (!(n > 0)) return KelvinVoigt{first.stiffness, first.damping};
    return KelvinVoigt{matter.stiffness[side] / n, matter.damping[side] / n};
  };
  return inSeries(of(a, kA), of(b, kB)).value_or(KelvinVoigt{});
}

}  // namespace cloudcontact
