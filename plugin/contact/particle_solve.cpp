// Gauss-Seidel sweeps over the contacts in their order.
//
// A row is J = step (force + grip (rate - late)) with rate = -(v_particle - v_body) . normal;
// `late` is the rate that closes the gap first. J changes the rate by -K J, where K is the inverse
// mass along the normal, so one row is solved by J += (step (force + grip (rate - late)) - J) / (1
// + step grip K). Particles interact through the body alone: against a fixed body one sweep is
// exact, and a body as heavy as all particles takes about ten.
#include "contact/particle_solve.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

constexpr int kMostSweeps = 60;
constexpr double kSettled = 1e-10;  // change of a sweep relative to all impulses at which it stops

// Applies a change of a contact's impulse to both sides.
void apply(const Vec3& change, ParticleContact& c, RigidResponse& body) {
  c.velocity += c.inverseMass * change;
  body.push(-change, c.arm);
}

double alongNormal(const ParticleContact& c, const RigidResponse& body) {
  const Vec3 turn = c.arm.cross(c.normal);
  return c.inverseMass + body.inverseMass.cwiseProduct(c.normal).dot(c.normal) +
         turn.dot(body.inverseInertia * turn);
}

// An upper bound over all directions, so that the sweeps approach from one side and do not
// oscillate.
double sideways(const ParticleContact& c, const RigidResponse& body) {
  return c.inverseMass + body.inverseMass.maxCoeff() +
         c.arm.squaredNorm() * body.inverseInertia.trace();
}

double pushOn(ParticleContact& c, RigidResponse& body, double step) {
  const double rate = -(c.velocity - body.at(c.arm)).dot(c.normal);
  const double late = std::max(0.0, -c.depth) / step;
  const double wanted = step * (c.line.force + c.line.grip * (rate - late));
  const double before = c.push;
  c.push += (wanted - c.push) / (1 + step * c.line.grip * alongNormal(c, body));
  c.push = std::max(0.0, c.push);
  apply((c.push - before) * c.normal, c, body);
  return std::abs(c.push - before);
}

double rubOn(ParticleContact& c, RigidResponse& body, double friction) {
  const double inverse = sideways(c, body);
  if (!(friction > 0) || !(inverse > 0)) return 0;
  const Vec3 slip = c.velocity - body.at(c.arm);
  const Vec3 before = c.rub;
  c.rub -= (slip - slip.dot(c.normal) * c.normal) / inverse;
  const double most = friction * c.push, size = c.rub.norm();
  if (size > most) c.rub *= most / size;
  const Vec3 change = c.rub - before;
  apply(change, c, body);
  return change.norm();
}

}  // namespace

void solveParticles(std::vector<ParticleContact>& contacts, RigidResponse& body, double friction,
                    double step) {
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double change = 0, all = 0;
    for (ParticleContact& c : contacts) {
      change += pushOn(c, body, step) + rubOn(c, body, friction);
      all += c.push;
    }
    if (change <= kSettled * all) break;
  }
}

}  // namespace cloudcontact
