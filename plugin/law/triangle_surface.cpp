// Corners and edges are joined by open hashing; a tree of boxes finds the nearest triangle.
#include "law/triangle_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "law/triangle_point.h"

namespace cloudcontact {

namespace {

constexpr std::size_t kLeaf = 2;     // triangles
constexpr double kFlat = 1e-12;      // of a triangle's longest edge squared: it has no area
constexpr double kOneFace = 0.9;     // cosine: normals jump where they differ by more
constexpr double kStraight = 0.985;  // cosine of 10 deg: an edge that is hardly one
constexpr double kLess = 1 - 1e-12;  // of a bound, for rounding
constexpr std::size_t kFewPoints = 8;

std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 31)) * 0x9E3779B97F4A7C15ull;
  return x ^ (x >> 29);
}

// An empty table of at least twice as many places, a power of two.
void clearTable(std::vector<std::uint32_t>& table, std::size_t entries) {
  table.assign(std::bit_ceil(2 * entries + 2), ~0u);
}

bool crosses(const Vec3& a, const Vec3& b, const Eigen::AlignedBox3d& box) {
  return box.intersects(Eigen::AlignedBox3d(Vec3(a.cwiseMin(b)), Vec3(a.cwiseMax(b))));
}

}  // namespace

std::size_t TriangleSurface::slotOf(const Vec3& x) const {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) key = mixed(key ^ std::bit_cast<std::uint64_t>(x[i]));
  std::size_t at = key & (table_.size() - 1);
  while (table_[at] != kNone && corners_[table_[at]] != x) at = (at + 1) & (table_.size() - 1);
  return at;
}

std::size_t TriangleSurface::slotOf(std::uint32_t low, std::uint32_t high) const {
  std::size_t at = mixed(std::uint64_t{low} << 32 | high) & (edgeTable_.size() - 1);
  for (; edgeTable_[at] != kNone; at = (at + 1) & (edgeTable_.size() - 1)) {
    const Edge& edge = edges_[edgeTable_[at]];
    if (edge.from == low && edge.to == high) break;
  }
  return at;
}

std::uint32_t TriangleSurface::cornerAt(const Vec3& x) {
  const Vec3 plus = x + Vec3::Zero();  // -0 becomes 0
  std::uint32_t& corner = table_[slotOf(plus)];
  if (corner != kNone) return corner;
  corner = static_cast<std::uint32_t>(corners_.size());
  corners_.push_back(plus);
  return corner;
}

std::uint32_t TriangleSurface::edgeOf(std::uint32_t from, std::uint32_t to) {
  const auto [low, high] = std::minmax(from, to);
  std::uint32_t& found = edgeTable_[slotOf(low, high)];
  if (found != kNone) return found;
  found = static_cast<std::uint32_t>(edges_.size());
  Edge& edge = edges_.emplace_back();
  edge.from = low;
  edge.to = high;
  return found;
}

std::uint32_t TriangleSurface::faceLike(const Triangle& triangle) const {
  const std::uint32_t a = table_[slotOf(triangle.a)], b = table_[slotOf(triangle.b)];
  if (a == kNone || b == kNone) return kNone;
  const std::uint32_t found = edgeTable_[slotOf(std::min(a, b), std::max(a, b))];
  if (found == kNone) return kNone;
  for (const std::uint32_t face : edges_[found].face)
    if (face != kNone)
      for (const std::uint32_t corner : faces_[face].corner)
        if (corners_[corner] == triangle.c) return face;
  return kNone;
}

void TriangleSurface::addFace(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 across = (b - a).cross(c - a);
  const double longest =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  if (!(across.norm() > kFlat * longest)) return;  // also where a corner is NaN
  Face face;
  face.corner = {cornerAt(a), cornerAt(b), cornerAt(c)};
  face.normal = across.normalized();
  for (std::size_t k = 0; k < 3; ++k)
    face.edge[k] = edgeOf(face.corner[k], face.corner[(k + 1) % 3]);
  const Edge& first = edges_[face.edge[0]];
  for (int i = 0; i < std::min(first.faces, 2); ++i) {  // a second copy has the same edges
    auto same = faces_[first.face[i]].edge, own = face.edge;
    std::sort(same.begin(), same.end());
    std::sort(own.begin(), own.end());
    if (same == own) return;
  }
  for (const std::uint32_t e : face.edge) {
    Edge& edge = edges_[e];
    if (edge.faces < 2) edge.face[edge.faces] = static_cast<std::uint32_t>(faces_.size());
    ++edge.faces;
  }
  faces_.push_back(face);
}

