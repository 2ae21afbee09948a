// One tick: the tool follows the hand in steps of a voxel until it touches. There, the digital
// normal is the direction in which the material pushes, and the collision gives the depth. The tool
// moves along the normal to the embedding depth where the force of the material's law equals that
// of the hand's spring, and slides along the surface. The hand feels the spring.
//
// The collision is that of the tool's last position, so each tick is a Newton step toward the
// equilibrium on a curved surface. The tool moves at most a voxel per tick, as the last position
// says little about the surface farther away.
#include <cloudcontact/workpiece/haptic_loop.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr std::size_t kReserved = 1 << 14;  // collision voxels

bool isPerTissue(const Law& law) {
  return std::holds_alternative<KelvinVoigt>(law) || std::holds_alternative<Maxwell>(law) ||
         std::holds_alternative<StandardLinearSolid>(law);
}

void validate(const HapticSettings& s) {
  const auto positive = [](double value, const char* field) {
    if (!(value > 0) || !std::isfinite(value))
      throw std::invalid_argument(std::string("HapticSettings: ") + field +
                                  " must be positive and finite");
  };
  positive(s.step, "step");
  positive(s.handStiffness, "handStiffness");
  positive(s.mostForce, "mostForce");
  if (!(s.handDamping >= 0) || !std::isfinite(s.handDamping))
    throw std::invalid_argument("HapticSettings: handDamping must be zero or more and finite");
  if (!(s.release >= 0) || !std::isfinite(s.release))
    throw std::invalid_argument("HapticSettings: release must be zero or more and finite");
  if (s.voxelsAStep < 1)
    throw std::invalid_argument("HapticSettings: voxelsAStep must be positive");
  if (s.perTissue && !(s.law && isPerTissue(*s.law)))
    throw std::invalid_argument(
        "HapticSettings: perTissue needs a law KelvinVoigt, Maxwell or StandardLinearSolid");
  if (s.law &&
      (std::holds_alternative<Foundation>(*s.law) || std::holds_alternative<Rigid>(*s.law)))
    throw std::invalid_argument("HapticSettings: law must give one force; not Foundation or Rigid");
  if (s.law) validate(*s.law);
  validate(s.tool.area);
}

Vec3 atMost(const Vec3& v, double length) {
  const double norm = v.norm();
  return norm > length ? Vec3(v * (length / norm)) : v;
}

}  // namespace

HapticLoop::HapticLoop(BaseVectorField& workpiece, const Pose& workpiecePose,
                       const HapticSettings& settings)
    : workpiece_(&workpiece),
      workpiecePose_(workpiecePose),
      settings_(settings),
      collision_(&none_),
      process_(settings.cutter.value_or(Cutter{0, 0, 0})) {
  validate(settings);
  finder_.reserve(kReserved, workpiece.tissues().size());
  process_->reserve(kReserved);
  reaction_.tissues.reserve(workpiece.tissues().size());
  workpiece.reserve();
}

// The least length of the spring after this tick. Where material is removed or an edge ends,
// nothing holds the tool, and the force would vanish in one tick: a click at each voxel that a bur
// removes. Instead the spring relaxes by a fraction per tick. This only slows the tool's own
// motion, not the hand's, so the spring returns no more energy than the hand has put in.
double HapticLoop::leastLead(const Vec3& lead) const {
  if (settings_.release <= 0 || lead.dot(lastLead_) <= 0) return 0;
  const double least =
      std::exp(-settings_.step / settings_.release) * std::min(lead.norm(), lastLead_.norm());
  return least > 1e-3 * workpiece_->voxelSize() ? least : 0;
}

// The fraction of `step` after which the spring has its least length.
double HapticLoop::letGo(const Vec3& lead, const Vec3& step) const {
  const double least = leastLead(lead);
  if ((lead - step).norm() >= least) return 1;
  // |lead - t step| = least: the first of the two roots.
  const double a = step.squaredNorm(), b = lead.dot(step), c = lead.squaredNorm() - least * least;
  return std::clamp((b - std::sqrt(std::max(b * b - a * c, 0.0))) / a, 0.0, 1.0);
}

// Moves the tool toward the hand until it touches or arrives. True if it touches.
bool HapticLoop::follow(const Pose& hand) {
  const double voxel = workpiece_->voxelSize();
  output_.tool.orientation = hand.orientation;
  const Vec3 lead = hand.position - output_.tool.position;
  const double least = leastLead(lead);
  const Vec3 held = least > 0 ? Vec3(least / lead.norm() * lead) : Vec3::Zero();
  const Vec3 target = hand.position - held;
  for (int k = 0; k <= settings_.voxelsAStep; ++k) {
    collision_ = &finder_.find(*workpiece_, workpiecePose_, settings_.tool, output_.tool);
    if (!collision_->empty() && collision_->depth > 0) return true;
    const Vec3 way = target - output_.tool.position;
    if (way.norm() == 0 || k == settings_.voxelsAStep) break;
    output_.tool.position += atMost(way, voxel);
  }
  lastLead_ = held;
  return false;
}

