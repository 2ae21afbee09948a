// One step of particles against a cloud.
//
// Each particle is looked up in the cloud's field at the start of the step. The depth and normal
// there are the plane that it is behind in this step; by the paper's method it is pushed along the
// digital normal instead. A particle deeper than the band of five
// voxels keeps the plane by which it went in. A particle that moves more than a voxel a step gets
// the plane where its path enters the cloud.
//
// The pair's law is one spring, shared over all particles whether they touch or not. So neither
// their number nor their resolution changes how far a flat body sinks in. The paper's (1) shares
// among those in contact. That would stiffen the remaining ones as others leave, which creates
// energy, and particles leave one by one all the time.
//
// The links of a soft body and the body's other contacts act after this contact within a step.
// Contact that ignores them takes separations that they will undo for real: a rope over a ball lies
// seventeen times too deep and creeps, since friction holds against gravity alone. So both sides
// expect from them what they did to the velocities in the last step, as far as the last two steps
// agree (an impact does not come twice). For bodies at rest or in steady sliding that is exact.
#include "contact/particle_cloud.h"

#include <algorithm>
#include <cmath>

#include "field/field_ray.h"

namespace cloudcontact {

namespace {

// [voxels] A particle that stays farther outside than this gets no contact.
constexpr double kApart = 0.5;

// The part on which two steps agree.
Vec3 steady(const Vec3& last, const Vec3& before) {
  if (!(last.dot(before) > 0)) return Vec3::Zero();
  return last.squaredNorm() < before.squaredNorm() ? last : before;
}

bool full(const Cloud& cloud, const Vec3& local) {
  const Vec3 grid = (local - cloud.origin()) / cloud.voxelSize();
  if (!(grid.array().abs() < 32767.0).all()) return false;
  const Eigen::Vector3i v = grid.array().floor().cast<int>();
  return cloud.coverage(v.x(), v.y(), v.z()) >= 128;
}

}  // namespace

void ParticleCloud::forget() {
  memory_.clear();
  step_ = 0;
}

std::optional<ParticleCloud::Plane> ParticleCloud::planeOf(const Vec3& local, const Vec3& end,
                                                           const ParticleBody& body,
                                                           const Memory& memory) const {
  if (const auto found = body.field->at(local)) return Plane{found->depth, found->normal};
  const Cloud& cloud = body.field->cloud();
  if (memory.near && memory.depth > 0 && full(cloud, local)) {
    const double depth = memory.depth - (local - memory.local).dot(memory.normal);
    if (depth > 0) return Plane{depth, memory.normal};
  }
  if ((end - local).squaredNorm() < cloud.voxelSize() * cloud.voxelSize()) return std::nullopt;
  const auto hit = firstEntry(*body.field, local, end);
  if (!hit) return std::nullopt;
  const double depth = hit->fraction * (end - local).dot(hit->normal);
  if (!(depth < 0)) return std::nullopt;  // it starts inside and leaves
  return Plane{depth, hit->normal};
}

LawTangent ParticleCloud::shareOf(const Law& law, double share, double depth, double closing,
                                  Memory& memory, double step) const {
  const bool known = memory.near && step_ > 0;
  memory.state =
      known ? lawAdvance(law, memory.state, depth, step_) : lawAdvance(law, {}, depth, step);
  const LawTangent whole = lawTangent(law, memory.state, closing, step);
  return {share * whole.force, share * whole.grip};
}

LawTangent ParticleCloud::lineOf(const Particle& particle, const ParticleBody& body,
                                 const std::optional<KelvinVoigt>& spring, double depth,
                                 double closing, Memory& memory,
                                 const ParticleSettings& settings) const {
  if (settings.law)
    return shareOf(*settings.law, particle.share, depth, closing, memory, settings.step);
  if (spring) {
    Law law = *spring;
    if (settings.touched->byArea) law = Foundation{spring->stiffness, spring->damping};
    return shareOf(law, particle.share, depth, closing, memory, settings.step);
  }
  // A body on top of particles loads each with its share, however light they are.
  const double inverse = body.response.inverseMass.maxCoeff();
  const double mass = std::max(particle.inverseMass > 0 ? 1 / particle.inverseMass : 0.0,
                               inverse > 0 ? particle.share / inverse : 0.0);
  const AutomaticSpring automatic = automaticSpring(mass, settings.gravity * mass,
                                                    body.field->cloud().voxelSize(), settings.step);
  const SpringTangent line = automatic.tangent(depth, closing, settings.step);
  return {automatic.force(depth), settings.step * line.slope + line.damping};
}

void ParticleCloud::expectOfBody(const ParticleBody& body) {
  expected_ = body.response;
  if (step_ > 0) {
    const Vec3 linear = body.response.linear - linearAfter_;
    const Vec3 angular = body.response.angular - angularAfter_;
    expected_.linear += steady(linear, linearOthers_);
    expected_.angular += steady(angular, angularOthers_);
    linearOthers_ = linear;
    angularOthers_ = angular;
  } else {
    expected_.linear += body.pull;
    linearOthers_ = body.pull;
    angularOthers_.setZero();
  }
}

const std::vector<ParticleContact>& ParticleCloud::step(const std::vector<Particle>& particles,
                                                        const ParticleBody& body,
                                                        const ParticleSettings& settings) {
  if (memory_.size() != particles.size()) {
    forget();
    memory_.resize(particles.size());
  }
  contacts_.clear();
  expectOfBody(body);
  const RigidResponse before = expected_;
  const double voxel = body.field->cloud().voxelSize();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Particle& p = particles[i];
    Memory& memory = memory_[i];
    const Vec3 arm = p.start - body.center;
    const Vec3 meeting = p.velocity - expected_.at(arm);
    const Vec3 local = body.pose.toLocal(p.start);
    const Vec3 end = body.pose.toLocal(p.start + settings.step * meeting);
    const auto plane = planeOf(local, end, body, memory);
    if (!plane || !(p.share > 0)) {
      memory.near = false;
      continue;
    }
    Vec3 others = Vec3::Zero(), expected = Vec3::Zero();
    if (memory.near && step_ > 0) {
      others = (p.start - memory.start) / step_ - memory.after;
      expected = steady(others, memory.others);
    }
    ParticleTouch touch;
    if (settings.touched)
      touch = touchOf(*settings.touched, body.field->cloud(), local, plane->depth, plane->normal);
    const double vector = touch.vector.norm();
    const Vec3 normal =
        body.pose.orientation * (vector > 0 ? Vec3(touch.vector / vector) : plane->normal);
    const double closing = -(meeting + expected).dot(normal);
    if (p.inverseMass > 0 || body.response.inverseMass.maxCoeff() > 0) {
      std::optional<KelvinVoigt> spring;
      if (settings.touched) spring = inSeries(p.spring, touch.spring);
      const LawTangent line = lineOf(p, body, spring, plane->depth, closing, memory, settings);
      if (plane->depth + settings.step * std::max(0.0, closing) > -kApart * voxel)
        contacts_.push_back({static_cast<int>(i), normal, arm, plane->depth, line, p.inverseMass,
                             p.velocity + expected, 0, Vec3::Zero()});
    }
    memory = {memory.state, local, plane->normal, plane->depth, p.start, p.velocity, others, true};
  }
  solveParticles(contacts_, expected_, settings.friction, settings.step);
  for (const ParticleContact& c : contacts_)
    memory_[static_cast<std::size_t>(c.particle)].after += c.inverseMass * c.impulse();
  linearChange_ = expected_.linear - before.linear;
  angularChange_ = expected_.angular - before.angular;
  linearAfter_ = body.response.linear + linearChange_;
  angularAfter_ = body.response.angular + angularChange_;
  step_ = settings.step;
  return contacts_;
}

}  // namespace cloudcontact
