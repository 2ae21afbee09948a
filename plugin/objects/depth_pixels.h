// DepthPixels: access to the pixels of a depth image, and the test whether two are of one surface.
#pragma once

#include <cloudcontact/objects/depth_image.h>

#include <cmath>

namespace cloudcontact {

class DepthPixels {
 public:
  explicit DepthPixels(const DepthImage& image) : image_(image) {}

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(y);
  }
  bool within(int x, int y) const {
    return x >= 0 && y >= 0 && x < image_.width && y < image_.height;
  }
  const Vec3& at(int x, int y) const { return image_.points[index(x, y)]; }
  bool there(int x, int y) const { return at(x, y).allFinite(); }
  double range(int x, int y) const { return (at(x, y) - image_.viewpoint).norm(); }
  bool joined(int x0, int y0, int x1, int y1, double jump) const {
    return within(x1, y1) && there(x0, y0) && there(x1, y1) &&
           std::abs(range(x0, y0) - range(x1, y1)) <= jump;
  }

 private:
  const DepthImage& image_;
};

// The jump of the settings, or the default for the image [m]. Throws std::invalid_argument on a bad
// setting, or where no two neighboring pixels have points.
double jumpOf(const DepthImage& image, const DepthSettings& settings);

}  // namespace cloudcontact
