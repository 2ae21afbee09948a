// Each body that may be cut has a field of base vectors beside its shape, cut along with it: its
// collision voxels are what a tool takes away.
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <cloudcontact/bullet/world_cutter.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bullet/convert.h"
#include "bullet/object_motion.h"

namespace cloudcontact {

namespace {

// The normal force [N] between two objects over the last step.
double forceBetween(btDispatcher& dispatcher, const btCollisionObject& one,
                    const btCollisionObject& other, double step) {
  double impulse = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    const btCollisionObject *const a = manifold.getBody0(), *const b = manifold.getBody1();
    if (!((a == &one && b == &other) || (a == &other && b == &one))) continue;
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      impulse += double(manifold.getContactPoint(k).m_appliedImpulse);
  }
  return impulse / step;
}

// The mean speed of the tool over the collision voxels [m/s].
double speedOver(const Collision& collision, const BaseVectorField& field, const Pose& place,
                 const Motion& tool, const Motion& body) {
  double sum = 0;
  for (const CollisionVoxel& v : collision.voxels) {
    const Vec3 grid = v.voxel.cast<double>() + Vec3::Constant(0.5);
    const Vec3 at = place.toWorld(field.origin() + field.voxelSize() * grid);
    sum += static_cast<double>(v.share) * (tool.at(at) - body.at(at)).norm();
  }
  return collision.count > 0 ? sum / collision.count : 0;
}

}  // namespace

struct WorldCutter::State {
  struct Tool {
    const btCollisionObject* object;
    Detection detection;
    double hardness;
    CuttingProcess process;
  };

  struct Work {
    CuttableBody* body;
    std::unique_ptr<BaseVectorField> field;
  };

  std::vector<Tool> tools;
  std::vector<Work> works;
  // Fields of what fell off in the last step, for addBody().
  std::vector<std::pair<const CuttableBody*, std::unique_ptr<BaseVectorField>>> pieces;
  std::vector<SoftTissue*> tissues;
  std::vector<SoftCut> softCuts;
  CollisionFinder finder;

  double cutBy(Tool& tool, Work& work, double step, std::vector<VoxelCut>& cuts);
  void cut(std::size_t k, double step, std::vector<WorldCut>& done);
  void cutTissues();
  static void follow(Work& work);
};

WorldCutter::WorldCutter() : state_(std::make_unique<State>()) {}
WorldCutter::~WorldCutter() = default;

void WorldCutter::addTool(const btCollisionObject& object, const Detection& tool,
                          const Cutter& cutter) {
  validate(tool.area);
  Cutter exact = cutter;
  exact.keepsOutside = true;
  state_->tools.push_back({&object, tool, cutter.hardness, CuttingProcess(exact)});
  state_->tools.back().detection.depth = DepthTo::Nearest;  // not used, and the cheaper one
}

void WorldCutter::removeTool(const btCollisionObject& object) {
  std::erase_if(state_->tools, [&](const State::Tool& t) { return t.object == &object; });
}

void WorldCutter::addBody(CuttableBody& body, const TissueTable& tissues) {
  std::unique_ptr<BaseVectorField> field;
  for (auto& piece : state_->pieces)
    if (piece.first == &body) field = std::move(piece.second);
  if (!field || !(field->tissues() == tissuesOf(tissues, body.cloud().materials())))
    field = std::make_unique<BaseVectorField>(body.cloud(), tissues,
                                              sphereWindow(body.cloud().voxelSize()));
  field->reserve();  // a block more than there is room for would cost 5 ms in 100,000 voxels
  state_->works.push_back({&body, std::move(field)});
}

void WorldCutter::removeBody(const CuttableBody& body) {
  std::erase_if(state_->works, [&](const State::Work& w) { return w.body == &body; });
}

void WorldCutter::addTissue(SoftTissue& tissue) {
  state_->tissues.push_back(&tissue);
}

void WorldCutter::removeTissue(const SoftTissue& tissue) {
  std::erase(state_->tissues, &tissue);
}

const std::vector<SoftCut>& WorldCutter::softCuts() const {
  return state_->softCuts;
}

void WorldCutter::State::cutTissues() {
  softCuts.clear();
  for (SoftTissue* const tissue : tissues) {
    std::size_t links = 0;
    for (const Tool& tool : tools)
      links += tissue->cut(tool.detection, toPose(tool.object->getWorldTransform()), tool.hardness);
    if (links > 0) softCuts.push_back({tissue, links});
  }
}

// Takes what one tool cuts out of the body's field; returns the volume [m^3].
double WorldCutter::State::cutBy(Tool& tool, Work& work, double step, std::vector<VoxelCut>& cuts) {
  btDynamicsWorld* const world = work.body->world();
  if (!world) return 0;
  const btRigidBody& body = work.body->body();
  const double force = forceBetween(*world->getDispatcher(), *tool.object, body, step);
  if (!(force > 0)) return 0;
  const Pose place = toPose(work.body->cloudPlace());
  const Collision& collision =
      finder.find(*work.field, place, tool.detection, toPose(tool.object->getWorldTransform()));
  const double speed =
      speedOver(collision, *work.field, place, motionOf(*tool.object), motionOf(body));
  const CuttingProcess::Cut cut = tool.process.step(*work.field, collision, force, speed, step);
  const std::vector<VoxelCut>& last = tool.process.last();
  cuts.insert(cuts.end(), last.begin(), last.end());
  return cut.volume;
}

void WorldCutter::State::cut(std::size_t k, double step, std::vector<WorldCut>& done) {
  Work& work = works[k];
  CuttableBody& body = *work.body;
  std::vector<VoxelCut> cuts;
  double volume = 0;
  for (Tool& tool : tools) volume += cutBy(tool, work, step, cuts);
  if (cuts.empty() && !body.behind()) return;
  const auto others = std::count_if(works.begin(), works.end(), [&](const Work& other) {
    return other.body != &body && other.body->behind();
  });
  done.push_back({&body, volume, body.cutGradually(cuts, 1 / (1.0 + double(others)))});
  for (const auto& piece : done.back().outcome.fallen)
    pieces.emplace_back(piece.get(),
                        std::make_unique<BaseVectorField>(work.field->ofPart(piece->cloud())));
  if (!done.back().outcome.gone) follow(work);
}

// Crumbs and pieces that fell off are still in the field.
void WorldCutter::State::follow(Work& work) {
  const double cubic = std::pow(work.field->voxelSize(), 3);
  if (std::abs(work.field->mass().volume - work.body->volume()) > 1e-3 * cubic)
    work.field->keepPart(work.body->cloud());
}

std::vector<WorldCut> WorldCutter::after(double step) {
  if (!(step > 0)) throw std::invalid_argument("WorldCutter::after: the step must be positive");
  std::vector<WorldCut> done;
  state_->pieces.clear();
  for (std::size_t k = 0; k < state_->works.size(); ++k) state_->cut(k, step, done);
  state_->cutTissues();
  std::erase_if(state_->works, [&](const State::Work& w) {
    return std::any_of(done.begin(), done.end(),
                       [&](const WorldCut& cut) { return cut.body == w.body && cut.outcome.gone; });
  });
  return done;
}

}  // namespace cloudcontact
