// Results that worlds with equal bodies share, so that each mesh is digitized, or decomposed into
// convex parts, only once.
#pragma once

#include <cloudcontact/field/field_levels.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/cloud.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "scene/bullet_methods.h"

namespace cloudcontact::program {

// Whether nobody but the store has a value.
template <typename Value>
bool isUnused(const std::shared_ptr<Value>& value) {
  return value.use_count() <= 1;
}
inline bool isUnused(const Cloud& cloud) {
  return cloud.life().use_count() <= 1;
}
inline bool isUnused(const ConvexParts&) {
  return true;
}

// A thread-safe cache: one value for each key. The first thread makes it, others wait.
template <class Value>
class KeptOnce {
 public:
  // Rethrows what `make` threw to all who wait. Who asks later makes it again: it may have ended at
  // Ctrl-C.
  Value get(const std::string& key, const std::function<Value()>& make) {
    std::promise<Value> promise;
    std::shared_future<Value> future;
    bool first = false;
    {
      const std::lock_guard lock(mutex_);
      const auto [known, isNew] = kept_.try_emplace(key);
      if (isNew) known->second.value = promise.get_future().share();
      known->second.asked = ++asked_;
      future = known->second.value, first = isNew;
    }
    if (first) try {
        promise.set_value(make());
      } catch (...) {
        {
          const std::lock_guard lock(mutex_);
          kept_.erase(key);
        }
        promise.set_exception(std::current_exception());
      }
    return future.get();
  }

  // Drops the values that nobody uses, all but the `most` that were asked for last.
  void trim(std::size_t most) {
    const std::lock_guard lock(mutex_);
    std::vector<std::pair<std::uint64_t, std::string>> unused;
    for (const auto& [key, entry] : kept_)
      if (entry.value.wait_for(std::chrono::seconds(0)) == std::future_status::ready &&
          isUnused(entry.value.get()))
        unused.emplace_back(entry.asked, key);
    std::sort(unused.begin(), unused.end());
    for (std::size_t i = 0; i + most < unused.size(); ++i) kept_.erase(unused[i].second);
  }

 private:
  struct Entry {
    std::shared_future<Value> value;
    std::uint64_t asked = 0;  // when, last
  };
  std::mutex mutex_;
  std::uint64_t asked_ = 0;
  std::map<std::string, Entry> kept_;
};

// Keys hold all that the values depend on (contentKey, pose, voxel); those of fields and levels are
// the cloud's address, which they keep.
struct ShapeStore {
  KeptOnce<Cloud> clouds;
  KeptOnce<std::shared_ptr<const SurfaceField>> fields;
  KeptOnce<std::shared_ptr<const FieldLevels>> levels;
  KeptOnce<ConvexParts> parts;

  // Fields first, which use clouds.
  void trim(std::size_t most) {
    fields.trim(most), levels.trim(most), parts.trim(most);
    clouds.trim(most);
  }
};

// One for all worlds of this process. It keeps what they use, and what trim() leaves of the rest.
std::shared_ptr<ShapeStore> commonStore();

// A key from a hash of a mesh's vertices and triangles.
std::string contentKey(const Mesh& mesh);

}  // namespace cloudcontact::program
