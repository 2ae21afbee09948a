// Files, numbers and bodies for fuzz targets.
#include "fuzz/fuzz_input.h"

#include <cloudcontact/voxels/digitize.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "fuzz/fuzz_target.h"
#include "voxels/small_clouds.h"

namespace cloudcontact::fuzz {

namespace fs = std::filesystem;

namespace {

class Folder {
 public:
  Folder() {
    std::error_code none;
    const fs::path memory = "/dev/shm";
    const fs::path parent = fs::is_directory(memory, none) && access(memory.c_str(), W_OK) == 0
                                ? memory
                                : fs::temp_directory_path();
    path_ = parent / ("cloudcontact-fuzz-" + std::to_string(getpid()));
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

void require(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: %s\n", what.c_str());
  std::abort();
}

const fs::path& inputFolder() {
  static const Folder folder;
  return folder.path();
}

fs::path inputFile(const std::string& name, std::string_view bytes) {
  const fs::path file = inputFolder() / name;
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  require(bool(out), "no room for " + file.string());
  return file;
}

std::string contentOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void mayRefuse(const std::string& name, const std::function<void()>& read) {
  const auto says = [&](const std::exception& refusal) {
    const std::string message = refusal.what();
    require(message.find(name) != std::string::npos,
            "a refusal that does not name " + name + ": " + message);
  };
  try {
    read();
  } catch (const std::runtime_error& refusal) {
    says(refusal);
  } catch (const std::invalid_argument& refusal) {
    says(refusal);
  } catch (const std::length_error& refusal) {
    says(refusal);
  } catch (const std::exception& other) {
    require(false, std::string("another exception than a refusal: ") + other.what());
  }
}

double Draw::length() {
  const int kind = upTo(7);
  if (kind == 0) return take<double>();
  return kind * take<std::int16_t>() * 1e-6;
}

std::shared_ptr<const SurfaceField> fieldOf(const Cloud& cloud) {
  FieldSettings settings;
  settings.threads = 1;
  return SurfaceField::build(cloud, settings);
}

void digitizeSmall(const Mesh& mesh, double voxel) {
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  settings.maxBytes = std::size_t{1} << 20;  // noise fills all of it, and each voxel is undecided
  settings.threads = 1;
  digitize(mesh, settings);
}

Cloud smallBall(double radius) {
  return test::ballCloud(1e-3, 2, Vec3(8, 8, 8), radius);
}

Cloud smallPlate() {
  return test::smallCloud(1e-3, {3, 3, 1}, [](int x, int y, int z) {
    const bool in = x > 1 && x < 22 && y > 1 && y < 22 && z > 1 && z < 5;
    return !in ? 0 : z == 2 ? 100 : 255;
  });
}

Cloud twoParts() {
  return test::smallCloud(
      1e-3, {2, 2, 2},
      [](int x, int y, int z) {
        return std::min({x, y, z}) > 1 && std::max({x, y, z}) < 14 ? 255 : 0;
      },
      {"bone", "marrow"}, [](int x, int, int) { return x > 7; });
}

Mesh cube(double edge) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.vertices.push_back(edge * Vec3((k & 1) - 0.5, (k >> 1 & 1) - 0.5, (k >> 2) - 0.5));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

}  // namespace cloudcontact::fuzz
