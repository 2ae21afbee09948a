// Bullet moves the nodes by their velocities, then clouds push them, and then an action of the
// world, which Bullet runs before it solves its own constraints, moves them as the links want. At
// the step's end Bullet sets the velocities from where the nodes are.
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <BulletSoftBody/btSoftBodySolvers.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <cloudcontact/bullet/soft_tissue.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "bullet/convert.h"
#include "bullet/soft_springs.h"
#include "bullet/soft_surface.h"
#include "bullet/tissue_body.h"

namespace cloudcontact {

namespace {

void validateSoft(const Cloud& cloud, const TissueTable& tissues,
                  const SoftTissueSettings& settings) {
  validate(tissues);
  if (cloud.empty()) throw std::invalid_argument("SoftTissue: the cloud is empty");
  if (tissues.size() != 1 && tissues.size() != cloud.materials().size())
    throw std::invalid_argument(
        "SoftTissue: give one tissue for each of the cloud's materials, or one for all");
  for (const Tissue& tissue : tissues)
    if (!(tissue.elasticity > 0))
      throw std::invalid_argument("tissue " + tissue.name +
                                  ": soft tissue needs its elasticity, a modulus in Pa");
  if (!(settings.friction >= 0) || !std::isfinite(settings.friction))
    throw std::invalid_argument("SoftTissueSettings::friction must be zero or more and finite");
}

// What cuts, in its own frame.
struct Blade {
  const PlacedSolid& area;
  double ability;  // outside all parts
  const std::vector<CuttingPart>& parts;
  double hardness;
  bool isExact;  // its area's depth is a distance

  Blade(const Detection& tool, double ofTool)
      : area(tool.area),
        ability(tool.ability),
        parts(tool.parts),
        hardness(ofTool),
        isExact(isDistance(tool.area.solid)) {}
  // Whether it cuts matter of `resistance` [Pa] somewhere between a and b.
  bool cuts(double resistance, const Vec3& a, const Vec3& b) const {
    const double length = (b - a).norm(), least = 0.01 * length;
    if (!(length > 0)) return false;
    for (double at = 0; at <= length;) {
      const Vec3 point = a + at / length * (b - a);
      const double depth = depthOf(area, point);
      if (depth >= 0 && abilityAt(ability, parts, point) * hardness > resistance) return true;
      at += isExact ? std::max(-depth, least) : least;
    }
    return false;
  }
};

// The parts that hold together, numbered in the order of their first nodes.
std::vector<int> piecesOf(int nodes, const std::vector<SoftLink>& links) {
  std::vector<int> root(static_cast<std::size_t>(nodes));
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[static_cast<std::size_t>(i)] != i) i = root[static_cast<std::size_t>(i)];
    return i;
  };
  for (const SoftLink& link : links) {
    const auto [low, high] = std::minmax({find(link.a), find(link.b)});
    root[static_cast<std::size_t>(high)] = low;
  }
  int count = 0;
  std::vector<int> number(root.size(), -1);
  for (int i = 0; i < nodes; ++i) {
    int& known = number[static_cast<std::size_t>(find(i))];
    if (known < 0) known = count++;
    number[static_cast<std::size_t>(i)] = known;
  }
  return number;
}

}  // namespace

struct SoftTissue::State : btActionInterface {
  State(const Cloud& cloud, const TissueTable& tissues, double spacing)
      : lattice(softLattice(cloud, tissues, spacing)), surface(lattice) {}
  void makeBody(const btTransform& place, btSoftBodyWorldInfo& info,
                const SoftTissueSettings& settings, const TissueTable& tissues);
  void updateAction(btCollisionWorld*, btScalar) override;
  void debugDraw(btIDebugDraw*) override {}
  void drop(const std::vector<bool>& isCut);
  void measure();
  std::vector<Vec3> places() const;

  SoftLattice lattice;
  SoftSurface surface;
  SoftSprings springs;
  std::vector<SoftNode> moving;
  std::vector<int> pieces;  // of each node
  std::unique_ptr<TissueBody> body;
  btSoftRigidDynamicsWorld* world = nullptr;
};

void SoftTissue::State::makeBody(const btTransform& place, btSoftBodyWorldInfo& info,
                                 const SoftTissueSettings& settings, const TissueTable& tissues) {
  const Pose pose = toPose(place);
  btAlignedObjectArray<btVector3> at;
  btAlignedObjectArray<btScalar> masses;
  for (std::size_t i = 0; i < lattice.places.size(); ++i) {
    at.push_back(toBullet(pose.toWorld(lattice.places[i])));
    masses.push_back(btScalar(lattice.matter[i].mass));
  }
  body = std::make_unique<TissueBody>(&info, at.size(), &at[0], &masses[0]);
  body->setActivationState(DISABLE_DEACTIVATION);
  body->getCollisionShape()->setMargin(btScalar(0.1 * lattice.cell.minCoeff()));
  body->m_cfg.kDF = btScalar(settings.friction);
  body->m_cfg.m_psequence.remove(btSoftBody::ePSolver::Linear);  // updateAction() does that
  body->tissues = tissues;
  for (const NodeMatter& m : lattice.matter) body->springs.push_back({m.stiffness, m.damping});
  for (const SoftLink& link : lattice.links) body->appendLink(link.a, link.b);
  for (int i = 0; i < body->m_links.size(); ++i)
    body->m_links[i].m_rl = btScalar(lattice.links[static_cast<std::size_t>(i)].length);
  measure();
  body->wholeArea = std::accumulate(body->areas.begin(), body->areas.end(), 0.0);
}

