// TriangleSurface: signed distance to triangles. The sign comes from the pseudo-normal of the
// nearest face, edge or corner, a corner's weighted by angles (Baerentzen, Aanaes, Signed distance
// computation using the angle weighted pseudonormal, IEEE TVCG 2005); by faces alone it is wrong
// for a tenth of the points around an acute corner.
//
// Triangles that share two corners are joined, whatever their winding. What is joined by edges is a
// sheet, and a point beyond the border of a sheet is outside. Which side of a sheet is outside is
// chosen by points (turnTo()), or follows the winding of its first triangle.
#pragma once

#include <cloudcontact/law/solid_point.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace cloudcontact {

class TriangleSurface {
 public:
  struct Point : SolidPoint {
    bool border;  // the nearest place is on a border
  };

  // Nine coordinates a triangle [m]. Flat triangles and second copies are dropped. `within`: bounds
  // of what is asked; beyond them the surface may go on.
  void build(std::span<const double> corners, const Eigen::AlignedBox3d& within);
  // Takes over what another found out about faces that both have, before anyone asks.
  void keepRooms(const TriangleSurface& before);
  // Turns each sheet so that the points nearest to it are outside, in the mean of their distances.
  // Returns whether a sheet was turned.
  bool turnTo(std::span<const Vec3> points);
  // How far the points may move without turning a sheet [m], if the surface does not change.
  double turnsAfter() const { return turnsAfter_; }

  bool empty() const { return faces_.empty(); }
  std::size_t size() const { return faces_.size(); }
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  // Whether normals jump anywhere: at a sharp edge or at a border.
  bool hasJumps() const { return hasJumps_; }
  bool hasBorders() const { return hasBorders_; }

  // The surface's nearest point; not of an empty surface. Threads may ask at once.
  Point at(const Vec3& x) const;
  // How much farther than `reach` a place is outside [m]; 0 where it is not, or is inside.
  double beyond(const Vec3& x, double reach) const;
  // Edges that stick out of the matter, and borders.
  void visitEdges(const std::function<void(const Vec3&, const Vec3&)>& visit) const;
  // Edges of one face, within the bounds of what is asked.
  void visitBorders(const std::function<void(const Vec3&, const Vec3&)>& visit) const;
  // The place of such a border that is nearest to a point; infinitely far where there is none.
  Vec3 borderNearest(const Vec3& x) const;

 private:
  static constexpr std::uint32_t kNone = ~0u;
  static constexpr double kOnSurface = 1e-9;  // [m] the way to the foot has no direction
  static constexpr int kDeepest = 64;         // levels of the tree
  struct Face {
    std::array<std::uint32_t, 3> corner{}, edge{};  // edge k: from corner k to the next
    Vec3 normal = Vec3::Zero();
    std::uint32_t sheet = kNone;
  };
  struct Edge {
    std::uint32_t from = 0, to = 0;
    std::uint32_t face[2] = {kNone, kNone};
    int faces = 0;
    Vec3 normal = Vec3::Zero();  // of both faces, not of unit length
    bool joins() const { return faces == 2; }
  };
  // A face as the tree holds it.
  struct Triangle {
    Vec3 a, b, c, normal, middle;
    std::uint32_t face;
    Eigen::AlignedBox3d box() const {
      Eigen::AlignedBox3d box(a);
      return box.extend(b).extend(c);
    }
    double longest() const {
      return std::sqrt(
          std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    }
    Eigen::AlignedBox3d around() const;
  };
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first = 0, count = 0;  // triangles; count 0: children `first` and `first` + 1
    double squareTo(const Vec3& x) const;
  };
  // The prism over a face: its inner sides, and where in it no other face can be nearer than the
  // face (face_prisms.cpp). Places are relative to `origin_`. Rows of four are read at once: of
  // three sides and of the face.
  struct alignas(64) Prism {
    using Row = Eigen::Array4f;
    Row x, y, z, from;  // unit vectors inward, last the normal; the place minus `from` is ahead
    // How far from the sides, as shares of the height over the face, or under it: the tangent of
    // half the angle by which what lies beyond a side rises; last a length [m] in addition.
    Row side[2];
    // The same for the sum of the two sides that meet in a corner; last the most height [m].
    Row corner[2];

