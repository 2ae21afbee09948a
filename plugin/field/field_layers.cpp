// Spreads pieces over the layers, over all or where a change reaches.
#include "field/field_layers.h"

#include "base/parallel.h"
#include "voxels/brick_grid.h"

#include <algorithm>
#include <utility>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;
using V3i = Eigen::Vector3i;

constexpr float kOnePiece = 0.9f;  // cosine: of pieces within 26 deg only the nearest is kept

const BandCell kNoCell;

V3i neighbor(const V3i& v, int k) {
  return v + V3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
}

bool sameKeys(const BandCell& a, const BandCell& b) {
  return a.layer == b.layer && a.count == b.count &&
         std::equal(a.piece, a.piece + a.count, b.piece);
}

}  // namespace

NearPiece nearPiece(const FieldDraft& draft, PieceKey key, const V3& center) {
  const V3i brick = key.brick();
  const VoxelState from = draft.brickAt(brick)->state(key.cell());
  const SurfacePiece& p = from.pieces[key.number()];
  const Eigen::Map<const V3> n(p.surface.n), t1(p.surface.t1), t2(p.surface.t2), c(p.centroid);
  const V3 r = center - (key.voxel().cast<float>() + V3::Constant(0.5f));
  // Clamped, because the quadric holds over its own block only.
  const float u = std::clamp(t1.dot(r), -1.5f, 1.5f), v = std::clamp(t2.dot(r), -1.5f, 1.5f);
  const float ku = p.surface.k11 * u + p.surface.k12 * v,
              kv = p.surface.k12 * u + p.surface.k22 * v;
  const V3 m = n + ku * t1 + kv * t2;
  const float phi = n.dot(r) + 0.5f * (ku * u + kv * v) - p.surface.s, length = m.norm();
  return {key,        from.rule(), (center - c).squaredNorm(), -phi / length,
          m / length, c,           dropOf(p.surface)};
}

FieldLayers::FieldLayers(const FieldDraft& draft, LayerBricks before)
    : draft_(draft),
      size_(draft.cloud.bricks()),
      bricks_(std::move(before)),
      own_(draft.bricks().size(), nullptr) {
  bricks_.resize(own_.size());
}

const BandCell& FieldLayers::at(const V3i& v) const {
  if (!insideGrid(v, kBrickEdge * size_)) return kNoCell;
  const BandCells* const brick = bricks_[brickIndex(v, size_)].get();
  return brick ? (*brick)[static_cast<std::size_t>(cellIndex(v))] : kNoCell;
}

FieldLayers::Around FieldLayers::around(const V3i& v) const {
  Around result;
  const int cell = cellIndex(v);
  const auto inner = [](int at) { return (at & 7) > 0 && (at & 7) < 7; };
  if (inner(v.x()) && inner(v.y()) && inner(v.z())) {
    const BandCells* const brick = bricks_[brickIndex(v, size_)].get();
    for (int k = 0; k < 27; ++k) {
      const int step = k % 3 - 1 + 8 * (k / 3 % 3 - 1) + 64 * (k / 9 - 1);
      result.cell[k] = brick ? brick->data() + cell + step : &kNoCell;
    }
    return result;
  }
  // Of each axis and place along it: the part of the brick's index, or -1, and of the cell's.
  int brick[3][3], part[3][3];
  for (int axis = 0, stride = 1; axis < 3; stride *= size_[axis++])
    for (int i = 0; i < 3; ++i) {
      const int at = v[axis] + i - 1;
      brick[axis][i] = at < 0 || at >= kBrickEdge * size_[axis] ? -1 : (at >> 3) * stride;
      part[axis][i] = (at & 7) << 3 * axis;
    }
  for (int k = 0; k < 27; ++k) {
    const int x = k % 3, y = k / 3 % 3, z = k / 9;
    const bool inside = brick[0][x] >= 0 && brick[1][y] >= 0 && brick[2][z] >= 0;
    const BandCells* const cells =
        inside ? bricks_[static_cast<std::size_t>(brick[0][x] + brick[1][y] + brick[2][z])].get()
               : nullptr;
    result.cell[k] = cells ? cells->data() + (part[0][x] | part[1][y] | part[2][z]) : &kNoCell;
  }
  return result;
}

BandCell& FieldLayers::write(const V3i& v) {
  const std::size_t t = brickIndex(v, size_);
  if (!own_[t]) {
    auto brick =
        bricks_[t] ? std::make_shared<BandCells>(*bricks_[t]) : std::make_shared<BandCells>();
    own_[t] = brick.get();
    bricks_[t] = std::move(brick);
  }
  return (*own_[t])[static_cast<std::size_t>(cellIndex(v))];
}

