// Worlds of one scene side by side: stepped on all cores, read and pushed through arrays.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "python/scripted_world.h"

namespace cloudcontact::python {

// Rows of numbers for all worlds and bodies, (worlds, bodies, columns), in memory that stays.
struct BodyRows {
  std::size_t columns = 0;
  std::vector<double> values = {};
};

struct ManyWorlds {
  std::vector<std::shared_ptr<ScriptedWorld>> worlds;
  program::WorldSave start;  // of all
  int threads = 0;           // 0: all cores
  std::size_t bodies = 0;
  BodyRows positions{3}, orientations{4}, velocities{3}, angularVelocities{3};  // read
  BodyRows forces{3}, torques{3};                                               // applied
  std::vector<double> times;

  // `first` is the first of `count`, as it is now; the others are made of its scene and settings.
  ManyWorlds(std::shared_ptr<ScriptedWorld> first, std::size_t count, int threads);

  // Steps all worlds. Throws what the first world that fails throws, with its number.
  void step(double seconds, int substeps);
  // Sets a world to a state, its arrays too. Throws as program::World::restore().
  void restore(std::size_t world, const program::WorldSave& save);
  // Reads the arrays of a world, after it was changed by itself.
  void read(std::size_t world);

 private:
  void push(std::size_t world);
};

}  // namespace cloudcontact::python
