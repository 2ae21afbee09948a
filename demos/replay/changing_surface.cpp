// Normals come from the whole surface, so that pieces meet without seams.
#include "replay/changing_surface.h"

#include <algorithm>
#include <numeric>

namespace cloudcontact::program {
namespace {

// `count` triangles from `first` on.
ShadedMesh cutOut(const ShadedMesh& whole, std::size_t first, std::size_t count) {
  ShadedMesh part;
  std::map<std::uint32_t, std::uint32_t> known;
  for (std::size_t k = 3 * first; k < 3 * (first + count); ++k) {
    const std::uint32_t corner = whole.corners[k];
    const auto [found, isNew] =
        known.try_emplace(corner, static_cast<std::uint32_t>(part.positions.size()));
    if (isNew) {
      part.positions.push_back(whole.positions[corner]);
      part.normals.push_back(whole.normals[corner]);
    }
    part.corners.push_back(found->second);
  }
  return part;
}

void append(ShadedMesh& to, const ShadedMesh& more) {
  const auto first = static_cast<std::uint32_t>(to.positions.size());
  to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
  to.normals.insert(to.normals.end(), more.normals.begin(), more.normals.end());
  for (const std::uint32_t corner : more.corners) to.corners.push_back(first + corner);
}

}  // namespace

ChangingSurface::ChangingSurface(const Cloud& matter, double time) : display_(matter) {
  std::vector<int> all(static_cast<std::size_t>(display_.bricks()));
  std::iota(all.begin(), all.end(), 0);
  show(all, time);
}

void ChangingSurface::renew(const Cloud& matter, double time) {
  const std::vector<int> changed = display_.renew(matter);
  if (changed.empty()) return;
  for (const int brick : changed) close(brick, time);
  show(changed, time);
}

void ChangingSurface::end(double time) {
  while (!shown_.empty()) close(shown_.begin()->first, time);
}

std::vector<SurfacePiece> ChangingSurface::finish() {
  end(std::numeric_limits<double>::infinity());
  std::vector<SurfacePiece> pieces;
  for (auto& [times, mesh] : pieces_)
    pieces.push_back({times.first, times.second, std::move(mesh)});
  pieces_.clear();
  return pieces;
}

// `bricks` ascend, as the triangles of the whole mesh do.
void ChangingSurface::show(const std::vector<int>& bricks, double time) {
  const ShadedMesh whole = shaded(welded(display_.mesh()));
  std::size_t first = 0;
  auto next = bricks.begin();
  for (int number = 0; number < display_.bricks() && next != bricks.end(); ++number) {
    const DisplayBrick* brick = display_.brick(number);
    const std::size_t count = brick ? brick->triangles.size() : 0;
    if (number == *next) {
      if (count > 0) shown_[number] = {time, cutOut(whole, first, count)};
      ++next;
    }
    first += count;
  }
}

void ChangingSurface::close(int brick, double time) {
  const auto found = shown_.find(brick);
  if (found == shown_.end()) return;
  if (time > found->second.from) append(pieces_[{found->second.from, time}], found->second.mesh);
  shown_.erase(found);
}

}  // namespace cloudcontact::program
