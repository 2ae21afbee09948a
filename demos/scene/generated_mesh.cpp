// All meshes but the chain link are built of rings: loops of points around the z axis at equal
// angles, so that neighboring rings join without gaps.
#include "scene/generated_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

namespace cloudcontact::program {
namespace {

constexpr double kPi = std::numbers::pi;

class RingBuilder {
 public:
  explicit RingBuilder(int segments) : segments_(segments) {
    if (segments < 8 || segments % 8 != 0)
      throw std::invalid_argument("generated mesh: segments must be a multiple of 8, at least 8");
  }

  int segments() const { return segments_; }
  double angle(int i) const { return 2 * kPi * i / segments_; }

  int point(double radius, double angle, double z) {
    mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    return static_cast<int>(mesh.vertices.size()) - 1;
  }
  // Adds a ring at height z and returns the index of its first point.
  int ring(double z, const std::function<double(double)>& radius) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (int i = 0; i < segments_; ++i) point(radius(angle(i)), angle(i), z);
    return first;
  }
  void triangle(int a, int b, int c) {
    if (a != b && b != c && c != a) mesh.triangles.emplace_back(a, b, c);
  }
  // Joins two rings. In the half plane of radius (right) and z (up), the outside lies to the right
  // of the line from `a` to `b`: an outer wall goes up, a top face goes inward.
  void join(int a, int b) {
    for (int i = 0; i < segments_; ++i) {
      const int j = (i + 1) % segments_;
      triangle(a + i, a + j, b + j);
      triangle(a + i, b + j, b + i);
    }
  }
  // Closes a ring with a flat fan that faces up or down.
  void cap(int ring, double z, bool up) {
    const int center = point(0, 0, z);
    for (int i = 0; i < segments_; ++i) {
      const int j = (i + 1) % segments_;
      if (up)
        triangle(center, ring + i, ring + j);
      else
        triangle(center, ring + j, ring + i);
    }
  }

  Mesh mesh;

 private:
  int segments_;
};

std::function<double(double)> circle(double radius) {
  return [radius](double) { return radius; };
}

// Radius of a regular polygon, `width` across flats, by angle: a corner at angle 0 for six sides, a
// flat for four.
std::function<double(double)> polygon(int sides, double width) {
  return [=](double angle) {
    const double sector = 2 * kPi / sides;
    const double shifted = sides == 4 ? angle + sector / 2 : angle;
    const double inside = shifted - sector * std::floor(shifted / sector) - sector / 2;
    return width / 2 / std::cos(inside);
  };
}

void check(const Thread& t, double length) {
  if (!(t.pitch > 0) || !(t.majorDiameter > 2 * t.pitch) || t.starts < 1 || !(length > t.pitch))
    throw std::invalid_argument(
        "thread: needs a positive pitch, a major diameter over twice the pitch, at least one start "
        "and a length over one pitch");
  if (t.segments % 24 != 0 || t.profileSteps < 16 || t.profileSteps % 16 != 0)
    throw std::invalid_argument("thread: segments must be a multiple of 24 and profileSteps of 16");
  if (!(t.flankAngle > 0.1) || !(t.flankAngle < 2.5))
    throw std::invalid_argument("thread: flankAngle must lie between 0.1 and 2.5 rad");
}

double minorRadius(const Thread& t) {
  return t.majorDiameter / 2 - 5.0 / 16 * t.pitch / std::tan(t.flankAngle / 2);
}

// The threaded wall between rings at z = 0 and z = length, with the radius limit(radius, z). Grid
// lines follow the helix, so the profile's corners are edges of the mesh; at each end they merge
// into the end's ring. For a right-hand thread.
struct Wall {
  int bottom, top;
};
Wall threadWall(RingBuilder& builder, const Thread& t, double length,
                const std::function<double(double, double)>& limit) {
  const int n = builder.segments();
  const double step = t.pitch / t.profileSteps;
  const int perLead = t.starts * t.profileSteps;
  const int rows = perLead + static_cast<int>(std::ceil(length / step)) + 1;
  const double snap = 1e-3 * step;  // points this close to an end are moved onto it
  const auto radius = [&](double z, double axial) { return limit(threadRadius(t, axial), z); };
  const Wall wall{builder.ring(0, circle(radius(0, 0))),
                  builder.ring(length, circle(radius(length, 0)))};
  std::vector<int> grid(static_cast<std::size_t>(n) * rows);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < rows; ++k) {
      const double axial = (k - perLead) * step;
      const double z = axial + t.lead() * i / n;
      int& id = grid[static_cast<std::size_t>(i) * rows + k];
      if (z <= snap)
        id = wall.bottom + i;
      else if (z >= length - snap)
        id = wall.top + i;
      else
        id = builder.point(radius(z, axial), builder.angle(i), z);
    }
  // After the last column comes the first one, a lead higher.
  const auto at = [&](int i, int k) {
    if (i == n) return k + perLead < rows ? grid[k + perLead] : wall.top;
    return grid[static_cast<std::size_t>(i) * rows + k];
  };
  for (int i = 0; i < n; ++i)
    for (int k = 0; k + 1 < rows; ++k) {
      builder.triangle(at(i, k), at(i + 1, k), at(i + 1, k + 1));
      builder.triangle(at(i, k), at(i + 1, k + 1), at(i, k + 1));
    }
  return wall;
}

