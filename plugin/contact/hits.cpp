// Samples of one body looked up in the other: bricks of samples first, by their bounding sphere
// against the other's brick distance, then each sample in one 8-byte fetch.
#include "hits.h"

#include "sample.h"

#include <cmath>

namespace cloudcontact {

namespace {

using M3 = Eigen::Matrix3f;
using V3 = Eigen::Vector3f;

// Half of a sample's width: over it the depth varies by the sine between the surfaces.
constexpr float kHalfWidth = 0.5f;
// A level with this many hits is fine enough: on the M16 thread at 0.25 mm 1,600 of 24,000 hits
// give the force within 3 % and its torque within 2 %, at 0.4 mm 800 turn it by 16 %.
constexpr std::size_t kEnoughHits = 1000;
constexpr float kBeyondBand = 5.5f;  // depth given to a sample below the band's last layer [voxels]

// A rigid map in float, x -> turn x + shift.
struct Map {
  M3 turn;
  V3 shift;
  V3 operator()(const V3& x) const { return turn * x + shift; }
};

Map mapOf(const Pose& pose, double scaleIn, double scaleOut) {
  return {(pose.orientation.toRotationMatrix() * (scaleIn / scaleOut)).cast<float>(),
          (pose.position / scaleOut).cast<float>()};
}

Pose gridPose(const Cloud& cloud) {
  return {Eigen::Quaterniond::Identity(), cloud.origin()};
}

const FieldData& dataOf(const ContactBody& body) {
  return static_cast<const FieldData&>(*body.field);
}

// Everything that one direction of the query needs.
struct Direction {
  const FieldData& body;
  const SampleLevel& samples;
  Side side;
  float voxel;        // of the samples' body [m]
  Map toFrame;        // samples' grid -> frame body, metres
  M3 frameFromOther;  // turns the other body's normals into the frame
};

void addHit(const Direction& dir, const SurfaceSample& s, float depth, const V3& other, bool deep,
            std::vector<Hit>& hits) {
  const V3 own = (dir.toFrame.turn * Eigen::Map<const V3>(s.normal)) / dir.voxel;
  const V3 n = deep ? V3(-own) : V3(dir.frameFromOther * other);
  const float facing = -own.dot(n);
  const float sine = std::sqrt(std::max(0.0f, 1.0f - facing * facing));
  const CcWet wet = ccWet(depth, kHalfWidth * s.width * dir.voxel * sine);
  if (wet.depth1 <= 0.0f) return;
  const V3 at = dir.toFrame(Eigen::Map<const V3>(s.position));
  // Along its own normal, so that its moment stays what it was.
  hits.push_back({at - 0.5f * wet.depth1 / wet.share * own, own, n, s.area * dir.voxel * dir.voxel,
                  wet.share, wet.depth1, wet.depth2, wet.depth3, facing,
                  static_cast<std::int8_t>(dir.side), static_cast<std::int8_t>(deep)});
}

// The least depth [samples' voxels] at which a sample may still be wet.
float reachOf(const SurfaceSample& s) {
  return -kHalfWidth * s.width;
}

void searchField(const Direction& dir, const FieldData& other, const Map& toOther,
                 std::vector<Hit>& hits) {
  const BrickGrid<CcVoxel>& grid = other.band().grid;
  const CcVoxel* planes = other.band().planes.data();
  const float otherVoxel = static_cast<float>(other.cloud().voxelSize());
  const float ratio = dir.voxel / otherVoxel;
  const Eigen::Vector3i size = grid.bricks() * kBrickEdge;
  for (const SampleBrick& brick : dir.samples.bricks) {
    const V3 c = toOther(V3(brick.center[0], brick.center[1], brick.center[2]));
    const float reach = brick.radius * ratio + 1.0f;
    const V3 inside = c.cwiseMax(V3::Zero()).cwiseMin(size.cast<float>() - V3::Constant(0.5f));
    const float away = (c - inside).norm();
    if (away > reach) continue;
    const Eigen::Vector3i v = inside.cast<int>();
    const std::size_t index = grid.tableIndex(v.x(), v.y(), v.z());
    const int bricks = other.brickDistance()[index];
    // At a Chebyshev distance of n bricks lie at least n - 1 whole bricks between.
    const bool solid = other.cloud().voxels().table[index] == kSolidBrick;
    if (!solid && static_cast<float>((bricks - 1) * kBrickEdge) - away > reach) continue;
    for (std::uint32_t k = brick.first; k < brick.first + brick.count; ++k) {
      const SurfaceSample& s = dir.samples.samples[k];
      const V3 x = toOther(Eigen::Map<const V3>(s.position));
      if (!(x.minCoeff() >= 0.0f) || !((size.cast<float>() - x).minCoeff() > 0.0f)) continue;
      const Eigen::Vector3i at = x.cast<int>();
      const CcVoxel record = grid.at(at.x(), at.y(), at.z());
      if (ccPlaneCount(record) == 0) {
        if (other.cloud().coverage(at.x(), at.y(), at.z()) == 0) continue;
        const int deeper = std::max(
            0,
            static_cast<int>(other.brickDistance()[grid.tableIndex(at.x(), at.y(), at.z())]) - 1);
        addHit(dir, s, (kBeyondBand + static_cast<float>(deeper * kBrickEdge)) * otherVoxel,
               V3::Zero(), true, hits);
        continue;
      }
      const V3 r = x - at.cast<float>() - V3::Constant(0.5f);
      const CcDepth d = ccVoxelDepth(record, planes, r.data());
      if (d.depth * otherVoxel <= reachOf(s) * dir.voxel) continue;
      addHit(dir, s, d.depth * otherVoxel, V3(d.normal[0], d.normal[1], d.normal[2]), false, hits);
    }
  }
}

void searchShape(const Direction& dir, const AnalyticShape& shape, const Pose& toShape,
                 std::vector<Hit>& hits) {
  const double voxel = dir.body.cloud().voxelSize();
  for (const SampleBrick& brick : dir.samples.bricks) {
    const Vec3 c = toShape.toWorld(voxel * Vec3(brick.center[0], brick.center[1], brick.center[2]));
    if (shapeAt(shape, c).depth < -(static_cast<double>(brick.radius) + 1.0) * voxel) continue;
    for (std::uint32_t k = brick.first; k < brick.first + brick.count; ++k) {
      const SurfaceSample& s = dir.samples.samples[k];
      const ShapePoint p = shapeAt(
          shape, toShape.toWorld(voxel * Vec3(s.position[0], s.position[1], s.position[2])));
      if (p.depth <= static_cast<double>(reachOf(s)) * voxel) continue;
      addHit(dir, s, static_cast<float>(p.depth), p.normal.cast<float>(), false, hits);
    }
  }
}

void search(const ContactBody& own, const ContactBody& other, Side side, int level,
            const PairFrame& frame, std::vector<Hit>& hits) {
  if (!own.field) return;
  const FieldData& samples = dataOf(own);
  const double voxel = samples.cloud().voxelSize();
  const Pose grid = own.pose * gridPose(samples.cloud());
  const Pose toFrame = frame.pose.inverse() * grid;
  const Direction dir{samples,
                      samples.level(level),
                      side,
                      static_cast<float>(voxel),
                      mapOf(toFrame, voxel, 1.0),
                      (frame.pose.orientation.conjugate() * other.pose.orientation)
                          .toRotationMatrix()
                          .cast<float>()};
  if (other.shape) return searchShape(dir, *other.shape, other.pose.inverse() * grid, hits);
  const Cloud& target = dataOf(other).cloud();
  const Pose toOther = (other.pose * gridPose(target)).inverse() * grid;
  searchField(dir, dataOf(other), mapOf(toOther, voxel, target.voxelSize()), hits);
}

}  // namespace

PairFrame frameOf(const ContactBody& a, const ContactBody& b) {
  PairFrame frame;
  if (a.field && b.field) {
    const std::size_t na = a.field->sampleCount(), nb = b.field->sampleCount();
    frame.voxel = std::max(a.field->cloud().voxelSize(), b.field->cloud().voxelSize());
    if (na != nb) {
      frame.body = na < nb ? kA : kB;
    } else {
      const Vec3 seenFromA = a.pose.toLocal(b.pose.position),
                 seenFromB = b.pose.toLocal(a.pose.position);
      for (int i = 0; i < 3; ++i) {
        if (seenFromA[i] == seenFromB[i]) continue;
        frame.body = seenFromA[i] > seenFromB[i] ? kA : kB;
        break;
      }
    }
  } else {
    frame.body = a.field ? kA : kB;
    frame.voxel = (a.field ? a : b).field->cloud().voxelSize();
  }
  frame.pose = (frame.body == kA ? a : b).pose;
  return frame;
}

int gatherHits(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
               std::vector<Hit>& hits) {
  for (int level = kLevels - 1; level >= 0; --level) {
    hits.clear();
    search(a, b, kA, level, frame, hits);
    search(b, a, kB, level, frame, hits);
    if (hits.size() >= kEnoughHits || level == 0) return level;
  }
  return 0;
}

}  // namespace cloudcontact