// Planes that only bound other pieces are no surface and are not passed on.
void FieldLayers::seed(const V3i& v, const VoxelState& state) {
  BandCell& cell = write(v);
  cell = BandCell{};
  cell.layer = 0;
  for (int k = 0; k < state.count() && cell.count < kKept; ++k)
    if (state.pieces[k].area > 0) cell.piece[cell.count++] = PieceKey(state.step->pass, v, k);
}

int FieldLayers::reachOf(const V3i& v) const {
  return draft_.cloud.coverage(v.x(), v.y(), v.z()) > 127 ? kInsideLayers : kOutsideLayers;
}

FieldLayers::Voxels FieldLayers::grow(const Voxels& from, int layer) {
  Voxels next;
  const V3i n = kBrickEdge * size_;
  for (const V3i& v : from) {
    const Around near = around(v);
    for (int k = 0; k < 27; ++k) {
      // A brick that was written to since is another one.
      const V3i w = neighbor(v, k);
      if (near.cell[k]->layer >= 0 || !insideGrid(w, n) || at(w).layer >= 0) continue;
      if (layer > reachOf(w)) continue;
      write(w).layer = static_cast<std::int8_t>(layer);
      next.push_back(w);
    }
  }
  return next;
}

// Keeps the nearest pieces that the neighbors of earlier layers know, one per direction: the
// nearest one, the nearest of those that face elsewhere, and so on.
BandCell FieldLayers::inherited(const Around& around, const V3i& v) const {
  BandCell cell;
  cell.layer = around.cell[13]->layer;
  PieceKey keys[27 * kKept];
  int count = 0;
  for (const BandCell* const from : around.cell) {
    if (from->layer < 0 || from->layer >= cell.layer) continue;
    for (int i = 0; i < from->count; ++i)
      if (std::find(keys, keys + count, from->piece[i]) == keys + count)
        keys[count++] = from->piece[i];
  }
  const V3 center = v.cast<float>() + V3::Constant(0.5f);
  NearPiece near[27 * kKept];
  for (int i = 0; i < count; ++i) near[i] = nearPiece(draft_, keys[i], center);
  while (count > 0 && cell.count < kKept) {
    const NearPiece nearest =
        *std::min_element(near, near + count, [](const NearPiece& a, const NearPiece& b) {
          return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.key < b.key;
        });
    cell.piece[cell.count++] = nearest.key;
    const NearPiece* const left = std::remove_if(near, near + count, [&](const NearPiece& one) {
      return one.key == nearest.key || nearest.normal.dot(one.normal) > kOnePiece;
    });
    count = static_cast<int>(left - near);
  }
  return cell;
}

// The voxels' bricks must be written to already, as grow() does. Neighbors of the same layer read
// each other's layer meanwhile, so only the pieces are written.
void FieldLayers::inherit(const Voxels& voxels) {
  parallelFor((voxels.size() + 511) / 512, draft_.threads, [&](std::size_t chunk, int) {
    const std::size_t end = std::min(voxels.size(), (chunk + 1) * 512);
    for (std::size_t i = chunk * 512; i < end; ++i) {
      const V3i& v = voxels[i];
      BandCell& cell = (*own_[brickIndex(v, size_)])[static_cast<std::size_t>(cellIndex(v))];
      const BandCell found = inherited(around(v), v);
      std::copy_n(found.piece, found.count, cell.piece);
      cell.count = found.count;
    }
  });
}

void FieldLayers::spread() {
  Voxels frontier;
  for (const std::int32_t t : draft_.surfaceBricks()) {
    const SurfaceBrick& b = *draft_.brick(static_cast<std::size_t>(t));
    const V3i low = draft_.cornerOf(static_cast<std::size_t>(t));
    for (const SurfaceVoxel& v : b.voxels) {
      frontier.push_back(low + cellOffset(v.cell));
      seed(frontier.back(), b.stateAt(v.last));
    }
  }
  for (int layer = 1; layer <= kLayers; ++layer) {
    frontier = grow(frontier, layer);
    inherit(frontier);
  }
}

// First the layers where voxels joined or left the surface, then the pieces along the way of the
// changes.
class FieldLayers::Renewal {
 public:
  Renewal(FieldLayers& layers, const VoxelSet& pieces, const VoxelSet& turned)
      : layers_(layers),
        pieces_(pieces),
        turned_(turned),
        earlier_(layers.draft_.cloud.bricks(), kSame),
        seen_(layers.draft_.cloud.bricks(), 0),
        reached_(layers.draft_.cloud.bricks()) {}

