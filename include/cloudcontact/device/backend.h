// Where work runs, and what the classes of this room report about a device.
#pragma once

#include <cstddef>

namespace cloudcontact {

// What computes; both give the same bits.
enum class Backend { Cpu, OpenCl };

// Of ContactBatch and the batches of a CloudDispatcher.
struct BatchSettings {
  Backend backend = Backend::Cpu;
  int threads = 0;      // of the CPU; 0: all cores
  bool timing = false;  // times each kernel and copy, which slows the batch down
};

// Total time of one kernel or copy on the device.
struct DeviceTime {
  double seconds = 0;
  int calls = 0;
};

// One call of ContactBatch::find().
struct BatchReport {
  std::size_t onDevice = 0, onCpu = 0;  // pairs
  // Pairs that the CPU solved, by reason.
  // No memory for their hits or bins. The next call reserves more, up to 1,024 bins a pair and a
  // million hits a side.
  std::size_t noRoom = 0;
  // They need a finer sample level than any pair of the last two calls. The next call searches it.
  std::size_t finer = 0;
  std::size_t nearMisses = 0;  // no overlap, but a margin: the device has no near misses
  // One body is a hull, triangles or another cloud's Solid, or has tissues or stated base vectors;
  // or an edge of a plain Solid touches. The device has clouds and plain Solids.
  std::size_t shapes = 0;
  // On the device: samples looked up, then what became of them.
  std::size_t samples = 0, hits = 0, bins = 0, patches = 0, contacts = 0;
  std::size_t sent = 0, fetched = 0;  // [bytes]

  BatchReport& operator+=(const BatchReport& other);
};

// One call of Digitizer::run() on the device.
struct DeviceDigitizeReport {
  bool onDevice = false;
  std::size_t triangles = 0;
  std::size_t listed = 0;   // pairs of a triangle and a column of bricks that it lies over
  std::size_t places = 0;   // slots for pieces of triangles in voxels
  std::size_t touched = 0;  // bricks with a piece in them
  std::size_t stored = 0;   // bricks that are neither empty nor solid
  std::size_t blocks = 0;   // bricks with window sums of their own
  std::size_t taps = 0;     // voxels in a window
  std::size_t rounds = 0;   // 1, or more if the device had to enlarge its memory first
  std::size_t sent = 0;     // [bytes]
};

// One call of DeviceWorkpiece::cut() on the device.
struct DeviceCutReport {
  std::size_t voxels = 0;             // in the list
  std::size_t changed = 0;            // entries that removed material, as cut() returns
  std::size_t bricks = 0;             // bricks whose window sums changed
  std::size_t sent = 0, fetched = 0;  // [bytes]
};

}  // namespace cloudcontact
