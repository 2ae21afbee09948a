// A body of a world, as Python holds it.
#pragma once

#include <cstddef>
#include <memory>

#include "python/scripted_world.h"
#include "python/turns.h"

namespace cloudcontact::python {

struct WorldBody {
  std::shared_ptr<ScriptedWorld> world;
  std::size_t index = 0;
  program::BodyState state() const {
    const Turn turn(world.get());
    return world->world->state(index);
  }
};

// Adds the class WorldBody.
void bindWorldBody(py::module_& module);

}  // namespace cloudcontact::python