Mesh turned(Mesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// Mirrors a right-hand thread for a left-hand one.
Mesh handed(Mesh mesh, bool left) {
  if (!left) return mesh;
  for (auto& v : mesh.vertices) v.y() = -v.y();
  return turned(std::move(mesh));
}

}  // namespace

double threadRadius(const Thread& t, double axial) {
  const double fromCrest = std::abs(axial - t.pitch * std::round(axial / t.pitch));
  const double slope = 1 / std::tan(t.flankAngle / 2);
  const double radius = t.majorDiameter / 2 - slope * std::max(0.0, fromCrest - t.pitch / 16);
  return std::max(radius, minorRadius(t));
}

Mesh boltMesh(const Thread& t, double length, double headWidth, double headHeight) {
  check(t, length);
  RingBuilder builder(t.segments);
  // A 45 degree chamfer from just under the minor radius avoids knife edges.
  const double end = minorRadius(t) - t.clearance - 0.05 * t.pitch;
  const Wall wall = threadWall(builder, t, length, [&](double radius, double z) {
    return std::min(radius - t.clearance, end + std::min(z, length - z));
  });
  builder.cap(wall.top, length, true);
  if (headWidth <= 0) {
    builder.cap(wall.bottom, 0, false);
  } else {
    const int low = builder.ring(-headHeight, polygon(6, headWidth));
    const int high = builder.ring(0, polygon(6, headWidth));
    builder.cap(low, -headHeight, false);
    builder.join(low, high);
    builder.join(high, wall.bottom);
  }
  return handed(std::move(builder.mesh), t.leftHanded);
}

Mesh nutMesh(const Thread& t, double height, double width) {
  check(t, height);
  RingBuilder builder(t.segments);
  const double end = t.majorDiameter / 2 + t.clearance + 0.05 * t.pitch;
  if (width / 2 <= end + 0.05 * t.pitch)
    throw std::invalid_argument("nutMesh: width must exceed the thread's major diameter");
  // Built inside out, because the wall of the hole faces the axis.
  const Wall wall = threadWall(builder, t, height, [&](double radius, double z) {
    return std::max(radius + t.clearance, end - std::min(z, height - z));
  });
  const int low = builder.ring(0, polygon(6, width));
  const int high = builder.ring(height, polygon(6, width));
  builder.join(wall.top, high);
  builder.join(high, low);
  builder.join(low, wall.bottom);
  return handed(turned(std::move(builder.mesh)), t.leftHanded);
}

Mesh chainLinkMesh(const ChainLink& link) {
  if (!(link.wire > 0) || !(link.bend > link.wire) || link.straight < 0 || link.around < 8 ||
      link.along < 4)
    throw std::invalid_argument(
        "chainLinkMesh: needs 0 < wire < bend, straight >= 0, around >= 8 and along >= 4");
  Mesh mesh;
  const int stations = 2 * (link.along + 1);
  for (int s = 0; s < stations; ++s) {
    const bool upper = s <= link.along;
    const int k = upper ? s : s - link.along - 1;
    const double angle = kPi * k / link.along + (upper ? 0 : kPi);
    const Eigen::Vector3d outward(std::cos(angle), std::sin(angle), 0);
    const Eigen::Vector3d center(0, (upper ? 1 : -1) * link.straight / 2, 0);
    for (int j = 0; j < link.around; ++j) {
      const double turn = 2 * kPi * j / link.around;
      mesh.vertices.push_back(center + (link.bend + link.wire * std::cos(turn)) * outward +
                              link.wire * std::sin(turn) * Eigen::Vector3d::UnitZ());
    }
  }
  for (int s = 0; s < stations; ++s)
    for (int j = 0; j < link.around; ++j) {
      const int a = s * link.around, b = (s + 1) % stations * link.around;
      const int n = (j + 1) % link.around;
      mesh.triangles.emplace_back(a + j, b + j, b + n);
      mesh.triangles.emplace_back(a + j, b + n, a + n);
    }
  return mesh;
}

Mesh pegMesh(double radius, double length, double chamfer, int segments) {
  if (!(chamfer > 0) || !(radius > chamfer) || !(length > 2 * chamfer))
    throw std::invalid_argument("pegMesh: needs 0 < chamfer < radius and a length over 2 chamfers");
  RingBuilder builder(segments);
  const int rings[4] = {builder.ring(0, circle(radius - chamfer)),
                        builder.ring(chamfer, circle(radius)),
                        builder.ring(length - chamfer, circle(radius)),
                        builder.ring(length, circle(radius - chamfer))};
  builder.cap(rings[0], 0, false);
  for (int i = 0; i < 3; ++i) builder.join(rings[i], rings[i + 1]);
  builder.cap(rings[3], length, true);
  return std::move(builder.mesh);
}

Mesh holeMesh(double radius, double width, double height, double chamfer, int segments) {
  if (!(radius > 0) || !(chamfer > 0) || !(width / 2 > radius + chamfer) || !(height > chamfer))
    throw std::invalid_argument(
        "holeMesh: needs a positive radius and chamfer, a width over the hole and a height over "
        "the chamfer");
  RingBuilder builder(segments);
  const int rings[5] = {builder.ring(0, circle(radius)), builder.ring(0, polygon(4, width)),
                        builder.ring(height, polygon(4, width)),
                        builder.ring(height, circle(radius + chamfer)),
                        builder.ring(height - chamfer, circle(radius))};
  for (int i = 0; i < 5; ++i) builder.join(rings[i], rings[(i + 1) % 5]);
  return std::move(builder.mesh);
}

}  // namespace cloudcontact::program
