// One tree for the process, of which each file gets a copy.
#include "scene/sdf_tree.h"

#include <memory>
#include <mutex>
#include <sdf/sdf.hh>
#include <stdexcept>

namespace cloudcontact::program {

sdf::SDFPtr emptySdfTree() {
  static std::mutex mutex;
  static const sdf::SDFPtr known = [] {
    auto made = std::make_shared<sdf::SDF>();
    if (!sdf::init(made))
      throw std::runtime_error("libsdformat finds no description of its format; install it again");
    return made;
  }();
  const std::lock_guard lock(mutex);
  auto tree = std::make_shared<sdf::SDF>();
  tree->Root(known->Root()->Clone());
  return tree;
}

}  // namespace cloudcontact::program
