// What a world's clouds are taken for (CloudShape::setFidelity). Which pairs met as shapes:
// CloudContact::pairs().
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
// Of every cloud in the world.
std::vector<ShapeReport> shapeReport(const btCollisionWorld& world);

}  // namespace cloudcontact
