// Clouds and fields kept between runs (shape_cache.h).
#include "scene/shape_cache.h"

#include <cloudcontact/base/source_hash.h>
#include <cloudcontact/field/field_file.h>
#include <cloudcontact/voxels/cloud_file.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <vector>

namespace cloudcontact::program {
namespace {

namespace fs = std::filesystem;

// 128 bits: two hashes of 64, over 8 bytes at a time, with different multipliers.
class Key {
 public:
  Key() { add(sourceHash()); }
  void add(const void* data, std::size_t bytes) {
    const auto* const p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; i += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, p + i, std::min<std::size_t>(8, bytes - i));
      mix(word);
    }
    mix(bytes);
  }
  void add(std::string_view text) { add(text.data(), text.size()); }
  void add(double number) { add(&number, sizeof number); }
  void add(const Mesh& mesh) {
    addAll(mesh.vertices);
    addAll(mesh.triangles);
  }
  template <typename Value>
  void addAll(const std::vector<Value>& values) {
    add(values.data(), sizeof(Value) * values.size());
  }
  std::string name(const char* extension) const {
    std::ostringstream text;
    text << std::hex << std::setfill('0') << std::setw(16) << one_ << std::setw(16) << two_
         << extension;
    return text.str();
  }

 private:
  void mix(std::uint64_t word) {
    one_ = (one_ ^ word) * 0x100000001B3ull;
    one_ ^= one_ >> 29;
    two_ = (two_ ^ word) * 0x9E3779B97F4A7C15ull;
    two_ ^= two_ >> 32;
  }

  std::uint64_t one_ = 0xCBF29CE484222325ull, two_ = 0x84222325CBF29CE4ull;
};

void sayOnce(const std::string& why) {
  static std::atomic<bool> said{false};
  if (!said.exchange(true))
    std::cerr << "cloudcontact: results are not kept for the next run: " << why
              << " (--no-cache keeps none)\n";
}

struct Entry {
  fs::path file;
  std::uintmax_t bytes = 0;
  fs::file_time_type used;
};

// Entries, and temporary files that a process has left.
struct Content {
  std::vector<Entry> entries;
  std::vector<fs::path> left;
};

Content contentOf(const fs::path& folder) {
  constexpr auto kLeft = std::chrono::hours(1);
  Content content;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;  // by another process
    Entry entry{at->path(), at->file_size(gone), {}};
    if (!gone) entry.used = at->last_write_time(gone);
    if (gone) continue;
    const fs::path extension = entry.file.extension();
    if (extension == ".cloud" || extension == ".field")
      content.entries.push_back(entry);
    else if (extension == ".part" && fs::file_time_type::clock::now() - entry.used > kLeft)
      content.left.push_back(entry.file);
  }
  return content;
}

}  // namespace

ShapeCache::ShapeCache(fs::path folder, std::uintmax_t most)
    : folder_(std::move(folder)), most_(most) {}

Cloud ShapeCache::cloud(const Mesh& mesh, double voxel, const std::function<Cloud()>& make) {
  Key key;
  key.add(voxel);
  key.add(mesh);
  return keptCloud(key.name(".cloud"), make);
}

Cloud ShapeCache::cloud(std::span<const NamedMesh> meshes, double voxel,
                        const std::function<Cloud()>& make) {
  Key key;
  key.add(voxel);
  for (const NamedMesh& part : meshes) {
    key.add(part.name);
    key.add(part.mesh);
  }
  return keptCloud(key.name(".cloud"), make);
}

Cloud ShapeCache::keptCloud(const std::string& name, const std::function<Cloud()>& make) {
  return get<Cloud>(
      name, [](const fs::path& file) { return loadCloud(file); }, make,
      [](const Cloud& cloud, const fs::path& file) { saveCloud(cloud, file); });
}

ShapeCache::Field ShapeCache::field(const Cloud& cloud, const std::function<Field()>& make) {
  if (cloud.empty()) return make();  // which says what is wrong
  const Cloud::Voxels& voxels = cloud.voxels();
  Key key;
  key.add(cloud.voxelSize());
  key.add(cloud.origin().data(), 3 * sizeof(double));
  key.add(voxels.bricks.data(), 3 * sizeof(int));
  key.addAll(voxels.table);
  key.addAll(voxels.coverage);
  for (const std::string& name : voxels.materials) key.add(name);
  key.addAll(voxels.materialTable);
  key.addAll(voxels.material);
  return get<Field>(
      key.name(".field"), [](const fs::path& file) { return loadField(file); }, make,
      [](const Field& field, const fs::path& file) { saveField(*field, file); });
}

template <typename Value>
Value ShapeCache::get(const std::string& name, const std::function<Value(const fs::path&)>& load,
                      const std::function<Value()>& make,
                      const std::function<void(const Value&, const fs::path&)>& save) {
  const fs::path file = folder_ / name;
  std::error_code ignored;
  if (fs::exists(file, ignored)) try {
      Value value = load(file);
      fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);
      return value;
    } catch (const std::exception&) {
      fs::remove(file, ignored);  // broken, or just removed by another process
    }
  Value value = make();
  keep(file, [&] { save(value, file); });
  return value;
}

void ShapeCache::keep(const fs::path& file, const std::function<void()>& save) {
  try {
    if (fs::create_directories(file.parent_path()))
      fs::permissions(file.parent_path(), fs::perms::owner_all);
    save();
    trim();
  } catch (const std::exception& error) {
    sayOnce(error.what());
  }
}

void ShapeCache::trim() const {
  std::error_code ignored;
  Content content = contentOf(folder_);
  for (const fs::path& file : content.left) fs::remove(file, ignored);
  std::uintmax_t bytes = 0;
  for (const Entry& entry : content.entries) bytes += entry.bytes;
  std::sort(content.entries.begin(), content.entries.end(),
            [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : content.entries) {
    if (bytes <= most_) return;
    fs::remove(entry.file, ignored);
    bytes -= entry.bytes;
  }
}

std::shared_ptr<ShapeCache> usualCache() {
  const auto set = [](const char* name) {
    const char* const value = std::getenv(name);
    return fs::path(value ? value : "");
  };
  if (const fs::path given = set("CLOUDCONTACT_CACHE"); !given.empty())
    return given == "off" ? nullptr : std::make_shared<ShapeCache>(given);
  fs::path caches = set("XDG_CACHE_HOME");
  if (!caches.is_absolute() && set("HOME").is_absolute()) caches = set("HOME") / ".cache";
  if (!caches.is_absolute()) return nullptr;
  return std::make_shared<ShapeCache>(caches / "cloudcontact");
}

}  // namespace cloudcontact::program
