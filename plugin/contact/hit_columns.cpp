// Hits in columns: adding, appending and reading whole hits.
#include "contact/hit_columns.h"

#include <algorithm>

namespace cloudcontact {

Hit hitOf(const CcHit& hit, float area, float depth, Side side, bool deep) {
  using V3 = Eigen::Vector3f;
  return {V3(hit.position),
          V3(hit.own),
          V3(hit.other),
          area,
          hit.wet.share,
          hit.wet.depth1,
          hit.wet.depth2,
          hit.wet.depth3,
          depth,
          hit.facing,
          static_cast<std::int8_t>(side),
          static_cast<std::int8_t>(deep)};
}

void setDepth(Hit& hit, float depth) {
  hit.depth = depth;
  hit.share = 1;
  hit.depth1 = depth;
  hit.depth2 = depth * depth;
  hit.depth3 = hit.depth2 * depth;
}

void HitColumns::enlarge(std::size_t size) {
  // The odd size keeps the starts of the columns out of one set of the cache.
  move(std::max<std::size_t>({size, 2 * side_.size(), 256}) + 48);
}

// Moves the hits to columns of the size `room`.
void HitColumns::move(std::size_t room) {
  std::vector<float> data(kColumns * room);
  for (std::size_t c = 0; c < kColumns; ++c)
    std::copy_n(data_.data() + c * side_.size(), size_, data.data() + c * room);
  data_ = std::move(data);
  side_.resize(room);
  deep_.resize(room);
}

void HitColumns::commit(std::size_t count, Side side, bool deep) {
  std::fill_n(side_.data() + size_, count, static_cast<std::int8_t>(side));
  std::fill_n(deep_.data() + size_, count, static_cast<std::int8_t>(deep));
  anyDeep_ = anyDeep_ || (deep && count > 0);
  size_ += count;
}

void HitColumns::push_back(const Hit& h) {
  const Columns<float> c = room(1);
  *c.x = h.position.x(), *c.y = h.position.y(), *c.z = h.position.z();
  *c.ownX = h.own.x(), *c.ownY = h.own.y(), *c.ownZ = h.own.z();
  *c.otherX = h.other.x(), *c.otherY = h.other.y(), *c.otherZ = h.other.z();
  *c.area = h.area, *c.share = h.share;
  *c.depth1 = h.depth1, *c.depth2 = h.depth2, *c.depth3 = h.depth3;
  *c.depth = h.depth, *c.facing = h.facing;
  commit(1, static_cast<Side>(h.side), h.deep != 0);
}

void HitColumns::append(const HitColumns& from) {
  if (from.empty()) return;
  room(from.size_);
  for (std::size_t c = 0; c < kColumns; ++c)
    std::copy_n(from.data_.data() + c * from.side_.size(), from.size_,
                data_.data() + c * side_.size() + size_);
  std::copy_n(from.side_.data(), from.size_, side_.data() + size_);
  std::copy_n(from.deep_.data(), from.size_, deep_.data() + size_);
  anyDeep_ = anyDeep_ || from.anyDeep_;
  size_ += from.size_;
}

Hit HitColumns::operator[](std::size_t i) const {
  const Columns<const float> c = at<const float>(data_.data(), i);
  return {{*c.x, *c.y, *c.z},
          {*c.ownX, *c.ownY, *c.ownZ},
          {*c.otherX, *c.otherY, *c.otherZ},
          *c.area,
          *c.share,
          *c.depth1,
          *c.depth2,
          *c.depth3,
          *c.depth,
          *c.facing,
          side_[i],
          deep_[i]};
}

}  // namespace cloudcontact
