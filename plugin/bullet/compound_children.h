// The cloud pairs that live inside Bullet's algorithms for compounds, which do not show them: each
// is remembered as a step processes it, and found again by its objects in the next one.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

namespace cloudcontact {

class CloudAlgorithm;

// Which child of which child of an object's shape; compounds hung deeper are not followed.
struct ChildPath {
  static constexpr int kDeepest = 4;
  int index[kDeepest] = {};
  int depth = 0;  // 0: the object's own shape

  // False where the wrapper is deeper than that.
  bool readFrom(const btCollisionObjectWrapper& wrap);
};

class CompoundChildren {
 public:
  // Objects and shapes are compared, never looked at: they may be gone.
  struct Child {
    CloudAlgorithm* pair = nullptr;
    const btCollisionObject* object[2] = {};
    const btCollisionShape* shape[2] = {};
    ChildPath path[2];
  };

  // `slot`: the pair's own, -1 at first.
  void remember(CloudAlgorithm& pair, const btCollisionObjectWrapper& a,
                const btCollisionObjectWrapper& b, int& slot);
  void forget(const CloudAlgorithm& pair, int slot);
  void clear();

  // Makes children found by their objects; before the first visit() after remember().
  void sort();
  // Calls visit(pair, wrapper, wrapper) for the children of a pair of objects that are still what
  // they were, with wrappers as Bullet's compound algorithms make them.
  template <typename Visit>
  void visit(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
             const Visit& visit) const {
    const Objects wanted(a.getCollisionObject(), b.getCollisionObject());
    auto found = std::lower_bound(
        sorted_.begin(), sorted_.end(), wanted,
        [this](std::uint32_t i, const Objects& o) { return Objects(children_[i]) < o; });
    for (; found != sorted_.end() && !(wanted < Objects(children_[*found])); ++found) {
      const Child& child = children_[*found];
      if (!child.pair) continue;
      const bool swapped = child.object[0] != a.getCollisionObject();
      follow(swapped ? b : a, child, 0, 0, [&](const btCollisionObjectWrapper& first) {
        follow(swapped ? a : b, child, 1, 0,
               [&](const btCollisionObjectWrapper& second) { visit(*child.pair, first, second); });
      });
    }
  }

 private:
  struct Objects {  // in either order
    const btCollisionObject *low, *high;
    Objects(const btCollisionObject* a, const btCollisionObject* b)
        : low(std::min(a, b, std::less<>())), high(std::max(a, b, std::less<>())) {}
    explicit Objects(const Child& child) : Objects(child.object[0], child.object[1]) {}
    bool operator<(const Objects& other) const {
      const std::less<> less;
      return less(low, other.low) || (low == other.low && less(high, other.high));
    }
  };

  // The place of a child as btCompoundCollisionAlgorithm works it out, to the bit.
  template <typename Visit>
  static void follow(const btCollisionObjectWrapper& wrap, const Child& child, int side, int level,
                     const Visit& visit) {
    const ChildPath& path = child.path[side];
    const btCollisionShape& shape = *wrap.getCollisionShape();
    if (level == path.depth) {
      if (&shape == child.shape[side]) visit(wrap);
      return;
    }
    if (!shape.isCompound()) return;
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    const int index = path.index[level];
    if (index < 0 || index >= compound.getNumChildShapes()) return;
    const btTransform place = wrap.getWorldTransform() * compound.getChildTransform(index);
    const btCollisionObjectWrapper inner(&wrap, compound.getChildShape(index),
                                         wrap.getCollisionObject(), place, -1, index);
    follow(inner, child, side, level + 1, visit);
  }

  std::vector<Child> children_;
  std::vector<std::uint32_t> sorted_;  // numbers of children, by their objects
};

}  // namespace cloudcontact
