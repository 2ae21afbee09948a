// What a world's clouds are taken for, and which pairs met as shapes (CloudShape::setFidelity).
#pragma once

#include <cloudcontact/bullet/cloud_shape.h>

#include <vector>

class btCollisionObject;
class btCollisionWorld;

namespace cloudcontact {

// A CloudShape of an object, or of a child of its compound. Its recognized() tells kind, sizes and
// error; null: it meets all others as a cloud.
struct ShapeReport {
  const btCollisionObject* object = nullptr;
  const CloudShape* shape = nullptr;
};
std::vector<ShapeReport> shapeReport(const btCollisionWorld& world);

// How a pair with a cloud was answered in the last step or query. Pairs of a compound's children
// are missing: Bullet hides them. CloudContactStatistics::shapes counts them, too.
enum class PairPath { Cloud, Shapes };
struct PairReport {
  const btCollisionObject* a = nullptr;
  const btCollisionObject* b = nullptr;
  PairPath path = PairPath::Cloud;
};
std::vector<PairReport> pairReport(const btCollisionWorld& world);

}  // namespace cloudcontact
