// Bodies of a world that deform.
#include <cloudcontact/bullet/soft_contact_point.h>

#include <algorithm>
#include <iostream>
#include <vector>

#include "scene/bullet_vectors.h"
#include "scene/running_world.h"

namespace cloudcontact::program {
namespace {

constexpr double kOnSide =
    0.25;  // of the spacing: nodes this near to a side of the bounds are on it

struct SoftSums {
  double mass = 0;
  Vec3 center = Vec3::Zero(), velocity = Vec3::Zero();
};

// Held nodes have their mass, too.
SoftSums sumsOf(const SoftTissue& tissue) {
  SoftSums sums;
  for (int i = 0; i < tissue.nodes(); ++i) {
    const double mass = tissue.matter(i).mass;
    sums.mass += mass;
    sums.center += mass * fromBullet(tissue.body().m_nodes[i].m_x);
    sums.velocity += mass * fromBullet(tissue.body().m_nodes[i].m_v);
  }
  sums.center /= sums.mass;
  sums.velocity /= sums.mass;
  return sums;
}

}  // namespace

void World::State::makeSoft(Body& body) {
  const SoftMatter& matter = *body.parts.soft;
  const SceneSoft& soft = *body.scene.collisions.front().soft;
  SoftTissueSettings settings;
  settings.spacing = soft.spacing;
  body.soft = std::make_unique<SoftTissue>(matter.cloud, matter.tissues,
                                           toBullet(body.scene.pose * matter.place),
                                           world.getWorldInfo(), settings);
  const SoftSums sums = sumsOf(*body.soft);
  body.parts.mass = sums.mass;
  body.parts.frame.position = body.scene.pose.toLocal(sums.center);
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, nullptr);
  info.m_startWorldTransform = toBullet(body.scene.pose * body.parts.frame);
  body.own = std::make_unique<btRigidBody>(info);
  body.rigid = body.own.get();
  auto& nodes = body.soft->body().m_nodes;
  for (int i = 0; i < nodes.size(); ++i) {
    const Vec3 arm = fromBullet(nodes[i].m_x) - body.scene.pose.position;
    nodes[i].m_v = toBullet(body.scene.linearVelocity + body.scene.angularVelocity.cross(arm));
  }
  holdSides(body, soft);
}

// Nodes at the sides of the bounds, in the collision's axes.
void World::State::holdSides(Body& body, const SceneSoft& soft) {
  const Pose collision = body.scene.pose * body.scene.collisions.front().pose;
  btSoftBody& nodes = body.soft->body();
  const auto place = [&](int i) { return collision.toLocal(fromBullet(nodes.m_nodes[i].m_x)); };
  Eigen::AlignedBox3d bounds;
  for (int i = 0; i < nodes.m_nodes.size(); ++i) bounds.extend(place(i));
  for (int i = 0; i < nodes.m_nodes.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const double at = place(i)[axis];
      const auto side = static_cast<std::size_t>(2 * axis);
      if ((soft.held[side] && at < bounds.min()[axis] + kOnSide * soft.spacing) ||
          (soft.held[side + 1] && at > bounds.max()[axis] - kOnSide * soft.spacing)) {
        nodes.setMass(i, 0);
        nodes.m_nodes[i].m_v.setZero();
      }
    }
}

// Their frames, and their energy for the next look.
void World::State::followSoft() {
  for (auto& body : bodies) {
    if (!body.soft) continue;
    const SoftSums sums = sumsOf(*body.soft);
    btTransform at = body.rigid->getWorldTransform();
    at.setOrigin(toBullet(sums.center));
    body.rigid->setWorldTransform(at);
    body.rigid->setLinearVelocity(toBullet(sums.velocity));
  }
  measureSoft();
}

void World::State::measureSoft() {
  softEnergy = {};
  const Vec3 gravity = fromBullet(world.getGravity());
  for (const auto& body : bodies) {
    if (!body.soft) continue;
    for (int i = 0; i < body.soft->nodes(); ++i) {
      const double mass = body.soft->matter(i).mass;
      const btSoftBody::Node& node = body.soft->body().m_nodes[i];
      softEnergy.kinetic += 0.5 * mass * fromBullet(node.m_v).squaredNorm();
      softEnergy.potential -= mass * gravity.dot(fromBullet(node.m_x));
    }
  }
  softEnergy.elastic = elasticEnergy();
}

double World::State::elasticEnergy() const {
  double sum = 0;
  for (const auto& body : bodies)
    if (body.soft) sum += body.soft->elasticEnergy();
  return sum;
}

void World::State::takeSoftCuts() {
  for (const SoftCut& cut : cutter.softCuts())
    for (auto& body : bodies)
      if (body.soft.get() == cut.tissue) body.cutLinks += static_cast<int>(cut.links);
}

// Bullet has no contact between soft bodies and planes, and ours needs voxels.
void World::State::noteSoftOnPlanes() const {
  const Body *soft = nullptr, *plane = nullptr;
  for (const auto& body : bodies) {
    if (body.soft) soft = &body;
    if (body.parts.drawn.isPlane()) plane = &body;
  }
  if (soft && plane)
    std::cerr << "cloudcontact: body '" << soft->scene.name
              << "' deforms and falls through planes ('" << plane->scene.name
              << "'); stand it on a <box>\n";
}

// One patch for each other body.
void World::State::softContacts(ContactsNow& now) const {
  std::vector<SoftContactPoint> points;
  for (const auto& body : bodies) {
    if (!body.soft) continue;
    points.clear();
    cloudContact->softContacts(body.soft->body(), points);
    const btCollisionObject* other = nullptr;
    for (const SoftContactPoint& p : points) {
      if (p.other != other)
        now.patches.push_back(
            {body.rigid->getUserIndex(), p.other->getUserIndex(), now.points.size(), 0});
      other = p.other;
      ++now.patches.back().points;
      const Vec3 force = latestStep > 0 ? Vec3(-p.impulse / latestStep) : Vec3::Zero();
      now.points.push_back({p.position, -p.normal, force, p.depth});
    }
  }
}

bool World::isSoft(std::size_t body) const {
  return state_->bodies[body].soft != nullptr;
}

SoftRecord World::softRecord(std::size_t body) const {
  const State::Body& b = state_->bodies[body];
  const std::vector<int>& pieces = b.soft->pieces();
  return {b.soft->nodes(), b.soft->body().m_links.size(), b.cutLinks,
          1 + *std::max_element(pieces.begin(), pieces.end())};
}

Mesh World::softSurface(std::size_t body) const {
  Mesh mesh = state_->bodies[body].soft->surface();
  const Pose& at = pose(body);
  for (Vec3& v : mesh.vertices) v = at.toLocal(v);
  return mesh;
}

}  // namespace cloudcontact::program