Law HapticLoop::lawNow() const {
  const double k = collision_->stiffness, c = collision_->damping;
  if (!settings_.law) return KelvinVoigt{k, c};
  if (!settings_.perTissue) return *settings_.law;
  if (const auto* l = std::get_if<Maxwell>(&*settings_.law))
    return Maxwell{l->stiffness * k, l->damping * c};
  if (const auto* l = std::get_if<StandardLinearSolid>(&*settings_.law))
    return StandardLinearSolid{l->stiffness * k, l->branchStiffness * k, l->branchDamping * c};
  const auto& l = std::get<KelvinVoigt>(*settings_.law);
  return KelvinVoigt{l.stiffness * k, l.damping * c};
}

// The step along the surface, by the hand's spring against its own and the material's stiffness.
Vec3 HapticLoop::slide(const Vec3& lead, const Vec3& outward) const {
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - outward * outward.transpose();
  const Eigen::Matrix3d stiffness =
      Eigen::Matrix3d::Identity() +
      collision_->stiffness / settings_.handStiffness * across * collision_->facing * across;
  return across * stiffness.ldlt().solve(across * lead);
}

// The share of a step that is taken. Between walls, as in a hole that a bur has cut, the digital
// normal reverses within a fraction of a voxel. The full step assumes one surface and would lead
// from wall to wall, tick by tick. Where a step opposes the one before, the next is the secant
// between the two; then the share grows back to 1.
void HapticLoop::calm(const Vec3& step) {
  constexpr double kLeast = 0.05, kGrowth = 1.1;
  const Vec3 turn = step - lastStep_;
  if (step.dot(lastStep_) < 0)
    calm_ = std::clamp(-calm_ * lastStep_.dot(turn) / turn.squaredNorm(), kLeast, 1.0);
  else
    calm_ = std::min(1.0, kGrowth * calm_);
  lastStep_ = step;
}

void HapticLoop::press(const HapticInput& input) {
  const Vec3 outward = collision_->normal();
  const Vec3 lead = input.hand.position - output_.tool.position;
  // Depth of the tool where the hand is.
  const double reach = collision_->depth - lead.dot(outward);
  const Law law = lawNow();
  const Embedding found =
      embed(law, state_, settings_.step, {settings_.handStiffness, reach}, settings_.embedding);
  const double voxel = workpiece_->voxelSize();
  // A hand that leaves takes the tool along, beyond the surface: in a hole the walls touch the tool
  // all the way out, and it would otherwise leave only by its own depth per tick.
  const double target = std::min(found.depth, std::max(reach, 0.0)) + std::min(reach, 0.0);
  double deeper = std::clamp(target - collision_->depth, -voxel, voxel);
  const Vec3 step = atMost(slide(lead, outward), voxel) - deeper * outward;
  calm(step);
  if (lead.dot(outward) > 0) calm_ = 1;  // the hand leaves
  const double part = calm_ * letGo(lead, calm_ * step);
  deeper *= part;
  const double depth = std::max(0.0, collision_->depth + deeper);
  output_.tool.position += part * step;
  lastLead_ = lead.dot(outward) < 0 ? Vec3(lead - part * step) : atMost(lead, leastLead(lead));
  state_ = lawAdvance(law, state_, depth, settings_.step);
  output_.depth = depth;
  output_.stiffness = collision_->stiffness;
  output_.iterations = found.iterations;
  output_.end = found.end;

  Vec3 force = settings_.handStiffness * (output_.tool.position - input.hand.position);
  force -= settings_.handDamping * input.velocity;
  force = atMost(force, settings_.mostForce);
  react(*collision_, *workpiece_, force.norm(), 1, 0, input.hand.position, Direction::Unit,
        reaction_);
  output_.onHand.force = force;
  output_.onHand.torque = (collision_->center - input.hand.position).cross(force);
  if (!settings_.cutter) return;
  const CuttingProcess::Cut cut = process_->step(
      *workpiece_, *collision_, std::max(0.0, force.dot(outward)),
      (input.velocity - input.velocity.dot(outward) * outward).norm(), settings_.step);
  output_.cutVoxels = cut.voxels;
  output_.cutVolume = cut.volume;
}

// A force acts until the next tick, so its work over the hand's motion is exact.
void HapticLoop::watchEnergy(const Vec3& hand) {
  if (started_) output_.energy -= output_.onHand.force.dot(hand - lastHand_);
  output_.leastEnergy = std::min(output_.leastEnergy, output_.energy);
  lastHand_ = hand;
}

const HapticOutput& HapticLoop::tick(const HapticInput& input) noexcept {
  const bool finite = input.hand.position.allFinite() && input.velocity.allFinite() &&
                      input.hand.orientation.coeffs().allFinite() &&
                      input.hand.orientation.norm() > 0.5;
  if (finite) watchEnergy(input.hand.position);
  output_.onHand = {};
  output_.cutVoxels = 0;
  output_.cutVolume = 0;
  if (!finite) return output_;
  if (!started_) output_.tool = input.hand;
  started_ = true;
  try {
    if (follow(input.hand)) {
      press(input);
    } else {
      state_ = {};
      lastStep_.setZero();
      calm_ = 1;
      output_.depth = output_.stiffness = 0;
      output_.iterations = 0;
      output_.end = EmbeddingEnd::NotPressed;
      // The hand may be farther away than the tool follows in a tick: it feels the spring.
      output_.onHand.force =
          atMost(settings_.handStiffness * (output_.tool.position - input.hand.position),
                 settings_.mostForce);
    }
  } catch (...) {
    output_.onHand = {};  // a user's law throws: no force
  }
  return output_;
}

}  // namespace cloudcontact
