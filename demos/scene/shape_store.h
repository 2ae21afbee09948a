// Results that worlds with equal bodies share, so that each mesh is digitized, or decomposed into
// convex parts, only once.
#pragma once

#include <cloudcontact/field/field_levels.h>
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
      if (isNew) known->second = promise.get_future().share();
      future = known->second, first = isNew;
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

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_future<Value>> kept_;
};

// Keys hold all that the values depend on (contentKey, pose, voxel); those of fields and levels are
// the cloud's address, which they keep.
struct ShapeStore {
  KeptOnce<Cloud> clouds;
  KeptOnce<std::shared_ptr<const SurfaceField>> fields;
  KeptOnce<std::shared_ptr<const FieldLevels>> levels;
  KeptOnce<ConvexParts> parts;
};

// One for worlds that live at the same time in this process. It goes when the last of them does.
std::shared_ptr<ShapeStore> commonStore();

// A key from a hash of a mesh's vertices and triangles.
std::string contentKey(const Mesh& mesh);

}  // namespace cloudcontact::program
