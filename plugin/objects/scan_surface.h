// ScanSurface: the surface through the points of a scan, a small quadric around each, and the
// height of any position above it.
#pragma once

#include <cloudcontact/base/pose.h>

#include <vector>

#include "objects/point_tree.h"
#include "objects/scan_flood.h"

namespace cloudcontact {

class ScanSurface {
 public:
  // `normals` may be empty; they are then estimated. `distance`: between neighboring points [m].
  // `smoothing`: radius of one piece [m].
  ScanSurface(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, double distance,
              double smoothing, int threads);

  // Makes normals point out of the inside that the flood found. Points whose sides the flood cannot
  // tell follow their neighbors. Where it can tell the sides of at most half of the points, it
  // found no body, and no normal changes.
  struct Sides {
    std::size_t known = 0;   // points with inside on one side and outside on the other
    std::size_t turned = 0;  // normals that were reversed
  };
  Sides orient(const ScanFlood& flood);

  // Fits the quadric of each point to the neighbors with similar normals. Call after orient().
  void fit();

  struct Height {
    double above;   // height over the surface [m]
    Vec3 normal;    // outward, unit length
    double beside;  // distance from the nearest point along the surface [m]
  };
  Height heightOf(const Vec3& place) const;
  double distanceTo(const Vec3& place) const;  // distance to the nearest point [m]

 private:
  // The surface around a point: w = q(u, v) in its frame, u and v in units of the smoothing radius.
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
