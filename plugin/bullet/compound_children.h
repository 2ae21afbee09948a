// CompoundChildren: the cloud pairs inside Bullet's algorithms for compounds, which hide them. A
// step remembers each pair as it is processed; the next step finds them by their objects.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "bullet/box_gap.h"

namespace cloudcontact {

class AheadPair;  // look_ahead.h

// The path to a child in nested compounds.
struct ChildPath {
  static constexpr int kDeepest = 4;
  int index[kDeepest] = {};
  int depth = 0;  // 0: the object's own shape

  // False if the wrapper is deeper than kDeepest.
  bool readFrom(const btCollisionObjectWrapper& wrap);
};

class CompoundChildren {
 public:
  // Objects and shapes may be deleted by now: pointers are compared, never followed.
  struct Child {
    AheadPair* pair = nullptr;
    const btCollisionObject* object[2] = {};
    const btCollisionShape* shape[2] = {};
    ChildPath path[2];
  };

  // `slot` belongs to the pair and is -1 at first.
  void remember(AheadPair& pair, const btCollisionObjectWrapper& a,
                const btCollisionObjectWrapper& b, int& slot);
  void forget(const AheadPair& pair, int slot);
  void clear();

  // Sorts children by their objects; call it before the first visit() after remember().
  void sort();
  // Calls visit(pair, wrapper, wrapper) for the children of a pair of objects whose shapes are
  // still the same and whose boxes meet, with wrappers as Bullet's compound algorithms make them.
  template <typename Visit>
  void visit(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
             const Visit& visit) const {
    const Objects objects(a.getCollisionObject(), b.getCollisionObject());
    auto found = std::lower_bound(
        sorted_.begin(), sorted_.end(), objects,
        [this](std::uint32_t i, const Objects& o) { return Objects(children_[i]) < o; });
    for (; found != sorted_.end() && !(objects < Objects(children_[*found])); ++found) {
      const Child& child = children_[*found];
      if (!child.pair) continue;
      const bool swapped = child.object[0] != a.getCollisionObject();
      follow(swapped ? b : a, child, 0, 0, [&](const btCollisionObjectWrapper& first) {
        follow(swapped ? a : b, child, 1, 0, [&](const btCollisionObjectWrapper& second) {
          // Bullet asks for no others. Children that rock against each other meet and part all the
          // time.
          if (boxesMeet(first, second)) visit(*child.pair, first, second);
        });
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

  // Computes the transform of a child as btCompoundCollisionAlgorithm does, to the bit.
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
  std::vector<std::uint32_t> sorted_;  // indices into children_, by their objects
};

}  // namespace cloudcontact
