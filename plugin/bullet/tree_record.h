// Bullet's dynamic tree broad phase as a value: its two trees node by node, its lists of proxies,
// and its counters. The trees decide in which order pairs are found that meet later, and how far
// boxes reach beyond their bodies depends on how these have moved, so neither follows from the
// bodies' places.
#pragma once

#include <LinearMath/btVector3.h>

#include <array>
#include <cstdint>
#include <vector>

#include "base/byte_archive.h"

struct btDbvtBroadphase;
class btCollisionObject;

namespace cloudcontact {

struct TreeRecord {
  struct Box {
    btVector3 least, most;
  };
  struct Node {
    std::int32_t object = -1;  // its number in the list of objects; -1: the node has two children
    Box box;
  };
  struct Tree {
    std::vector<Node> nodes;  // each before its children
    std::int32_t lookahead = -1, leaves = 0;
    std::uint32_t path = 0;  // of its next improvement
  };
  struct Proxy {
    std::int32_t stage = 0;
    Box box;
  };
  std::array<Tree, 2> trees;
  std::vector<Proxy> proxies;                       // of the objects
  std::array<std::vector<std::int32_t>, 3> stages;  // the objects of each list, in its order
  std::array<std::int32_t, 10> counters{};          // of updates and cleanups
  btScalar updates = 0;                             // the share of them that was needed
};

// `objects`: all that have a proxy in it.
TreeRecord treesOf(const btDbvtBroadphase& phase, const std::vector<btCollisionObject*>& objects);
// Throws std::runtime_error if the record is not one of so many objects.
void validate(const TreeRecord& record, std::size_t objects);
// A valid record. Pairs stay as they are.
void restoreTrees(const TreeRecord& record, btDbvtBroadphase& phase,
                  const std::vector<btCollisionObject*>& objects);

template <typename Archive>
void treesIn(Archive& archive, TreeRecord& record) {
  const auto boxIn = [](Archive& a, TreeRecord::Box& box) {
    for (btVector3* v : {&box.least, &box.most}) a((*v)[0], (*v)[1], (*v)[2]);
  };
  for (TreeRecord::Tree& tree : record.trees) {
    listIn(archive, tree.nodes, [&](Archive& a, TreeRecord::Node& node) {
      a(node.object);
      boxIn(a, node.box);
    });
    archive(tree.lookahead, tree.leaves, tree.path);
  }
  listIn(archive, record.proxies, [&](Archive& a, TreeRecord::Proxy& proxy) {
    a(proxy.stage);
    boxIn(a, proxy.box);
  });
  for (std::vector<std::int32_t>& stage : record.stages)
    listIn(archive, stage, [](Archive& a, std::int32_t& object) { a(object); });
  for (std::int32_t& counter : record.counters) archive(counter);
  archive(record.updates);
}

}  // namespace cloudcontact
