// Hits in columns: whole ones in and out.
#include "hit_columns.h"

#include <algorithm>

namespace cloudcontact {

void HitColumns::enlarge(std::size_t size) {
  const std::size_t room = std::max(size, 2 * side_.size());
  for (std::vector<float>& c : columns_) c.resize(room);
  side_.resize(room);
  deep_.resize(room);
}

void HitColumns::push_back(const Hit& h) {
  const float values[kColumns] = {h.position.x(), h.position.y(), h.position.z(), h.own.x(),
                                  h.own.y(),      h.own.z(),      h.other.x(),    h.other.y(),
                                  h.other.z(),    h.area,         h.share,        h.depth1,
                                  h.depth2,       h.depth3,       h.depth,        h.facing};
  const Room to = room(1);
  for (int c = 0; c < kColumns; ++c) *to.column[c] = values[c];
  commit(1, static_cast<Side>(h.side), h.deep != 0);
}

Hit HitColumns::operator[](std::size_t i) const {
  const auto at = [&](Column c) { return columns_[c][i]; };
  return {{at(X), at(Y), at(Z)},
          {at(OwnX), at(OwnY), at(OwnZ)},
          {at(OtherX), at(OtherY), at(OtherZ)},
          at(Area),
          at(Share),
          at(Depth1),
          at(Depth2),
          at(Depth3),
          at(Depth),
          at(Facing),
          side_[i],
          deep_[i]};
}

}  // namespace cloudcontact
