// The core alone: two cubes of 40 mm that overlap by 1 mm push each other apart by k d.
#include <cmath>
#include <cstdio>

#include <outside/cube.h>

int main() {
  using namespace cloudcontact;
  DigitizeSettings settings;
  settings.voxelSize = 0.002;
  const Cloud cloud = digitize(cube(0.04), settings);
  const auto field = SurfaceField::build(cloud);
  ContactBody a, b;
  a.field = b.field = field.get();
  b.pose.position.z() = 0.039;
  ContactSettings contact;
  contact.law = KelvinVoigt{1e5, 0};
  ContactFinder finder;
  const Wrench onB = wrenchOnB(finder.find(a, b, contact), a.motion, b.motion);
  std::printf("CloudContact %s: %.3f cm3, %.1f N\n", CLOUDCONTACT_VERSION,
              1e6 * cloud.massProperties().volume, onB.force.z());
  const bool right =
      std::abs(cloud.massProperties().volume - 64e-6) < 1e-9 && std::abs(onB.force.z() - 100) < 2;
  return right && version() == CLOUDCONTACT_VERSION ? 0 : 1;
}
