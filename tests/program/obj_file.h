// Meshes as the text of an OBJ file, for tests that give the program a file.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

namespace program_test {

// One object per mesh, its lengths divided by `unit` [m].
inline std::string objText(const std::vector<cloudcontact::NamedMesh>& parts, double unit = 1) {
  std::ostringstream text;
  text << std::setprecision(17);
  int first = 1;  // OBJ counts vertices from 1, over all objects
  for (const cloudcontact::NamedMesh& part : parts) {
    text << "o " << part.name << '\n';
    for (const Eigen::Vector3d& v : part.mesh.vertices)
      text << "v " << v.x() / unit << ' ' << v.y() / unit << ' ' << v.z() / unit << '\n';
    for (const Eigen::Vector3i& t : part.mesh.triangles)
      text << "f " << first + t[0] << ' ' << first + t[1] << ' ' << first + t[2] << '\n';
    first += static_cast<int>(part.mesh.vertices.size());
  }
  return text.str();
}

}  // namespace program_test
