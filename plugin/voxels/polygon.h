// Convex polygons, cut at whole numbers of one coordinate (kernels/digitize/column_cut.h).
#pragma once

#include <Eigen/Geometry>

#include "kernels/digitize/column_cut.h"

namespace cloudcontact {

inline void addCorner(CcPolygon& polygon, const Eigen::Vector3d& x) {
  ccAddCorner(&polygon, x.data());
}

// Calls visit(cell, piece) for the pieces of `polygon` between whole numbers of x[Axis].
template <int Axis, typename Visit>
void slice(const CcPolygon& polygon, Visit&& visit) {
  const CcCells cells = ccCells(&polygon, Axis);
  if (cells.first == cells.last) return visit(cells.first, polygon);
  CcPolygon buffers[2], piece;
  const CcPolygon* rest = &polygon;
  for (int cell = cells.first; cell < cells.last; ++cell) {
    CcPolygon& above = buffers[cell & 1];
    ccSplit(rest, Axis, cell + 1, &piece, &above);
    if (piece.corners > 2) visit(cell, piece);
    rest = &above;
  }
  if (rest->corners > 2) visit(cells.last, *rest);
}

// As slice<2>(), but visits only the sums of the pieces.
template <typename Visit>
void forEachPiece(const CcPolygon& polygon, Visit&& visit) {
  const CcCells cells = ccCells(&polygon, 2);
  CcPolygon buffers[2];
  CcFan below;
  const CcPolygon* rest = &polygon;
  for (int cell = cells.first; cell < cells.last; ++cell) {
    CcPolygon& above = buffers[cell & 1];
    ccCutCell(rest, cell, &below, &above);
    if (below.corners > 2) visit(cell, ccPieceOfFan(&below));
    rest = &above;
  }
  if (rest->corners > 2) visit(cells.last, ccPieceOf(rest, cells.last));
}

}  // namespace cloudcontact
