// Many worlds in parallel (many_worlds.h).
#include "python/many_worlds.h"

#include <algorithm>
#include <stdexcept>

#include "base/parallel.h"

namespace cloudcontact::python {
namespace {

double* rowOf(BodyRows& rows, std::size_t world, std::size_t bodies, std::size_t body) {
  return rows.values.data() + (world * bodies + body) * rows.columns;
}

Vec3 vectorAt(const double* row) {
  return {row[0], row[1], row[2]};
}

// Of a world that failed, by its number.
template <typename Work>
void numbered(std::size_t world, const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& why) {
    throw std::invalid_argument("world " + std::to_string(world) + ": " + why.what());
  } catch (const std::exception& why) {
    throw std::runtime_error("world " + std::to_string(world) + ": " + why.what());
  }
}

}  // namespace

ManyWorlds::ManyWorlds(std::shared_ptr<ScriptedWorld> first, std::size_t count, int workers)
    : threads(workers) {
  start = first->world->save();
  bodies = first->world->bodyCount();
  const program::SceneDescription& scene = first->scene;
  const program::WorldSettings& settings = first->settings;
  worlds.push_back(std::move(first));
  for (std::size_t i = 1; i < count; ++i) {
    auto made = std::make_shared<ScriptedWorld>();
    made->scene = scene;
    made->settings = settings;
    worlds.push_back(std::move(made));
  }
  parallelFor(count, threads, [&](std::size_t i, int) {
    ScriptedWorld& own = *worlds[i];
    if (!own.world) own.world = std::make_unique<program::World>(own.scene, own.settings);
    own.world->restore(start);
    own.time = start.time;
  });
  for (BodyRows* rows :
       {&positions, &orientations, &velocities, &angularVelocities, &forces, &torques})
    rows->values.assign(count * bodies * rows->columns, 0);
  times.assign(count, 0);
  for (std::size_t i = 0; i < count; ++i) read(i);
}

void ManyWorlds::read(std::size_t world) {
  const ScriptedWorld& own = *worlds[world];
  times[world] = own.time;
  for (std::size_t i = 0; i < bodies; ++i) {
    const program::BodyState state = own.world->state(i);
    const auto put = [&](BodyRows& rows, const auto& values) {
      std::copy_n(values.data(), rows.columns, rowOf(rows, world, bodies, i));
    };
    put(positions, state.pose.position);
    put(orientations, state.pose.orientation.coeffs());
    put(velocities, state.linearVelocity);
    put(angularVelocities, state.angularVelocity);
  }
}

void ManyWorlds::push(std::size_t world) {
  program::World& own = *worlds[world]->world;
  for (std::size_t i = 0; i < bodies; ++i) {
    const program::BodyLoad load{vectorAt(rowOf(forces, world, bodies, i)),
                                 vectorAt(rowOf(torques, world, bodies, i))};
    const program::BodyLoad& before = own.load(i);
    if (load.force != before.force || load.torque != before.torque) own.setLoad(i, load);
  }
}

void ManyWorlds::step(double seconds, int substeps) {
  parallelFor(worlds.size(), threads, [&](std::size_t i, int) {
    numbered(i, [&] {
      push(i);
      for (int k = 0; k < substeps; ++k) worlds[i]->world->step(seconds / substeps);
    });
    worlds[i]->time += seconds;
    read(i);
  });
}

void ManyWorlds::restore(std::size_t world, const program::WorldSave& save) {
  worlds[world]->world->restore(save);
  worlds[world]->time = save.time;
  for (std::size_t i = 0; i < bodies; ++i) {
    std::copy_n(save.loads[i].force.data(), 3, rowOf(forces, world, bodies, i));
    std::copy_n(save.loads[i].torque.data(), 3, rowOf(torques, world, bodies, i));
  }
  read(world);
}

}  // namespace cloudcontact::python
