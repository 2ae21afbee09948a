// The surface that a scan's points lie on: a small quadric about each, and the height of any place
// above it.
#pragma once

#include <cloudcontact/base/pose.h>

#include <vector>

#include "objects/point_tree.h"
#include "objects/scan_flood.h"

namespace cloudcontact {

class ScanSurface {
 public:
  // `normals` may be empty: they are then found. `distance` is that between neighbours, `smoothing`
  // the radius of one piece [m].
  ScanSurface(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, double distance,
              double smoothing, int threads);

  // Turns normals to look out of what the flood has found to be inside. Points that the flood
  // cannot tell of go with their neighbours. Where it tells of less than half of them nothing is
  // turned: it found no body.
  struct Sides {
    std::size_t told = 0;    // points with inside on one side and outside on the other
    std::size_t turned = 0;  // normals
  };
  Sides orient(const ScanFlood& flood);

  // The quadric of each point, from the neighbours that look its way. After the normals are
  // settled.
  void fit();

  struct Height {
    double above;   // [m] of the place over the surface
    Vec3 normal;    // outward unit
    double beside;  // [m] from the nearest point along the surface
  };
  Height heightOf(const Vec3& place) const;
  double distanceTo(const Vec3& place) const;  // of the nearest point [m]

 private:
  // The surface about a point: w = q(u, v) in its frame, u and v in units of the smoothing radius.
  struct Piece {
    Vec3 normal, t1, t2;
    double q[6] = {0, 0, 0, 0, 0, 0};  // 1 u v uu uv vv [m]
  };
  void findNormals();
  int sideOf(std::size_t i, const ScanFlood& flood) const;
  std::size_t orientRest(std::vector<int>& said);
  void fitPiece(std::size_t i);
  Height heightOver(std::size_t i, const Vec3& place) const;

  std::vector<Vec3> points_;
  std::vector<Piece> pieces_;
  PointTree tree_;
  double distance_, smoothing_;
  int threads_;
};

}  // namespace cloudcontact
