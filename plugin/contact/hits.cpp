// Both directions of a query, level by level, from few samples to all.
#include "contact/hits.h"

#include "contact/far_apart.h"
#include "contact/sample_search.h"
#include "contact/verlet_list_builder.h"

namespace cloudcontact {

namespace {

using namespace search;

// A finer level's samples lie closer together, and fewer of them do: it is fine enough with this
// share of the hits that the coarsest needs. On cylinders of 16 voxels pressed by 0.3 a fifth puts
// the force off by 3.7 %, a third by less than 3.
constexpr std::size_t kFinerNeeds = 3;
constexpr double kMostMargin = 2;  // [voxels] farther out the band knows no planes
// [voxels] Bodies this far apart have neither hits nor near misses: a sample reaches less than two
// voxels about its middle.
constexpr double kFarApart = 5;
constexpr float kLightly = 0.1f;  // [voxels] depth to which near misses are moved together

void rotation(const Eigen::Quaterniond& turn, double scale, float* rows) {
  const Eigen::Matrix3d m = turn.toRotationMatrix() * scale;
  for (int i = 0; i < 9; ++i) rows[i] = static_cast<float>(m(i / 3, i % 3));
}

CcMap mapOf(const Pose& pose, double scaleIn, double scaleOut) {
  CcMap map;
  rotation(pose.orientation, scaleIn / scaleOut, map.turn);
  for (int i = 0; i < 3; ++i) map.shift[i] = static_cast<float>(pose.position[i] / scaleOut);
  return map;
}

Pose gridPose(const Cloud& cloud) {
  return {Eigen::Quaterniond::Identity(), cloud.origin()};
}

const FieldData& dataOf(const ContactBody& body) {
  return body.field->data();
}

}  // namespace

CcWay wayOf(const ContactBody& own, const ContactBody& other, const PairFrame& frame) {
  const Cloud& cloud = own.field->cloud();
  const double voxel = cloud.voxelSize();
  const Pose grid = own.pose * gridPose(cloud);
  const Pose toFrame = frame.pose.inverse() * grid;
  const Eigen::Quaterniond fromOther = frame.pose.orientation.conjugate() * other.pose.orientation;
  CcWay way{};
  way.toFrame = mapOf(toFrame, voxel, 1.0);
  rotation(toFrame.orientation, 1, way.frameFromOwn);
  rotation(fromOther, 1, way.frameFromOther);
  rotation(other.pose.orientation.conjugate() * own.pose.orientation, 1, way.turnToOther);
  if (other.shape) return way;
  const Cloud& target = other.field->cloud();
  way.toOther = mapOf((other.pose * gridPose(target)).inverse() * grid, voxel, target.voxelSize());
  return way;
}

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

std::size_t neededOf(int level, std::size_t enough) {
  return level == kLevels - 1 ? enough : enough / kFinerNeeds;
}

float marginOf(double margin, const PairFrame& frame) {
  return static_cast<float>(std::min(margin, kMostMargin * frame.voxel));
}

struct HitSearch::Query {
  const ContactBody* bodies[2];
  CcWay ways[2];  // of the samples that a body has
  std::size_t enough;

