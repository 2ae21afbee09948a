// Reads Bullet's mesh interface, part by part.
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>
#include <cloudcontact/bullet/striding_mesh.h>

#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

#include "bullet/convert.h"

namespace cloudcontact {

namespace {

template <typename Number>
Number numberAt(const unsigned char* bytes, std::ptrdiff_t index) {
  Number number;
  std::memcpy(&number, bytes + index * static_cast<std::ptrdiff_t>(sizeof number), sizeof number);
  return number;
}

// One part, while the interface keeps it locked.
class StridingPart {
 public:
  StridingPart(const btStridingMeshInterface& mesh, int part) : mesh_(mesh), part_(part) {
    mesh_.getLockedReadOnlyVertexIndexBase(&vertices_, vertexCount_, vertexType_, vertexStride_,
                                           &indices_, indexStride_, triangleCount_, indexType_,
                                           part);
  }
  ~StridingPart() { mesh_.unLockReadOnlyVertexBase(part_); }
  StridingPart(const StridingPart&) = delete;
  StridingPart& operator=(const StridingPart&) = delete;

  Mesh read() const {
    if ((!vertices_ && vertexCount_ > 0) || (!indices_ && triangleCount_ > 0))
      refuse("has no data");
    Mesh mesh;
    for (int i = 0; i < vertexCount_; ++i) mesh.vertices.push_back(vertex(i));
    for (int t = 0; t < triangleCount_; ++t) {
      const unsigned char* const at = indices_ + std::ptrdiff_t{t} * indexStride_;
      mesh.triangles.emplace_back(index(at, 0), index(at, 1), index(at, 2));
    }
    return mesh;
  }

 private:
  Eigen::Vector3d vertex(int i) const {
    const unsigned char* const at = vertices_ + std::ptrdiff_t{i} * vertexStride_;
    if (vertexType_ == PHY_FLOAT)
      return {numberAt<float>(at, 0), numberAt<float>(at, 1), numberAt<float>(at, 2)};
    if (vertexType_ == PHY_DOUBLE)
      return {numberAt<double>(at, 0), numberAt<double>(at, 1), numberAt<double>(at, 2)};
    refuse("has vertices that are neither float nor double");
  }
  int index(const unsigned char* at, int corner) const {
    unsigned found = 0;
    if (indexType_ == PHY_INTEGER)
      found = numberAt<unsigned>(at, corner);
    else if (indexType_ == PHY_SHORT)
      found = numberAt<unsigned short>(at, corner);
    else if (indexType_ == PHY_UCHAR)
      found = at[corner];
    else
      refuse("has indices that are neither int, short nor char");
    if (found >= static_cast<unsigned>(vertexCount_))
      refuse("names vertex " + std::to_string(found) + ", but has " + std::to_string(vertexCount_));
    return static_cast<int>(found);
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw std::invalid_argument("btStridingMeshInterface: part " + std::to_string(part_) + " " +
                                why + "; fill its btIndexedMesh");
  }

  const btStridingMeshInterface& mesh_;
  int part_;
  const unsigned char *vertices_ = nullptr, *indices_ = nullptr;
  int vertexCount_ = 0, vertexStride_ = 0, indexStride_ = 0, triangleCount_ = 0;
  PHY_ScalarType vertexType_ = PHY_FLOAT, indexType_ = PHY_INTEGER;
};

}  // namespace

Mesh meshOf(const btStridingMeshInterface& triangles) {
  std::vector<NamedMesh> parts;
  for (int part = 0; part < triangles.getNumSubParts(); ++part)
    parts.push_back({"", StridingPart(triangles, part).read()});
  Mesh mesh = merged(parts);
  validate(mesh);
  return mesh.scaled(toVec3(triangles.getScaling()));
}

}  // namespace cloudcontact
