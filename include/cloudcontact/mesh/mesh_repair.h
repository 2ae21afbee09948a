// Inspects meshes and repairs faults that make inside and outside ambiguous.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <cstddef>

namespace cloudcontact {

// Properties of a mesh, counted after its equal vertices are welded.
struct MeshReport {
  std::size_t openEdges = 0;            // edges of a single triangle
  std::size_t overusedEdges = 0;        // edges of three or more triangles
  std::size_t degenerateTriangles = 0;  // triangles that are a line or a point
  double volume = 0;                    // signed, by the divergence theorem [m^3]
  double area = 0;                      // [m^2]
  bool closed() const { return openEdges == 0 && overusedEdges == 0; }
};

// Throws std::invalid_argument as validate(Mesh) does.
MeshReport inspect(const Mesh& mesh);

// The mesh, repaired: vertices within `tolerance` [m] are welded, degenerate and doubled triangles
// are dropped, neighboring triangles agree in direction (the larger area decides), and the whole
// faces outward. A component that faces inward because it bounds a cavity keeps its direction.
// `sheet`, if given, is set to what isSheet() would find. Throws as validate(Mesh) does.
Mesh mended(const Mesh& mesh, double tolerance = 0, bool* sheet = nullptr);

// A closed shell from a surface without an inside (a sheet, a terrain): its faces, copies of them
// `thickness` [m] behind along the vertex normals, and walls along the open edges. Throws
// std::invalid_argument where the thickness is not positive and finite, and as validate(Mesh) does.
Mesh shell(const Mesh& mesh, double thickness);

// True where so much of a surface is open that it bounds no volume: a sheet rather than a body with
// holes. Throws as validate(Mesh) does.
bool isSheet(const Mesh& mesh);

}  // namespace cloudcontact
