// Bullet's broad phase as a value and back.
#include "bullet/tree_record.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

#include <map>
#include <new>
#include <set>
#include <stdexcept>

namespace cloudcontact {

namespace {

using Tree = TreeRecord::Tree;
using Node = TreeRecord::Node;

btDbvtProxy* proxyOf(const btCollisionObject* object) {
  return static_cast<btDbvtProxy*>(const_cast<btBroadphaseProxy*>(object->getBroadphaseHandle()));
}

// The counters of a broad phase, by reference.
template <typename Phase, typename Visit>
void eachCounter(Phase& phase, const Visit& visit) {
  int n = 0;
  visit(phase.m_stageCurrent, n++), visit(phase.m_newpairs, n++), visit(phase.m_fixedleft, n++);
  visit(phase.m_updates_call, n++), visit(phase.m_updates_done, n++), visit(phase.m_pid, n++);
  visit(phase.m_cid, n++), visit(phase.m_gid, n++), visit(phase.m_needcleanup, n++);
}

using Numbers = std::map<const void*, std::int32_t>;

void addNodes(const btDbvtNode* node, const Numbers& numbers, std::vector<Node>& nodes) {
  if (!node) return;
  const std::int32_t object = node->isleaf() ? numbers.at(node->data) : -1;
  nodes.push_back({object, {node->volume.Mins(), node->volume.Maxs()}});
  if (node->isleaf()) return;
  for (const btDbvtNode* child : node->childs) addNodes(child, numbers, nodes);
}

// The node at `next` with all below it.
btDbvtNode* makeNode(const std::vector<Node>& nodes, std::size_t& next, btDbvtNode* parent,
                     const std::vector<btCollisionObject*>& objects) {
  const Node& from = nodes[next++];
  auto* const node = new (btAlignedAlloc(sizeof(btDbvtNode), 16)) btDbvtNode();
  node->volume = btDbvtVolume::FromMM(from.box.least, from.box.most);
  node->parent = parent;
  if (from.object < 0) {
    for (btDbvtNode*& child : node->childs) child = makeNode(nodes, next, node, objects);
    return node;
  }
  btDbvtProxy* const proxy = proxyOf(objects[std::size_t(from.object)]);
  node->childs[1] = nullptr;
  node->data = proxy;
  proxy->leaf = node;
  return node;
}

void restoreTree(const Tree& from, const std::vector<btCollisionObject*>& objects, btDbvt& tree) {
  tree.clear();
  std::size_t next = 0;
  tree.m_root = from.nodes.empty() ? nullptr : makeNode(from.nodes, next, nullptr, objects);
  tree.m_lkhd = from.lookahead;
  tree.m_leaves = from.leaves;
  tree.m_opath = from.path;
}

[[noreturn]] void refuse() {
  throw std::runtime_error("a record of a broad phase is of other bodies");
}

// Adds the objects of a whole tree.
void checkTree(const Tree& tree, std::size_t objects, std::multiset<std::int32_t>& found) {
  std::size_t wanted = tree.nodes.empty() ? 0 : 1;
  for (const Node& node : tree.nodes) {
    if (wanted == 0 || node.object >= std::int64_t(objects)) refuse();
    node.object < 0 ? ++wanted : --wanted;
    if (node.object >= 0) found.insert(node.object);
  }
  if (wanted != 0) refuse();
}

}  // namespace

TreeRecord treesOf(const btDbvtBroadphase& phase, const std::vector<btCollisionObject*>& objects) {
  TreeRecord record;
  Numbers numbers;
  for (const btCollisionObject* object : objects) {
    const btDbvtProxy& proxy = *proxyOf(object);
    numbers[&proxy] = static_cast<std::int32_t>(record.proxies.size());
    record.proxies.push_back({proxy.stage, {proxy.m_aabbMin, proxy.m_aabbMax}});
  }
  for (std::size_t i = 0; i < record.trees.size(); ++i) {
    const btDbvt& tree = phase.m_sets[i];
    Tree& to = record.trees[i];
    addNodes(tree.m_root, numbers, to.nodes);
    to.lookahead = tree.m_lkhd, to.leaves = tree.m_leaves, to.path = tree.m_opath;
  }
  for (std::size_t i = 0; i < record.stages.size(); ++i)
    for (const btDbvtProxy* proxy = phase.m_stageRoots[i]; proxy; proxy = proxy->links[1])
      record.stages[i].push_back(numbers.at(proxy));
  eachCounter(phase, [&](const auto& counter, int n) {
    record.counters[std::size_t(n)] = static_cast<std::int32_t>(counter);
  });
  record.updates = phase.m_updates_ratio;
  return record;
}

void validate(const TreeRecord& record, std::size_t objects) {
  std::multiset<std::int32_t> inTrees, inStages;
  for (const Tree& tree : record.trees) checkTree(tree, objects, inTrees);
  for (const std::vector<std::int32_t>& stage : record.stages)
    inStages.insert(stage.begin(), stage.end());
  std::multiset<std::int32_t> all;
  for (std::size_t i = 0; i < objects; ++i) all.insert(static_cast<std::int32_t>(i));
  if (record.proxies.size() != objects || inTrees != all || inStages != all) refuse();
}

void restoreTrees(const TreeRecord& record, btDbvtBroadphase& phase,
                  const std::vector<btCollisionObject*>& objects) {
  for (std::size_t i = 0; i < record.trees.size(); ++i)
    restoreTree(record.trees[i], objects, phase.m_sets[i]);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    btDbvtProxy& proxy = *proxyOf(objects[i]);
    proxy.stage = record.proxies[i].stage;
    proxy.m_aabbMin = record.proxies[i].box.least, proxy.m_aabbMax = record.proxies[i].box.most;
  }
  for (std::size_t i = 0; i < record.stages.size(); ++i) {
    btDbvtProxy* last = nullptr;
    phase.m_stageRoots[i] = nullptr;
    for (const std::int32_t object : record.stages[i]) {
      btDbvtProxy* const proxy = proxyOf(objects[std::size_t(object)]);
      proxy->links[0] = last, proxy->links[1] = nullptr;
      (last ? last->links[1] : phase.m_stageRoots[i]) = proxy;
      last = proxy;
    }
  }
  eachCounter(phase, [&](auto& counter, int n) {
    counter =
        static_cast<std::remove_reference_t<decltype(counter)>>(record.counters[std::size_t(n)]);
  });
  phase.m_updates_ratio = record.updates;
}

}  // namespace cloudcontact
