// Files: a cube in millimeters comes back from an OBJ file in meters.
#include <cmath>
#include <cstdio>
#include <fstream>

#include <outside/cube.h>

int main() {
  using namespace cloudcontact;
  const Mesh mesh = cube(40);
  std::ofstream file("cube.obj");
  for (const Eigen::Vector3d& v : mesh.vertices)
    file << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  for (const auto& t : mesh.triangles)
    file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  file.close();
  DigitizeSettings settings;
  settings.voxelSize = 0.002;
  const double volume = digitize(loadMesh("cube.obj", 0.001), settings).massProperties().volume;
  std::printf("%.3f cm3\n", 1e6 * volume);
  return std::abs(volume - 64e-6) < 1e-9 ? 0 : 1;
}
