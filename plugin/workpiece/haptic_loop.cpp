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
  // In the hole that it cuts, a tool's reach along the normal jumps with the walls, and the force
  // by half from tick to tick; the distance to its nearest surface does not.
  if (settings.cutter) settings_.tool.depth = DepthTo::Nearest;
  finder_.reserve(kReserved, workpiece.tissues().size());
  process_->reserve(kReserved);
  if (settings.law) law_ = *settings.law;
  if (settings.embedding.search == Search::Table) table_.reserve(settings.embedding.tableEntries);
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

void HapticLoop::updateLaw() {
  const double k = collision_->stiffness, c = collision_->damping;
  if (!settings_.law) {
    law_ = KelvinVoigt{k, c};
  } else if (settings_.perTissue) {
    if (const auto* m = std::get_if<Maxwell>(&*settings_.law))
      law_ = Maxwell{m->stiffness * k, m->damping * c};
    else if (const auto* s = std::get_if<StandardLinearSolid>(&*settings_.law))
      law_ = StandardLinearSolid{s->stiffness * k, s->branchStiffness * k, s->branchDamping * c};
    else if (const auto* v = std::get_if<KelvinVoigt>(&*settings_.law))
      law_ = KelvinVoigt{v->stiffness * k, v->damping * c};
  }
}

Interaction HapticLoop::interactionNow() const {
  Interaction now{state_.depth, speed_, 0, collision_->stiffness, collision_->damping, 0, 0};
  for (const CollisionVoxel& v : collision_->voxels) {
    const double share = static_cast<double>(v.share) / collision_->count;
    now.hardness += share * workpiece_->tissues()[v.tissue].hardness;
    now.ability += share * static_cast<double>(v.ability);
  }
  return now;
}

// Of the material's force: |F| where (6) does not divide by it.
double HapticLoop::scale() const {
  return settings_.direction == Direction::Unit ? 1
                                                : collision_->mean.norm() / workpiece_->voxelSize();
}

// The table only brackets the answer, which `index` itself gives. So it serves until the tissues or
// the range have changed too much for it to be of use.
Embedding HapticLoop::searchTable(const HandSpring& hand, const Index& index) {
  constexpr double kSame = 0.25;  // relative difference
  const auto near = [](double a, double b) { return std::abs(a - b) <= kSame * b; };
  const bool kept = hand.reach <= table_.most() && hand.reach > 0.1 * table_.most() &&
                    near(collision_->stiffness, tabulated_.stiffness) &&
                    near(collision_->damping, tabulated_.damping);
  if (!(hand.stiffness * hand.reach > 0)) return {};
  if (kept) return table_.find(hand, settings_.embedding, index);
  table_.fill(index, 2 * hand.reach, settings_.embedding.tableEntries);
  tabulated_ = {collision_->stiffness, collision_->damping};
  Embedding found = table_.find(hand, settings_.embedding, index);
  found.iterations += settings_.embedding.tableEntries;
  return found;
}

// The embedding depth for a hand whose tool would be `reach` deep.
Embedding HapticLoop::search(double reach) {
  updateLaw();
  // One reference to capture, so that std::function does not allocate.
  const struct Query {
    const HapticLoop& loop;
    Interaction now;
    double scale;
    double force(double d) const {
      const double h = loop.settings_.step;
      if (!loop.settings_.index) return scale * lawForce(loop.law_, loop.state_, d, h);
      Interaction at = now;
      at.depth = d;
      at.speed = (d - now.depth) / h;
      at.acceleration = (at.speed - now.speed) / h;
      return scale * loop.settings_.index(at);
    }
    double slope(double d) const {
      return scale * lawSlope(loop.law_, loop.state_, d, loop.settings_.step);
    }
  } query{*this, settings_.index ? interactionNow() : Interaction{}, scale()};
  Index index([&query](double d) { return query.force(d); });
  if (!settings_.index && !std::holds_alternative<UserLaw>(law_))
    index.slope = [&query](double d) { return query.slope(d); };
  const HandSpring hand{settings_.handStiffness, reach};
  if (settings_.embedding.search == Search::Table) return searchTable(hand, index);
  return embed(index, hand, settings_.embedding);
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
  const Embedding found = search(reach);
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
  speed_ = (depth - state_.depth) / settings_.step;
  state_ = settings_.index ? LawState{depth, 0} : lawAdvance(law_, state_, depth, settings_.step);
  output_.depth = depth;
  output_.stiffness = collision_->stiffness;
  output_.iterations = found.iterations;
  output_.end = found.end;

  Vec3 force = settings_.handStiffness * (output_.tool.position - input.hand.position);
  force -= settings_.handDamping * input.velocity;
  force = atMost(force, settings_.mostForce);
  const double scaled = scale();
  react(*collision_, *workpiece_, scaled > 0 ? force.norm() / scaled : 0, 1, 0, input.hand.position,
        settings_.direction, reaction_);
  limit(force);
  output_.onHand.force = force;
  output_.onHand.torque = (collision_->center - input.hand.position).cross(force);
  if (!settings_.cutter) return;
  const CuttingProcess::Cut cut = process_->step(
      *workpiece_, *collision_, std::max(0.0, force.dot(outward)),
      (input.velocity - input.velocity.dot(outward) * outward).norm(), settings_.step);
  output_.cutVoxels = cut.voxels;
  output_.cutVolume = cut.volume;
}

void HapticLoop::limit(Vec3& force) {
  const Vec3 wanted = force;
  force = watch_.allowed(wanted, settings_.mostForce);
  output_.withheld = (wanted - force).norm();
}

const HapticOutput& HapticLoop::tick(const HapticInput& input) noexcept {
  const bool finite = input.hand.position.allFinite() && input.velocity.allFinite() &&
                      input.hand.orientation.coeffs().allFinite() &&
                      input.hand.orientation.norm() > 0.5;
  if (finite) watch_.observe(input.hand.position);
  output_.energy = watch_.energy();
  output_.leastEnergy = watch_.least();
  output_.onHand = {};
  output_.withheld = 0;
  output_.cutVoxels = 0;
  output_.cutVolume = 0;
  if (!finite) {
    watch_.allowed(Vec3::Zero(), 0);
    return output_;
  }
  if (!started_) output_.tool = input.hand;
  started_ = true;
  try {
    if (follow(input.hand)) {
      press(input);
    } else {
      state_ = {};
      speed_ = 0;
      lastStep_.setZero();
      calm_ = 1;
      output_.depth = output_.stiffness = 0;
      output_.iterations = 0;
      output_.end = EmbeddingEnd::NotPressed;
      // The hand may be farther away than the tool follows in a tick: it feels the spring.
      output_.onHand.force =
          atMost(settings_.handStiffness * (output_.tool.position - input.hand.position),
                 settings_.mostForce);
      limit(output_.onHand.force);
    }
  } catch (...) {
    output_.onHand = {};  // a user's law throws: no force
    watch_.allowed(Vec3::Zero(), 0);
  }
  return output_;
}

}  // namespace cloudcontact
