// Clouds and fields kept between runs of the program, in files that are found by the content of
// what they are made from, the settings, and the library's sourceHash().
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace cloudcontact::program {

// Safe with any number of threads and processes at once: an entry is complete or absent. A broken
// entry is made again. Where an entry cannot be written (the disk is full), the result is made each
// time, and a line on stderr says so once.
class ShapeCache {
 public:
  static constexpr std::uintmax_t kMost = std::uintmax_t{1} << 30;  // [bytes]

  // Makes the folder when it first writes. Beyond `most` bytes the entries that were not used for
  // the longest time go.
  explicit ShapeCache(std::filesystem::path folder, std::uintmax_t most = kMost);

  // The cloud of a mesh, or of several, from the cache or else by `make`. Rethrows what that
  // throws.
  Cloud cloud(const Mesh& mesh, double voxel, const std::function<Cloud()>& make);
  Cloud cloud(std::span<const NamedMesh> meshes, double voxel, const std::function<Cloud()>& make);
  // The field of a cloud. One from the cache is not renewable.
  using Field = std::shared_ptr<const SurfaceField>;
  Field field(const Cloud& cloud, const std::function<Field()>& make);

  const std::filesystem::path& folder() const { return folder_; }

 private:
  Cloud keptCloud(const std::string& name, const std::function<Cloud()>& make);
  template <typename Value>
  Value get(const std::string& name, const std::function<Value(const std::filesystem::path&)>& load,
            const std::function<Value()>& make,
            const std::function<void(const Value&, const std::filesystem::path&)>& save);
  void keep(const std::filesystem::path& file, const std::function<void()>& save);
  void trim() const;

  std::filesystem::path folder_;
  std::uintmax_t most_;
};

// That of CLOUDCONTACT_CACHE: a folder, or "off". Without it, cloudcontact in XDG_CACHE_HOME or
// ~/.cache. Null: none.
std::shared_ptr<ShapeCache> usualCache();

}  // namespace cloudcontact::program