void TriangleSurface::build(std::span<const double> corners, const Eigen::AlignedBox3d& within) {
  const std::size_t count = corners.size() / 9;
  corners_.clear();
  faces_.clear();
  edges_.clear();
  clearTable(table_, 3 * count);
  clearTable(edgeTable_, 3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const double* const x = corners.data() + 9 * i;
    addFace(Vec3(x[0], x[1], x[2]), Vec3(x[3], x[4], x[5]), Vec3(x[6], x[7], x[8]));
  }
  joinSheets();
  splitCorners();
  addNormals();
  within_ = within;
  bounds_.setEmpty();
  for (const Face& face : faces_)
    for (const std::uint32_t corner : face.corner) bounds_.extend(corners_[corner]);
  if (!bounds_.isEmpty() && bounds_.intersects(within)) bounds_ = bounds_.intersection(within);
  hasJumps_ = hasBorders_ = false;
  borders_.clear();
  for (std::uint32_t i = 0; i < edges_.size(); ++i) {
    const Edge& e = edges_[i];
    if (e.faces == 0 || !crosses(corners_[e.from], corners_[e.to], within)) continue;
    hasBorders_ |= !e.joins();
    if (e.faces == 1) borders_.push_back(i);
    hasJumps_ |= !e.joins() || faces_[e.face[0]].normal.dot(faces_[e.face[1]].normal) < kOneFace;
  }
  buildTree();
  addPrisms();
  addCells();
}

// Spreads over the edges of two faces, and winds each face as the one that it was reached from.
void TriangleSurface::joinSheets() {
  std::uint32_t sheets = 0;
  for (std::uint32_t start = 0; start < faces_.size(); ++start) {
    if (faces_[start].sheet != kNone) continue;
    faces_[start].sheet = sheets++;
    stack_.assign(1, start);
    while (!stack_.empty()) {
      const std::uint32_t own = stack_.back();
      stack_.pop_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const Face& face = faces_[own];
        const Edge& edge = edges_[face.edge[k]];
        if (!edge.joins()) continue;
        const std::uint32_t next = edge.face[edge.face[0] == own];
        Face& other = faces_[next];
        if (other.sheet != kNone) continue;
        other.sheet = face.sheet;
        const auto place = std::find(other.edge.begin(), other.edge.end(), face.edge[k]);
        if (other.corner[static_cast<std::size_t>(place - other.edge.begin())] == face.corner[k]) {
          std::swap(other.corner[1], other.corner[2]);
          std::swap(other.edge[0], other.edge[2]);
          other.normal = -other.normal;
        }
        stack_.push_back(next);
      }
    }
  }
  sides_.assign(sheets, 1);
}

// A corner in which two sheets meet becomes one corner for each.
void TriangleSurface::splitCorners() {
  owner_.assign(corners_.size(), kNone);
  copy_.assign(corners_.size(), kNone);
  for (Face& face : faces_)
    for (std::uint32_t& corner : face.corner) {
      while (owner_[corner] != kNone && owner_[corner] != face.sheet) {
        if (copy_[corner] == kNone) {
          copy_[corner] = static_cast<std::uint32_t>(corners_.size());
          const Vec3 same = corners_[corner];
          corners_.push_back(same);
          owner_.push_back(kNone);
          copy_.push_back(kNone);
        }
        corner = copy_[corner];
      }
      owner_[corner] = face.sheet;
    }
}

void TriangleSurface::addNormals() {
  cornerNormals_.assign(corners_.size(), Vec3::Zero());
  onBorder_.assign(corners_.size(), 0);
  for (const Face& face : faces_)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t at = face.corner[k], to = face.corner[(k + 1) % 3];
      const Vec3 one = (corners_[to] - corners_[at]).normalized();
      const Vec3 other = (corners_[face.corner[(k + 2) % 3]] - corners_[at]).normalized();
      cornerNormals_[at] += std::acos(std::clamp(one.dot(other), -1.0, 1.0)) * face.normal;
      Edge& edge = edges_[face.edge[k]];
      edge.normal += face.normal;
      if (!edge.joins()) onBorder_[at] = onBorder_[to] = 1;
    }
}