    Row ahead(const Eigen::Vector3f& place) const {
      return x * place.x() + y * place.y() + z * place.z() - from;
    }
    bool holds(const Eigen::Vector3f& place) const;
  };
  // What is being measured is known to the thread that does so.
  enum class Known : std::uint8_t { Not, Soon, Yes };
  struct Nearest {
    Vec3 foot = Vec3::Zero();
    double square = 0;
    std::uint32_t face = kNone;
    int feature = 0;  // 0: face; 1 to 3: corner; 4 to 6: edge
  };

  // The corner or the edge that is nearest.
  struct Rim {
    const Vec3& normal;
    bool border;
  };

  // Where a corner or an edge is in its table, or would be.
  std::size_t slotOf(const Vec3& x) const;
  std::size_t slotOf(std::uint32_t low, std::uint32_t high) const;
  // The face with the same corners, wound either way, or none.
  std::uint32_t faceLike(const Triangle& triangle) const;
  std::uint32_t cornerAt(const Vec3& x);
  std::uint32_t edgeOf(std::uint32_t from, std::uint32_t to);
  void addFace(const Vec3& a, const Vec3& b, const Vec3& c);
  void joinSheets();
  void splitCorners();
  void addNormals();
  void buildTree();
  struct Room;
  void addPrisms();
  void addCells();
  void spreadCells();
  std::size_t cellOf(const Eigen::Vector3f& place) const;
  // Other triangles whose boxes meet the face's surroundings.
  void visitAround(std::uint32_t face, const std::function<void(const Triangle&)>& visit) const;
  double roundingOf(const Triangle& face) const;
  bool agreesWith(const TriangleSurface& other) const;
  void measure(std::uint32_t face, Prism& prism) const;
  bool isMeasured(std::uint32_t face) const;
  bool holdsNow(std::uint32_t face, const Eigen::Vector3f& place) const;
  bool sureFace(const Eigen::Vector3f& place, std::uint32_t& face) const;
  void divide(std::uint32_t node);
  static Nearest onTriangle(const Triangle& triangle, const Vec3& x);
  Nearest nearest(const Vec3& x, std::uint32_t hint) const;
  Rim rimOf(const Nearest& nearest) const;  // not of a face
  Point signedBy(const Nearest& nearest, const Vec3& x) const;
  double voteOf(const Nearest& nearest, const Vec3& x) const;

  std::vector<Vec3> corners_, cornerNormals_;
  std::vector<std::uint8_t> onBorder_;  // of corners
  std::vector<Face> faces_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> borders_;  // edges of one face, where the surface is asked
  std::vector<double> sides_, votes_;   // of sheets; side 1: as wound, -1: turned
  std::vector<std::uint32_t> table_, edgeTable_, place_, stack_, owner_,
      copy_;  // place_: of faces in triangles_
  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
  Vec3 origin_ = Vec3::Zero();         // of places in prisms and cells
  mutable std::vector<Prism> prisms_;  // of faces; they are measured when first asked for
  mutable std::vector<Known> known_;   // of prisms; shared by threads, so atomic, as are cells
  // The face that was last found from a cell of the bounds: where the next search begins.
  mutable std::vector<std::uint32_t> lastFrom_;
  Eigen::Array3f cellsPerMeter_ = Eigen::Array3f::Zero();
  Eigen::Array3i cells_ = Eigen::Array3i::Ones();
  Eigen::AlignedBox3d bounds_, within_;
  bool hasJumps_ = false, hasBorders_ = false;
  double turnsAfter_ = 0;
};

}  // namespace cloudcontact
