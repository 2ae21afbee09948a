// Children by slot and by their objects.
#include "bullet/compound_children.h"

namespace cloudcontact {

bool ChildPath::readFrom(const btCollisionObjectWrapper& wrap) {
  depth = 0;
  for (const auto* at = &wrap; at->m_parent; at = at->m_parent) {
    if (depth == kDeepest) return false;
    index[depth++] = at->m_index;
  }
  std::reverse(index, index + depth);
  return true;
}

void CompoundChildren::remember(AheadPair& pair, const btCollisionObjectWrapper& a,
                                const btCollisionObjectWrapper& b, int& slot) {
  Child child{&pair,
              {a.getCollisionObject(), b.getCollisionObject()},
              {a.getCollisionShape(), b.getCollisionShape()},
              {}};
  if (!child.path[0].readFrom(a) || !child.path[1].readFrom(b)) return;
  forget(pair, slot);
  slot = static_cast<int>(children_.size());
  children_.push_back(child);
}

void CompoundChildren::forget(const AheadPair& pair, int slot) {
  const auto place = static_cast<std::size_t>(slot);
  if (slot >= 0 && place < children_.size() && children_[place].pair == &pair)
    children_[place].pair = nullptr;
}

void CompoundChildren::clear() {
  children_.clear();
  sorted_.clear();
}

void CompoundChildren::sort() {
  sorted_.resize(children_.size());
  for (std::size_t i = 0; i < sorted_.size(); ++i) sorted_[i] = static_cast<std::uint32_t>(i);
  std::sort(sorted_.begin(), sorted_.end(), [this](std::uint32_t i, std::uint32_t j) {
    const Objects a(children_[i]), b(children_[j]);
    return a < b || (!(b < a) && i < j);
  });
}

}  // namespace cloudcontact
