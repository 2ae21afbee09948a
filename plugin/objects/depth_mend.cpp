// Fills holes and smooths noise of depth images (depth_image.h).
//
// The surface of a pixel is found by region growing from neighbor to neighbor, never across a jump
// in the distance from the camera. A quadratic in columns and rows is then fitted to the rim of a
// hole, or to the surroundings of a pixel: a mean, as in the usual bilateral filter, moves inclined
// and curved surfaces. A second fit gives less weight to pixels that the first does not explain.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <cloudcontact/objects/depth_image.h>

#include <Eigen/Cholesky>

#include "base/parallel.h"
#include "objects/depth_pixels.h"

namespace cloudcontact {

namespace {

constexpr double kJump = 6;       // times the distance of neighbors
constexpr double kSpread = 0.25;  // of the jump: a pixel this far from the fit has a weight of 0.6

// A least-squares quadratic in columns and rows. Fits `Values` numbers at once over the same
// pixels.
template <int Values>
class PixelFit {
 public:
  static constexpr int kTerms = 6;  // 1 x y xx xy yy
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using Row = Eigen::Matrix<double, 1, Values>;

  void add(double x, double y, const Row& value, double weight = 1) {
    const Terms t = terms(x, y);
    a_ += weight * t * t.transpose();
    b_ += weight * t * value;
    ++count_;
  }
  int count() const { return count_; }
  // Call after the last add(). Fits a plane to fewer than 9 pixels, a mean to fewer than 4.
  void solve() {
    const int n = count_ >= 9 ? 6 : count_ >= 4 ? 3 : 1;
    a_.diagonal().array() += 1e-9 * a_(0, 0);
    q_.setZero();
    q_.topRows(n) = a_.topLeftCorner(n, n).ldlt().solve(b_.topRows(n));
  }
  Row at(double x, double y) const { return terms(x, y).transpose() * q_; }

 private:
  static Terms terms(double x, double y) {
    Terms t;
    t << 1, x, y, x * x, x * y, y * y;
    return t;
  }
  Eigen::Matrix<double, kTerms, kTerms> a_ = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  Eigen::Matrix<double, kTerms, Values> b_ = Eigen::Matrix<double, kTerms, Values>::Zero();
  Eigen::Matrix<double, kTerms, Values> q_ = Eigen::Matrix<double, kTerms, Values>::Zero();
  int count_ = 0;
};

struct Pixel {
  int x, y;
};

// The pixels of one hole, by region growing; marks them in `seen`.
std::vector<Pixel> holeFrom(const DepthImage& image, Pixel start, std::vector<bool>& seen) {
  std::vector<Pixel> hole{start};
  const DepthPixels pixels(image);
  seen[pixels.index(start.x, start.y)] = true;
  for (std::size_t k = 0; k < hole.size(); ++k) {
    const Pixel at = hole[k];
    for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const Pixel next{at.x + dx, at.y + dy};
      if (!pixels.within(next.x, next.y) || pixels.there(next.x, next.y)) continue;
      if (seen[pixels.index(next.x, next.y)]) continue;
      seen[pixels.index(next.x, next.y)] = true;
      hole.push_back(next);
    }
  }
  return hole;
}

// Fills a hole in `result`; false where its rim is not one surface.
bool fillHole(const DepthImage& image, const std::vector<Pixel>& hole, double jump,
              DepthImage& result) {
  const DepthPixels pixels(image);
  int lowX = image.width, highX = -1, lowY = image.height, highY = -1;
  for (const Pixel& p : hole) {
    lowX = std::min(lowX, p.x), highX = std::max(highX, p.x);
    lowY = std::min(lowY, p.y), highY = std::max(highY, p.y);
  }
  // A hole at the border of the image has no closed rim.
  if (lowX == 0 || lowY == 0 || highX == image.width - 1 || highY == image.height - 1) return false;
  constexpr int kRim = 2;
  std::vector<Pixel> rim;
  for (int y = lowY - kRim; y <= highY + kRim; ++y)
    for (int x = lowX - kRim; x <= highX + kRim; ++x) {
      const auto near = [&](const Pixel& p) {
        return std::abs(p.x - x) <= kRim && std::abs(p.y - y) <= kRim;
      };
      if (pixels.within(x, y) && pixels.there(x, y) && std::any_of(hole.begin(), hole.end(), near))
        rim.push_back({x, y});
    }
  if (rim.size() < 8) return false;
  const double midX = 0.5 * (lowX + highX), midY = 0.5 * (lowY + highY);
  PixelFit<3> fit;
  for (const Pixel& p : rim) fit.add(p.x - midX, p.y - midY, pixels.at(p.x, p.y).transpose());
  fit.solve();
  for (const Pixel& p : rim) {
    const Vec3 fitted = fit.at(p.x - midX, p.y - midY).transpose();
    if (std::abs((fitted - image.viewpoint).norm() - pixels.range(p.x, p.y)) > 0.5 * jump)
      return false;
  }
  for (const Pixel& p : hole)
    result.points[pixels.index(p.x, p.y)] = fit.at(p.x - midX, p.y - midY).transpose();
  return true;
}

void fillHoles(DepthImage& image, const DepthSettings& settings, DepthReport& report) {
  const DepthImage before = image;
  const DepthPixels pixels(before);
  std::vector<bool> seen(before.points.size(), false);
  for (int y = 0; y < before.height; ++y)
    for (int x = 0; x < before.width; ++x) {
      if (pixels.there(x, y) || seen[pixels.index(x, y)]) continue;
      const std::vector<Pixel> hole = holeFrom(before, {x, y}, seen);
      const bool small = hole.size() <= static_cast<std::size_t>(settings.holePixels);
      (small && fillHole(before, hole, report.jump, image) ? report.filled : report.left) +=
          hole.size();
    }
}

// Smooths the distance of one pixel at a time by the pixels of its surface within the window.
class Smoother {
 public:
  Smoother(const DepthPixels& pixels, int radius, double jump)
      : pixels_(pixels), radius_(radius), jump_(jump) {
    const auto side = static_cast<std::size_t>(2 * radius + 1);
    reached_.resize(side * side);
    front_.reserve(reached_.size());
  }

