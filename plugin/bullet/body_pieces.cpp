// Pieces of a body that is cut.
#include "bullet/body_pieces.h"

#include <cloudcontact/voxels/pieces.h>

#include <algorithm>
#include <stdexcept>

#include "base/parallel.h"

namespace cloudcontact {

namespace {

// Edge searches in a renewal after a cut of some voxels. They take the time that the cut leaves: a
// search costs as much as 30 voxels.
int searchesOfCut(std::int64_t voxels) {
  return static_cast<int>(std::max(std::int64_t{0}, 6 - voxels / 30));
}

// Building the field of a crumb is faster than renewing the whole body's [voxels].
constexpr std::int64_t kCrumb = 64;
// What a crumb's field costs, finding one piece, and each brick in finding several [us].
constexpr double kCrumbCost = 1000, kStartCost = 200, kBrickCost = 2;

// Null if the piece has no surface.
std::shared_ptr<const SurfaceField> fieldOf(const BodyMatter& body, const BodyMatter& piece,
                                            const PieceSettings& settings,
                                            const std::function<void(double)>& spend) {
  const std::int64_t voxels = coverageOf(piece.sums) / 255;
  FieldSettings how =
      fieldSettings(settings.threads, searchesOfCut(coverageOf(body.sums) / 255 - voxels));
  how.spend = spend;
  try {
    if (voxels > kCrumb) return renewed(body.field, piece.cloud, how);
    if (spend) spend(kCrumbCost);
    return SurfaceField::build(piece.cloud, how);
  } catch (const std::invalid_argument&) {
    return nullptr;
  }
}

}  // namespace

std::int64_t coverageOf(const std::vector<MatterSums>& sums) {
  std::int64_t all = 0;
  for (const MatterSums& s : sums) all += s.mass;
  return all;
}

std::vector<MatterSums> sumOf(const std::vector<MatterSums>& a, const std::vector<MatterSums>& b,
                              bool less) {
  std::vector<MatterSums> sum = a;
  for (std::size_t i = 0; i < sum.size(); ++i) less ? sum[i] -= b[i] : sum[i] += b[i];
  return sum;
}

double bodyMass(const BodyMatter& matter, const std::vector<double>& densities) {
  return massPropertiesOf(matter.sums, matter.cloud, densities).mass;
}

FieldSettings fieldSettings(int threads, std::optional<int> edgeSearches) {
  FieldSettings how;
  how.threads = threads;
  how.renewable = true;
  how.edgeSearches = edgeSearches;
  return how;
}

// Where there is one piece, only what the cut changed is summed up. Several are worked on side by
// side, unless the work is spread over time.
std::vector<BodyMatter> piecesOf(const BodyMatter& body, const Cloud& after,
                                 const PieceSettings& settings,
                                 const std::function<void(double)>& spend) {
  const Cloud& before = body.field->cloud();
  std::vector<Cloud> clouds = body.whole ? pieces(after, before) : pieces(after);
  std::vector<BodyMatter> all(clouds.size());
  if (spend) spend(kStartCost + (all.size() > 1 ? kBrickCost * after.bricks().prod() : 0));
  parallelFor(clouds.size(), spend ? 1 : settings.threads, [&](std::size_t k, int) {
    BodyMatter& piece = all[k];
    piece.cloud = std::move(clouds[k]);
    piece.sums =
        all.size() == 1 ? matterSums(piece.cloud, before, body.sums) : matterSums(piece.cloud);
    piece.whole = true;
    if (bodyMass(piece, settings.densities) >= settings.leastPiece)
      piece.field = fieldOf(body, piece, settings, spend);
  });
  std::erase_if(all, [](const BodyMatter& piece) { return !piece.field; });
  return all;
}

PieceWork::PieceWork(const BodyMatter& body, BodyMatter left, const PieceSettings& settings)
    : matter(std::move(left)),
      pieces(std::make_shared<std::vector<BodyMatter>>()),
      task([found = pieces, body, after = matter.cloud, settings](const PacedTask::Spend& spend) {
        *found = piecesOf(body, after, settings, spend);
      }) {}

BodyMatter cutMatter(const BodyMatter& body, std::span<const VoxelCut> cuts) {
  BodyMatter left = body;
  left.cloud = cutCloud(body.cloud, cuts);
  left.sums = matterSums(left.cloud, body.cloud, body.sums);
  return left;
}

}  // namespace cloudcontact