void TriangleSurface::buildTree() {
  triangles_.clear();
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    const auto& corner = faces_[f].corner;
    const Vec3 &a = corners_[corner[0]], &b = corners_[corner[1]], &c = corners_[corner[2]];
    triangles_.push_back({a, b, c, faces_[f].normal, a + b + c, f});
  }
  nodes_.clear();
  if (faces_.empty()) return;
  nodes_.push_back({{}, 0, static_cast<std::uint32_t>(triangles_.size())});
  for (std::uint32_t node = 0; node < nodes_.size(); ++node) divide(node);
  place_.resize(faces_.size());
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) place_[triangles_[i].face] = i;
}

// Gives a node its box, and halves it where it holds too many triangles.
void TriangleSurface::divide(std::uint32_t node) {
  const std::uint32_t first = nodes_[node].first, count = nodes_[node].count;
  Eigen::AlignedBox3d box, middles;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const Triangle& t = triangles_[i];
    box.extend(t.a).extend(t.b).extend(t.c);
    middles.extend(t.middle);
  }
  nodes_[node].box = box;
  if (count <= kLeaf) return;
  int axis;
  middles.sizes().maxCoeff(&axis);
  const auto begin = triangles_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count,
                   [axis](const Triangle& t, const Triangle& u) {
                     const double x = t.middle[axis], y = u.middle[axis];
                     return x < y || (x == y && t.face < u.face);
                   });
  nodes_[node] = {box, static_cast<std::uint32_t>(nodes_.size()), 0};
  nodes_.push_back({{}, first, count / 2});
  nodes_.push_back({{}, first + count / 2, count - count / 2});
}

// A little less than the square of the distance to the box, so that no rounding hides a triangle.
double TriangleSurface::Node::squareTo(const Vec3& x) const {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double out = std::max({box.min()[i] - x[i], x[i] - box.max()[i], 0.0});
    sum += out * out;
  }
  return sum * kLess;
}

TriangleSurface::Nearest TriangleSurface::onTriangle(const Triangle& triangle, const Vec3& x) {
  Nearest near;
  near.face = triangle.face;
  near.feature = nearestOnTriangle(triangle.a, triangle.b, triangle.c, x, near.foot);
  near.square = (x - near.foot).squaredNorm();
  return near;
}

// Of triangles that are equally near, the first; so the hint does not show in the result.
TriangleSurface::Nearest TriangleSurface::nearest(const Vec3& x, std::uint32_t hint) const {
  Nearest best = onTriangle(triangles_[place_[hint < faces_.size() ? hint : 0]], x);
  double squares[kDeepest];
  std::uint32_t stack[kDeepest];
  int depth = 1;
  squares[0] = stack[0] = 0;
  while (depth > 0) {
    if (squares[--depth] > best.square) continue;
    const Node& node = nodes_[stack[depth]];
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const double height = triangles_[i].normal.dot(x - triangles_[i].a);
      if (height * height * kLess > best.square) continue;
      const Nearest near = onTriangle(triangles_[i], x);
      if (near.square < best.square || (near.square == best.square && near.face < best.face))
        best = near;
    }
    if (node.count > 0) continue;
    std::uint32_t near = node.first, far = node.first + 1;
    double nearSquare = nodes_[near].squareTo(x), farSquare = nodes_[far].squareTo(x);
    if (farSquare < nearSquare) {
      std::swap(near, far);
      std::swap(nearSquare, farSquare);
    }
    if (farSquare <= best.square) {
      squares[depth] = farSquare;
      stack[depth++] = far;
    }
    squares[depth] = nearSquare;
    stack[depth++] = near;
  }
  return best;
}

TriangleSurface::Rim TriangleSurface::rimOf(const Nearest& near) const {
  const Face& face = faces_[near.face];
  const auto k = static_cast<std::size_t>((near.feature + 2) % 3);
  if (near.feature <= 3) return {cornerNormals_[face.corner[k]], onBorder_[face.corner[k]] != 0};
  return {edges_[face.edge[k]].normal, !edges_[face.edge[k]].joins()};
}

