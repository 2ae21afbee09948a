// The pair's depth and rate from its points, its law's state from step to step.
#include "bullet/pair_memory.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <algorithm>

#include "bullet/convert.h"
#include "bullet/manifold_writer.h"

namespace cloudcontact {

namespace {

struct PairPoints {
  double whole = 0, depth = 0, closing = 0;
};

PairPoints gather(const PairSides& sides, const ContactResult& contact) {
  PairPoints sum;
  for (const ContactPoint& p : contact.points) {
    const Vec3 meeting = sides.motionA.at(p.position) - sides.motionB.at(p.position);
    sum.whole += p.stiffness;
    sum.depth += p.stiffness * std::max(0.0, p.depth);
    sum.closing += p.stiffness * meeting.dot(p.normal);
  }
  if (!(sum.whole > 0)) return {};
  sum.depth /= sum.whole;
  sum.closing /= sum.whole;
  return sum;
}

}  // namespace

PairMemory::Print PairMemory::printOf(const PairSides& sides,
                                      const std::vector<btPersistentManifold*>& manifolds) {
  Print print{};
  std::size_t n = 0;
  for (const btCollisionObjectWrapper* wrap : {sides.wrapA, sides.wrapB}) {
    const btTransform& place = wrap->getWorldTransform();
    for (int row = 0; row < 3; ++row)
      for (int i = 0; i < 3; ++i) print[n++] = place.getBasis()[row][i];
    for (int i = 0; i < 3; ++i) print[n++] = place.getOrigin()[i];
  }
  for (const Motion* motion : {&sides.motionA, &sides.motionB})
    for (const Vec3* v : {&motion->linear, &motion->angular})
      for (int i = 0; i < 3; ++i) print[n++] = static_cast<btScalar>((*v)[i]);
  for (const btPersistentManifold* manifold : manifolds)
    for (int i = 0; i < manifold->getNumContacts(); ++i)
      print[n] += manifold->getContactPoint(i).m_appliedImpulse;
  return print;
}

KelvinVoigt PairMemory::row(const Law& law, const PairSides& sides, const ContactResult& contact,
                            const std::vector<btPersistentManifold*>& manifolds, double step) {
  const PairPoints points = gather(sides, contact);
  if (step_ == 0)
    state_ = lawAdvance(law, {}, points.depth, step);
  else if (printOf(sides, manifolds) != print_)
    state_ = lawAdvance(law, state_, points.depth, step_);
  step_ = step;
  const LawTangent line = lawTangent(law, state_, points.closing, step);
  if (!(points.whole > 0)) return {};
  // Of what does not touch yet only the sum, grip, counts.
  const double k = points.depth > 0 ? line.force / points.depth : line.grip / step;
  return {k / points.whole, (line.grip - step * k) / points.whole};
}

void PairMemory::remember(const PairSides& sides,
                          const std::vector<btPersistentManifold*>& manifolds) {
  print_ = printOf(sides, manifolds);
}

}  // namespace cloudcontact