void SoftTissue::State::measure() {
  pieces = piecesOf(static_cast<int>(lattice.places.size()), lattice.links);
  body->areas = surface.areas(lattice.places);
  ++body->cuts;
}

std::vector<Vec3> SoftTissue::State::places() const {
  std::vector<Vec3> now;
  for (int i = 0; i < body->m_nodes.size(); ++i) now.push_back(toVec3(body->m_nodes[i].m_x));
  return now;
}

void SoftTissue::State::updateAction(btCollisionWorld*, btScalar) {
  const double step = body->m_sst.sdt;
  if (!(step > 0)) return;
  moving.resize(static_cast<std::size_t>(body->m_nodes.size()));
  for (int i = 0; i < body->m_nodes.size(); ++i) {
    const btSoftBody::Node& node = body->m_nodes[i];
    moving[static_cast<std::size_t>(i)] = {toVec3(node.m_q), toVec3(node.m_x), node.m_im};
  }
  springs.step(lattice.links, pieces, moving, step);
  for (int i = 0; i < body->m_nodes.size(); ++i)
    if (body->m_nodes[i].m_im > 0)
      body->m_nodes[i].m_x = toBullet(moving[static_cast<std::size_t>(i)].place);
}

void SoftTissue::State::drop(const std::vector<bool>& isCut) {
  std::size_t left = 0;
  for (std::size_t k = 0; k < isCut.size(); ++k) {
    if (isCut[k]) {
      surface.part(lattice.links[k]);
      continue;
    }
    lattice.links[left] = lattice.links[k];
    body->m_links[static_cast<int>(left++)] = body->m_links[static_cast<int>(k)];
  }
  lattice.links.resize(left);
  body->m_links.resize(static_cast<int>(left));
  measure();
}

SoftTissue::SoftTissue(const Cloud& cloud, const TissueTable& tissues, const btTransform& place,
                       btSoftBodyWorldInfo& info, const SoftTissueSettings& settings) {
  validateSoft(cloud, tissues, settings);
  state_ = std::make_unique<State>(cloud, tissues, settings.spacing);
  state_->makeBody(place, info, settings, tissues);
}

SoftTissue::~SoftTissue() {
  leaveWorld();
}

btSoftBody& SoftTissue::body() {
  return *state_->body;
}
const btSoftBody& SoftTissue::body() const {
  return *state_->body;
}
const TissueTable& SoftTissue::tissues() const {
  return state_->body->tissues;
}
int SoftTissue::nodes() const {
  return static_cast<int>(state_->lattice.places.size());
}
const NodeMatter& SoftTissue::matter(int node) const {
  return state_->lattice.matter.at(static_cast<std::size_t>(node));
}
double SoftTissue::missed() const {
  return state_->springs.missed();
}

void SoftTissue::addTo(btSoftRigidDynamicsWorld& world) {
  leaveWorld();
  state_->world = &world;
  world.addSoftBody(state_->body.get());
  world.addAction(state_.get());
}

void SoftTissue::leaveWorld() {
  if (!state_->world) return;
  state_->world->removeAction(state_.get());
  state_->world->removeSoftBody(state_->body.get());
  state_->world = nullptr;
}

double SoftTissue::elasticEnergy() const {
  double sum = 0;
  const auto& nodes = state_->body->m_nodes;
  for (const SoftLink& link : state_->lattice.links) {
    const double stretch =
        (toVec3(nodes[link.b].m_x) - toVec3(nodes[link.a].m_x)).norm() - link.length;
    sum += 0.5 * link.stiffness * stretch * stretch;
  }
  return sum;
}

std::size_t SoftTissue::cut(const Detection& tool, const Pose& place, double hardness) {
  validate(tool.area);
  const std::vector<SoftLink>& links = state_->lattice.links;
  const Eigen::AlignedBox3d bounds = boundsOf(tool.area);
  const Blade blade(tool, hardness);
  std::vector<Vec3> inTool = state_->places();
  for (Vec3& at : inTool) at = place.toLocal(at);
  const auto resistance = [&](int node) {
    return tissues()[static_cast<std::size_t>(matter(node).tissue)].hardness;
  };
  std::vector<bool> isCut(links.size());
  std::size_t count = 0;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const Vec3 &a = inTool[static_cast<std::size_t>(links[k].a)],
               &b = inTool[static_cast<std::size_t>(links[k].b)];
    if (!bounds.intersects(Eigen::AlignedBox3d(a.cwiseMin(b), a.cwiseMax(b)))) continue;
    const Vec3 middle = 0.5 * (a + b);
    isCut[k] = blade.cuts(resistance(links[k].a), a, middle) ||
               blade.cuts(resistance(links[k].b), middle, b);
    if (isCut[k]) ++count;
  }
  if (count > 0) state_->drop(isCut);
  return count;
}

const std::vector<int>& SoftTissue::pieces() const {
  return state_->pieces;
}

Mesh SoftTissue::surface() const {
  return state_->surface.mesh(state_->places());
}

}  // namespace cloudcontact