TriangleSurface::Point TriangleSurface::signedBy(const Nearest& near, const Vec3& x) const {
  const Face& face = faces_[near.face];
  const double side = sides_[face.sheet];
  const Vec3 facing = side * face.normal;
  if (near.feature == 0) return {{facing.dot(corners_[face.corner[0]] - x), facing}, false};
  const auto [normal, border] = rimOf(near);
  const Vec3 pseudo = side * normal;
  const Vec3 out = x - near.foot;
  const double distance = out.norm();
  const bool inside = !border && out.dot(pseudo) < 0;
  if (distance < kOnSurface) return {{inside ? distance : -distance, facing}, border};
  return {{inside ? distance : -distance, (inside ? -1 : 1) / distance * out}, border};
}

// The distance [m] of a point in front of the sheet as it is wound, negative behind; less where the
// nearest point is on a border.
double TriangleSurface::voteOf(const Nearest& near, const Vec3& x) const {
  const Face& face = faces_[near.face];
  const Vec3 out = x - near.foot;
  if (near.feature == 0) return out.dot(face.normal);
  const auto [pseudo, border] = rimOf(near);
  return border ? out.dot(pseudo.normalized()) : std::copysign(out.norm(), out.dot(pseudo));
}

bool TriangleSurface::turnTo(std::span<const Vec3> points) {
  if (empty()) return false;
  votes_.assign(sides_.size(), 0);
  std::uint32_t hint = 0;
  bool past = false;
  for (const Vec3& x : points) {
    const Nearest near = nearest(x, hint);
    hint = near.face;
    votes_[faces_[near.face].sheet] += voteOf(near, x);
    past |= near.feature > 0 && rimOf(near).border;
  }
  // No distance to a sheet without borders that does not cross itself changes by more than its
  // point moves. Past a border its sign may.
  turnsAfter_ =
      votes_.size() > 1 || past || hasBorders_
          ? 0
          : std::abs(votes_[0]) / static_cast<double>(std::max<std::size_t>(points.size(), 1));
  // Sheets that are nearest to no point: by some of the points.
  const std::size_t few = std::min(kFewPoints, points.size());
  for (std::uint32_t sheet = 0; sheet < sides_.size(); ++sheet) {
    if (votes_[sheet] != 0) continue;
    for (std::size_t i = 0; i < few; ++i) {
      const Vec3& x = points[i * points.size() / few];
      Nearest best;
      best.square = std::numeric_limits<double>::infinity();
      for (std::uint32_t f = 0; f < faces_.size(); ++f)
        if (faces_[f].sheet == sheet)
          if (const Nearest near = onTriangle(triangles_[place_[f]], x); near.square < best.square)
            best = near;
      votes_[sheet] += voteOf(best, x);
    }
  }
  bool turned = false;
  for (std::size_t sheet = 0; sheet < sides_.size(); ++sheet) {
    const double side = votes_[sheet] < 0 ? -1 : 1;
    turned |= side != sides_[sheet];
    sides_[sheet] = side;
  }
  return turned;
}

void TriangleSurface::visitBorders(
    const std::function<void(const Vec3&, const Vec3&)>& visit) const {
  for (const std::uint32_t border : borders_)
    visit(corners_[edges_[border].from], corners_[edges_[border].to]);
}

Vec3 TriangleSurface::borderNearest(const Vec3& x) const {
  double least = std::numeric_limits<double>::infinity();
  Vec3 best = Vec3::Constant(least);
  for (const std::uint32_t border : borders_) {
    const Vec3& from = corners_[edges_[border].from];
    const Vec3 way = corners_[edges_[border].to] - from;
    const double along = std::clamp((x - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
    const Vec3 place = from + along * way;
    const double square = (place - x).squaredNorm();
    if (square >= least) continue;
    least = square;
    best = place;
  }
  return best;
}

void TriangleSurface::visitEdges(const std::function<void(const Vec3&, const Vec3&)>& visit) const {
  for (const Edge& edge : edges_) {
    if (edge.faces == 0) continue;
    if (edge.joins()) {
      const Face &one = faces_[edge.face[0]], &other = faces_[edge.face[1]];
      if (one.normal.dot(other.normal) > kStraight) continue;
      // The other face falls away behind this one.
      double above = 0;
      for (const std::uint32_t corner : other.corner) {
        const double height = one.normal.dot(corners_[corner] - corners_[edge.from]);
        if (std::abs(height) > std::abs(above)) above = height;
      }
      if (sides_[one.sheet] * above >= 0) continue;
    }
    visit(corners_[edge.from], corners_[edge.to]);
  }
}

}  // namespace cloudcontact