  bool ofFields() const { return bodies[0]->field && bodies[1]->field; }
};

HitSearch::HitSearch() : maker_(std::make_unique<ShortlistMaker>()) {}
HitSearch::~HitSearch() = default;

void HitSearch::lookUp(const Query& query, Side side, int level, HitColumns& hits,
                       const Shortlists* lists) {
  const ContactBody &own = *query.bodies[side], &other = *query.bodies[1 - side];
  if (!own.field) return;
  const FieldData& samples = dataOf(own);
  const float voxel = static_cast<float>(samples.cloud().voxelSize());
  std::span<const std::uint32_t> listed;
  if (lists) listed = lists->of(side).of(level);
  const Direction dir{query.ways[side],
                      samples,
                      samples.samples(),
                      level,
                      side,
                      voxel,
                      misses_,
                      lists ? &listed : nullptr,
                      neededOf(level, query.enough)};
  if (!other.shape) return searchField(dir, dataOf(other), cells_[side], hits, shares_);
  const Pose grid = own.pose * gridPose(samples.cloud());
  searchShape(dir, *other.shape, other.pose.inverse() * grid, cells_[side], hits, shares_);
}

// Level after level; negative where the lists end before there are enough hits.
int HitSearch::look(const Query& query, HitColumns& hits, const Shortlists* lists) {
  for (Candidates& c : cells_) c.all = true;
  misses_.list.clear();
  misses_.nearest = -1e30f;
  for (int level = kLevels - 1;; --level) {
    if (lists && level < lists->level()) return -1;
    hits.clear();
    lookUp(query, kA, level, hits, lists);
    lookUp(query, kB, level, hits, lists);
    if (level == 0 || hits.size() >= neededOf(level, query.enough)) return level;
  }
}

int HitSearch::run(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                   double margin, std::size_t enough, HitColumns& hits, const TaskRunner* shareOut,
                   Shortlists* lists) {
  shares_.run = shareOut;
  for (Candidates& c : cells_) c.asked = 0;
  misses_.list.clear();
  misses_.margin = marginOf(margin, frame);
  misses_.within = kLightly * static_cast<float>(frame.voxel);
  gap_ = 0;
  hits.clear();
  // Bullet's boxes are wider than its bodies by 7 cm (gContactBreakingThreshold and a margin of its
  // tree's), whatever their size: in a box of small
  // parts most of its pairs are such.
  if (farApart(a, b, kFarApart * frame.voxel)) return 0;
  Query query{{&a, &b}, {}, enough};
  if (a.field) query.ways[kA] = wayOf(a, b, frame);
  if (b.field) query.ways[kB] = wayOf(b, a, frame);
  if (!query.ofFields()) lists = nullptr;
  const float reach = misses_.margin;
  const bool listed = lists && lists->begin(dataOf(a), dataOf(b), query.ways, reach);
  int level = listed ? look(query, hits, lists) : -1;
  if (level < 0) {
    if (listed) lists->drop();
    level = look(query, hits, nullptr);
    if (lists) lists->giveRoom(cells_[kA].asked, cells_[kB].asked);
    if (lists && lists->wanted()) lists->make(dataOf(a), dataOf(b), level, reach, *maker_);
  }
  if (hits.empty() && !misses_.list.empty()) touchLightly(hits);
  return level;
}

void HitSearch::Candidates::fit(const Candidates& other) {
  now.reserve(other.now.capacity());
  next.reserve(other.next.capacity());
  // These two change places.
  now.reserve(other.next.capacity());
  next.reserve(other.now.capacity());
  bricks.reserve(other.bricks.capacity());
  deep.reserve(other.deep.capacity());
  parts.fit(other.parts);
  places.reserve(other.places.capacity());
}

void HitSearch::fit(const HitSearch& other) {
  for (int side = 0; side < 2; ++side) cells_[side].fit(other.cells_[side]);
  misses_.list.reserve(other.misses_.list.capacity());
  shares_.runs.reserve(other.shares_.runs.capacity());
  if (shares_.all.size() < other.shares_.all.size()) shares_.all.resize(other.shares_.all.size());
  for (std::size_t i = 0; i < other.shares_.all.size(); ++i) {
    shares_.all[i].cells.fit(other.shares_.all[i].cells);
    shares_.all[i].misses.list.reserve(other.shares_.all[i].misses.list.capacity());
    shares_.all[i].hits.fit(other.shares_.all[i].hits);
  }
}

// Near misses as hits, `within` deep at the nearest.
void HitSearch::touchLightly(HitColumns& hits) {
  const float shift = misses_.within - misses_.nearest;
  gap_ = static_cast<double>(shift);
  for (Hit hit : misses_.list) {
    hit.depth += shift;
    if (hit.depth <= 0) continue;
    hit.depth1 = hit.depth;
    hit.depth2 = hit.depth * hit.depth;
    hit.depth3 = hit.depth2 * hit.depth;
    hits.push_back(hit);
  }
}

}  // namespace cloudcontact
