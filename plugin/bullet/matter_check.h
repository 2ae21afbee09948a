// Whether Bullet's center of mass and inertia of a body are those of its clouds.
#pragma once

#include <cloudcontact/base/mass_properties.h>

#include <memory>
#include <vector>

class btCollisionObject;

namespace cloudcontact {

class CloudShape;

// Masses of clouds, at 1 kg/m^3 or their tissues' densities. Many bodies share a cloud, and adding
// one of 50,000 surface voxels up takes a millisecond.
class CloudMasses {
 public:
  MassProperties of(const CloudShape& shape);

 private:
  struct Known {
    std::weak_ptr<const void> life;  // Cloud::life()
    std::vector<double> densities;
    MassProperties mass;
  };
  std::vector<Known> known_;
};

// What is wrong, one sentence each; empty for a body that contacts do not move, or that has shapes
// other than clouds, whose density is not known.
//
// A user may know better where the matter is than a cloud: a body with ballast has another center
// and inertia than its voxels make. So a center inside the body's bounds and an inertia that some
// matter in them could have count as stated, unless the inertia is one that follows from the shape,
// which shows that nobody stated it.
std::vector<const char*> wrongMatter(const btCollisionObject& object, CloudMasses& masses);

}  // namespace cloudcontact
