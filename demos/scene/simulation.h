// Runs a world for a given time and measures it.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "scene/world.h"

namespace cloudcontact::program {

struct SimulationSettings {
  double seconds = 1;
  double step = 1.0 / 240;  // [s]
  int substeps = 1;         // number of equal parts of a step
  // Penetration is measured at this many instants, always at the end; 0: never; fewer if that takes
  // more than `mostProbes` lookups in total.
  int instants = 100;
  std::size_t mostProbes = 1'500'000;
  // Called before each step, with the time at its start.
  std::function<void(double time, World&)> control;
  // Called at the start (time 0) and after each step.
  std::function<void(double time, const World&)> observe;
  // Called after `observe`, with the same time. It may change the world, and wait. False ends the
  // run.
  std::function<bool(double time)> goesOn;
};

struct SimulationReport {
  int steps = 0;
  double step = 0;
  double wallSeconds = 0;  // of the steps, without the measurements
  double realTimeFactor = 0;
  double narrowPhaseSeconds = 0, solverSeconds = 0;
  double narrowPhaseThreadSeconds = 0;  // processor time of the stepping thread
  WorkDone work;
  double pairs = 0;            // in contact, mean of the substeps
  double contactsPerStep = 0;  // points, mean of the substeps
  double maxPenetration = 0;   // [m]
  Energy energyStart, energyEnd;
  double energyMax = 0;  // of the bodies, without springs [J]
  double springEnergyMax = 0;
  std::uint64_t hash = 0;
  std::vector<BodyState> bodies;
  std::vector<Vec3> turns;  // each body's, about the world's axes since the start [rad]
};

SimulationReport simulate(World& world, const SimulationSettings& settings);

// So many steps, of settings' length and control, without measuring penetration; fewer if they take
// longer than `most` [s].
SimulationReport simulateShort(World& world, const SimulationSettings& settings, int steps,
                               double most);

// "clouds of 0.25 mm voxels, steps of 1 ms"
std::string setupText(const WorldSettings& settings, double step, int substeps = 1);

// Names and figures of a run of this world, for people.
std::vector<std::pair<std::string, std::string>> factsOf(const World& world,
                                                         const SimulationReport& report);

}  // namespace cloudcontact::program