  VoxelSet run() {
    renewLayers();
    int seeds = 0;
    pieces_.forEach([&](std::int32_t, int, int x, int y, int z) {
      const V3i v(x, y, z);
      if (++seeds % kVisits == 0) layers_.draft_.spend(kVisits * kTouchCost);
      if (const VoxelState state = surface(v)) {
        layers_.seed(v, state);
        touch(v);
      }
    });
    turned_.forEach([&](std::int32_t, int, int x, int y, int z) { touch({x, y, z}); });
    for (std::vector<V3i>& voxels : waiting_)
      for (std::size_t i = 0; i < voxels.size(); ++i) {  // grows as it is visited
        if (i % kVisits == 0) layers_.draft_.spend(kVisits * kVisitCost);
        visit(voxels[i]);
      }
    return std::move(reached_);
  }

 private:
  // What a brick costs in finding the scope and its layers and in storing them; a touch and the
  // visit of a voxel [us].
  static constexpr double kStoreCost = 3;
  static constexpr double kScopeCost = 1.3, kLayersCost = 7, kVisitCost = 0.5, kTouchCost = 0.2;
  static constexpr int kVisits = 128;  // at once

  static constexpr std::int8_t kSame = 127;  // the layer did not change

  VoxelState surface(const V3i& v) const { return layers_.draft_.at(v.x(), v.y(), v.z()); }

  // Calls visit(voxel, layer, surface) for the voxels of a set, in bricks that have or had surface
  // or layers; `surface` is true for voxels that the surface crosses now.
  template <typename Visit>
  void forEachNear(const VoxelSet& set, Visit&& visit) const {
    for (const std::int32_t t : set.bricks()) {
      const std::size_t b = static_cast<std::size_t>(t);
      const SurfaceBrick* const surface = layers_.draft_.brick(b);
      const BandCells* cells = layers_.bricks_[b].get();
      if (!surface && !cells) continue;
      const VoxelSet::Rows& rows = *set.find(t);
      const V3i low = layers_.draft_.cornerOf(b);
      for (int k = 0; k < kBrickVoxels; ++k) {
        if (!VoxelSet::holds(rows, k)) continue;
        cells = layers_.bricks_[b].get();
        const std::size_t at = static_cast<std::size_t>(k);
        visit(V3i(low + cellOffset(k)), cells ? (*cells)[at].layer : -1,
              surface && surface->place[at] >= 0);
      }
    }
  }

  // Voxels whose layer may change.
  VoxelSet layerScope() const {
    VoxelSet joined = turned_;
    forEachNear(pieces_, [&](const V3i& v, int layer, bool surface) {
      if ((layer == 0) != surface) joined.add(v.x(), v.y(), v.z());
    });
    return joined.dilated(kLayers);
  }

  using LayerSets = std::array<VoxelSet, kLayers + 1>;

  // Adds the voxels of a set to those of their present layers.
  void addLayersOf(const VoxelSet& set, LayerSets& layers) const {
    set.forEach([&](std::int32_t t, int cell, int x, int y, int z) {
      const BandCells* const cells = layers_.bricks_[static_cast<std::size_t>(t)].get();
      const int layer = cells ? (*cells)[static_cast<std::size_t>(cell)].layer : -1;
      if (layer >= 0) layers[static_cast<std::size_t>(layer)].add(x, y, z);
    });
  }

  // Of a set, the voxels that are more than half full. Only there do layers go on inside.
  VoxelSet fullOf(const VoxelSet& set) const {
    VoxelSet full(set);
    full.keepIf([&](std::int32_t, int, int x, int y, int z) {
      return layers_.draft_.cloud.coverage(x, y, z) > 127;
    });
    return full;
  }

  // The layers within `scope`. They start at the surface in it and at the layers that border it.
  // Each layer is the free voxels next to the layer before.
  LayerSets layersIn(const VoxelSet& scope) const {
    LayerSets layers = emptyLayers(std::make_index_sequence<kLayers + 1>());
    VoxelSet taken = scope.dilated(1);
    taken.remove(scope);
    addLayersOf(taken, layers);
    forEachNear(scope, [&](const V3i& v, int, bool surface) {
      if (surface) layers[0].add(v.x(), v.y(), v.z());
    });
    VoxelSet free = scope;
    free.remove(layers[0]);
    for (int layer = 1; layer <= kLayers; ++layer) {
      if (layer == kOutsideLayers + 1) free = fullOf(free);
      VoxelSet next = layers[static_cast<std::size_t>(layer - 1)].dilated(1);
      next.keep(free);
      free.remove(next);
      layers[static_cast<std::size_t>(layer)].add(next);
    }
    return layers;
  }

