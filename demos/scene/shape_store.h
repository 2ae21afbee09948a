// What several worlds of the same bodies share, so that a mesh is digitised, or cut into convex
// parts, once for all of them.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/cloud.h>

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "scene/bullet_methods.h"

namespace cloudcontact::program {

// One value a key. Threads may ask at once: the first makes it, the others wait for it.
template <class Value>
class KeptOnce {
 public:
  // Rethrows what `make` threw, to every asker.
  Value get(const std::string& key, const std::function<Value()>& make) {
    std::promise<Value> promise;
    std::shared_future<Value> future;
    bool first = false;
    {
      const std::lock_guard lock(mutex_);
      const auto [known, isNew] = kept_.try_emplace(key);
      if (isNew) known->second = promise.get_future().share();
      future = known->second, first = isNew;
    }
    if (first) try {
        promise.set_value(make());
      } catch (...) {
        promise.set_exception(std::current_exception());
      }
    return future.get();
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_future<Value>> kept_;
};

// Keys say all that the values hang on (contentKey, pose, voxel).
struct ShapeStore {
  KeptOnce<Cloud> clouds;
  KeptOnce<std::shared_ptr<const SurfaceField>> fields;
  KeptOnce<ConvexParts> parts;
};

// Of a mesh's own numbers, to the bit.
std::string contentKey(const Mesh& mesh);

}  // namespace cloudcontact::program