  double rangeAt(int x, int y) {
    walk(x, y);
    if (front_.size() < 9) return pixels_.range(x, y);  // too few for a quadratic
    const double sigma = 0.6 * radius_;
    PixelFit<1> fit;
    for (int pass = 0; pass < 2; ++pass) {
      const PixelFit<1> last = fit;
      fit = {};
      for (const Pixel& p : front_) {
        const double dx = p.x - x, dy = p.y - y, range = pixels_.range(p.x, p.y);
        double weight = std::exp(-0.5 * (dx * dx + dy * dy) / (sigma * sigma));
        if (pass > 0) {
          const double off = (range - last.at(dx, dy)[0]) / (kSpread * jump_);
          weight *= std::exp(-0.5 * off * off);
        }
        fit.add(dx, dy, PixelFit<1>::Row(range), weight);
      }
      fit.solve();
    }
    return fit.at(0, 0)[0];
  }

 private:
  // Collects the pixels of the same surface within the window in front_.
  void walk(int x, int y) {
    std::fill(reached_.begin(), reached_.end(), false);
    front_.assign(1, {x, y});
    reached_[place(0, 0)] = true;
    for (std::size_t k = 0; k < front_.size(); ++k) {
      const Pixel at = front_[k];
      for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const Pixel next{at.x + dx, at.y + dy};
        if (std::abs(next.x - x) > radius_ || std::abs(next.y - y) > radius_) continue;
        if (reached_[place(next.x - x, next.y - y)]) continue;
        if (!pixels_.joined(at.x, at.y, next.x, next.y, jump_)) continue;
        reached_[place(next.x - x, next.y - y)] = true;
        front_.push_back(next);
      }
    }
  }
  std::size_t place(int dx, int dy) const {
    return static_cast<std::size_t>(dx + radius_ + (2 * radius_ + 1) * (dy + radius_));
  }
  const DepthPixels& pixels_;
  int radius_;
  double jump_;
  std::vector<bool> reached_;
  std::vector<Pixel> front_;
};

void smooth(DepthImage& image, const DepthSettings& settings, double jump) {
  const DepthImage before = image;
  const DepthPixels pixels(before);
  parallelFor(image.height, settings.threads, [&](std::size_t row, int) {
    Smoother smoother(pixels, settings.smoothing, jump);
    const int y = static_cast<int>(row);
    for (int x = 0; x < image.width; ++x) {
      if (!pixels.there(x, y)) continue;
      const double range = pixels.range(x, y);
      image.points[pixels.index(x, y)] =
          image.viewpoint + smoother.rangeAt(x, y) / range * (pixels.at(x, y) - image.viewpoint);
    }
  });
}

void validate(const DepthSettings& s) {
  if (!(s.jump >= 0) || !std::isfinite(s.jump))
    throw std::invalid_argument("depthImage: jump must be finite, not negative [m]");
  if (s.holePixels < 0) throw std::invalid_argument("depthImage: holePixels must not be negative");
  if (s.smoothing < 0 || s.smoothing > 50)
    throw std::invalid_argument("depthImage: smoothing must be from 0 to 50 pixels");
}

}  // namespace

void validate(const DepthImage& image) {
  const auto fail = [](const std::string& why) {
    throw std::invalid_argument("depthImage: " + why);
  };
  if (image.width < 1 || image.height < 1) fail("width and height must be positive");
  if (image.points.size() !=
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height))
    fail("points must be width * height");
  if (!image.viewpoint.allFinite()) fail("viewpoint must be finite [m]");
  std::size_t seen = 0;
  for (const Vec3& p : image.points) {
    if (p.array().isNaN().any()) continue;
    if (!p.allFinite()) fail("a point is infinite; use NaN for a pixel without a point");
    if (p == image.viewpoint)
      fail("a point lies on the viewpoint; use NaN for a pixel without a point");
    ++seen;
  }
  if (seen < 3) fail("fewer than three pixels have a point");
}

double jumpOf(const DepthImage& image, const DepthSettings& settings) {
  validate(settings);
  if (settings.jump > 0) return settings.jump;
  const DepthPixels pixels(image);
  std::vector<double> distances;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (!pixels.there(x, y)) continue;
      if (x + 1 < image.width && pixels.there(x + 1, y))
        distances.push_back((pixels.at(x + 1, y) - pixels.at(x, y)).norm());
      if (y + 1 < image.height && pixels.there(x, y + 1))
        distances.push_back((pixels.at(x, y + 1) - pixels.at(x, y)).norm());
    }
  if (distances.empty())
    throw std::invalid_argument("depthImage: no two neighboring pixels have points");
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return kJump * *middle;
}

DepthImage mended(const DepthImage& image, const DepthSettings& settings, DepthReport* report) {
  validate(image);
  DepthReport found;
  found.jump = jumpOf(image, settings);
  found.seen = static_cast<std::size_t>(std::count_if(image.points.begin(), image.points.end(),
                                                      [](const Vec3& p) { return p.allFinite(); }));
  DepthImage result = image;
  if (settings.holePixels > 0)
    fillHoles(result, settings, found);
  else
    found.left = image.points.size() - found.seen;
  if (settings.smoothing > 0) smooth(result, settings, found.jump);
  if (report) *report = found;
  return result;
}

}  // namespace cloudcontact