  template <std::size_t... k>
  LayerSets emptyLayers(std::index_sequence<k...>) const {
    return {((void)k, VoxelSet(layers_.draft_.cloud.bricks()))...};
  }

  void renewLayers() {
    const VoxelSet scope = layerScope();
    layers_.draft_.spend(kScopeCost * static_cast<double>(scope.bricks().size()));
    const LayerSets layers = layersIn(scope);
    layers_.draft_.spend(kLayersCost * static_cast<double>(scope.bricks().size()));
    Voxels changed;
    for (const std::int32_t t : scope.bricks()) {
      std::array<std::int8_t, kBrickVoxels> now;
      now.fill(-1);
      for (int layer = 0; layer <= kLayers; ++layer)
        if (const VoxelSet::Rows* const rows = layers[static_cast<std::size_t>(layer)].find(t))
          for (int k = 0; k < kBrickVoxels; ++k)
            if (VoxelSet::holds(*rows, k)) now[static_cast<std::size_t>(k)] = std::int8_t(layer);
      storeLayers(t, *scope.find(t), now, changed);
      layers_.draft_.spend(kStoreCost);
    }
    for (std::size_t i = 0; i < changed.size(); ++i) {
      if (i % kVisits == 0) layers_.draft_.spend(kVisits * kTouchCost);
      touch(changed[i]);
      if (layers_.at(changed[i]).layer > 0) wait(changed[i]);
    }
  }

  // Stores a brick's layers where they differ within `scope`; appends these voxels.
  void storeLayers(std::int32_t t, const VoxelSet::Rows& scope,
                   const std::array<std::int8_t, kBrickVoxels>& now, Voxels& changed) {
    const V3i low = layers_.draft_.cornerOf(static_cast<std::size_t>(t));
    for (std::size_t k = 0; k < kBrickVoxels; ++k) {
      if (!VoxelSet::holds(scope, static_cast<int>(k))) continue;
      const BandCells* const cells = layers_.bricks_[static_cast<std::size_t>(t)].get();
      const std::int8_t before = cells ? (*cells)[k].layer : std::int8_t(-1);
      if (before == now[k]) continue;
      const V3i v = low + cellOffset(static_cast<int>(k));
      earlier_.make(v.x(), v.y(), v.z()) = before;
      BandCell& cell = layers_.write(v);
      if (now[k] < 0) cell = BandCell{};
      cell.layer = now[k];
      changed.push_back(v);
    }
  }

  // Marks a voxel whose pieces or layer changed: those that inherit from it must look again.
  void touch(const V3i& v) {
    std::uint8_t& seen = seen_.make(v.x(), v.y(), v.z());
    if (seen & kTouched) return;
    seen |= kTouched;
    reached_.add(v.x(), v.y(), v.z());
    const int now = layers_.at(v).layer, before = earlier_.at(v.x(), v.y(), v.z());
    const int first = before == kSame || before < 0 ? now
                      : now < 0                     ? before
                                                    : std::min(now, before);
    if (first < 0 || first == kLayers) return;
    const Around near = layers_.around(v);
    for (int k = 0; k < 27; ++k)
      if (near.cell[k]->layer > first) wait(neighbor(v, k));
  }

  void wait(const V3i& v) {
    std::uint8_t& seen = seen_.make(v.x(), v.y(), v.z());
    if (seen & kWaits) return;
    seen |= kWaits;
    waiting_[static_cast<std::size_t>(layers_.at(v).layer)].push_back(v);
  }

  void visit(const V3i& v) {
    const Around near = layers_.around(v);
    const BandCell before = *near.cell[13], now = layers_.inherited(near, v);
    bool changed = !sameKeys(before, now);
    if (changed) layers_.write(v) = now;
    for (int i = 0; i < now.count && !changed; ++i) {
      const V3i from = now.piece[i].voxel();
      changed = pieces_.has(from.x(), from.y(), from.z());
    }
    if (changed) touch(v);
  }

  static constexpr std::uint8_t kTouched = 1, kWaits = 2;

  FieldLayers& layers_;
  const VoxelSet &pieces_, &turned_;
  BrickGrid<std::int8_t> earlier_;  // layer before, where it changed
  BrickGrid<std::uint8_t> seen_;
  VoxelSet reached_;
  std::array<std::vector<V3i>, kLayers + 1> waiting_;  // by layer
};

VoxelSet FieldLayers::renew(const VoxelSet& pieces, const VoxelSet& turned) {
  return Renewal(*this, pieces, turned).run();
}

}  // namespace cloudcontact
