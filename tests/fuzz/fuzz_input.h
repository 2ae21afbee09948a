// Inputs of fuzz targets: as files, and as numbers.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace cloudcontact::fuzz {

// Writes a file of this name, in a folder of this process in memory where there is one. The next
// call may write to the same file.
std::filesystem::path inputFile(const std::string& name, std::string_view bytes);
std::string contentOf(const std::filesystem::path& file);
// The folder; it is removed at the end.
const std::filesystem::path& inputFolder();

// Runs `read`. It may refuse the input by an exception that says where the fault is: its message
// holds `name`. Any other exception ends the program, as does one of the standard library's own.
void mayRefuse(const std::string& name, const std::function<void()>& read);

// Takes numbers from the front of an input; zeros after its end.
class Draw {
 public:
  explicit Draw(std::string_view bytes) : left_(bytes) {}
  template <typename Number>
  Number take() {
    Number x{};
    const std::size_t count = std::min(sizeof x, left_.size());
    if (count > 0) std::memcpy(&x, left_.data(), count);
    left_.remove_prefix(count);
    return x;
  }
  int upTo(int most) { return take<std::uint8_t>() % (most + 1); }
  // A length of a tame body [m], or any double.
  double length();
  Vec3 vector() {
    const double x = length(), y = length(), z = length();
    return {x, y, z};
  }
  std::string_view rest() const { return left_; }
  bool empty() const { return left_.empty(); }

 private:
  std::string_view left_;
};

// Appends a number's bytes to a seed.
template <typename Number>
void add(std::string& seed, Number x) {
  seed.append(reinterpret_cast<const char*>(&x), sizeof x);
}

// On this thread alone.
std::shared_ptr<const SurfaceField> fieldOf(const Cloud& cloud);
void digitizeSmall(const Mesh& mesh, double voxel);  // up to 16 MB

// Bodies of seeds and pairs: voxels of 1 mm.
Cloud smallBall(double radius = 5);
Cloud smallPlate();
Cloud twoParts();
Mesh cube(double edge);

}  // namespace cloudcontact::fuzz
