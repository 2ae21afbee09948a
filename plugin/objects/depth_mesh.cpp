// From a depth image to a mesh and a body: see depth_image.h.
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/objects/depth_image.h>
#include <cloudcontact/voxels/digitize.h>

#include <cmath>
#include <stdexcept>

#include "mesh/closing.h"
#include "objects/depth_pixels.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3i;

// Builds triangles over pixels. A pixel gets a vertex on first use.
class PixelMesh {
 public:
  PixelMesh(const DepthImage& image, double jump)
      : image_(image), pixels_(image), jump_(jump), number_(image.points.size(), -1) {}

  // The square of four pixels from (x, y) right and down, divided along its shorter diagonal.
  void square(int x, int y) {
    const Corner a{x, y}, b{x + 1, y}, c{x, y + 1}, d{x + 1, y + 1};
    const bool ad = joined(a, d), bc = joined(b, c);
    const bool alongAd = ad && (!bc || (at(a) - at(d)).norm() <= (at(b) - at(c)).norm());
    if (alongAd) {
      triangle(a, b, d);
      triangle(a, d, c);
    } else if (bc) {
      triangle(a, b, c);
      triangle(b, d, c);
    }
  }
  Mesh take() { return std::move(mesh_); }

 private:
  struct Corner {
    int x, y;
  };
  const Vec3& at(const Corner& c) const { return pixels_.at(c.x, c.y); }
  bool joined(const Corner& a, const Corner& b) const {
    return pixels_.joined(a.x, a.y, b.x, b.y, jump_);
  }
  int numberOf(const Corner& c) {
    int& number = number_[pixels_.index(c.x, c.y)];
    if (number < 0) {
      number = static_cast<int>(mesh_.vertices.size());
      mesh_.vertices.push_back(at(c));
    }
    return number;
  }
  void triangle(const Corner& a, const Corner& b, const Corner& c) {
    if (!joined(a, b) || !joined(b, c) || !joined(c, a)) return;
    const Vec3 normal = (at(b) - at(a)).cross(at(c) - at(a));
    const bool looksHere = normal.dot(image_.viewpoint - at(a)) > 0;
    mesh_.triangles.emplace_back(numberOf(a), numberOf(looksHere ? b : c),
                                 numberOf(looksHere ? c : b));
  }

  const DepthImage& image_;
  DepthPixels pixels_;
  double jump_;
  std::vector<int> number_;
  Mesh mesh_;
};

}  // namespace

Mesh toMesh(const DepthImage& image, const DepthSettings& settings) {
  validate(image);
  PixelMesh mesh(image, jumpOf(image, settings));
  for (int y = 0; y + 1 < image.height; ++y)
    for (int x = 0; x + 1 < image.width; ++x) mesh.square(x, y);
  return mesh.take();
}

Cloud toCloud(const DepthImage& image, const DepthCloudSettings& settings, DepthReport* report) {
  if (!(settings.voxelSize > 0) || !std::isfinite(settings.voxelSize))
    throw std::invalid_argument("depthImage: voxelSize must be positive and finite [m]");
  if (!(settings.thickness >= 0) || !std::isfinite(settings.thickness))
    throw std::invalid_argument("depthImage: thickness must be finite, not negative [m]");
  DepthSettings meshing = settings.image;
  DepthReport found;
  const DepthImage clean = mended(image, meshing, &found);
  meshing.jump = found.jump;  // that of the original image
  Mesh front = toMesh(clean, meshing);
  if (front.triangles.empty())
    throw std::invalid_argument(
        "depthImage: no three neighboring pixels are one surface; "
        "give a larger jump");
  const double thickness = settings.thickness > 0 ? settings.thickness : 3 * settings.voxelSize;
  DigitizeSettings digitizing;
  digitizing.voxelSize = settings.voxelSize;
  digitizing.threads = settings.image.threads;
  if (report) *report = found;
  if (settings.backing == Backing::Shell) return digitize(shell(front, thickness), digitizing);
  std::vector<Vec3> behind;
  for (const Vec3& v : front.vertices)
    behind.push_back(thickness * (v - image.viewpoint).normalized());
  return digitize(thickened(std::move(front), behind), digitizing);
}

}  // namespace cloudcontact
