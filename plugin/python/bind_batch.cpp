// Python: the contacts of many pairs at once.
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/device/device_list.h>

#include "io/options.h"
#include "python/bindings.h"
#include "python/contact_values.h"
#include "python/turns.h"
#include "python/unlocked.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;

// All results of a call, one after the other.
struct BatchFound {
  std::vector<ContactPoint> points;
  std::vector<Patch> patches;
  std::vector<std::int64_t> firstPoint{0}, firstPatch{0};  // of each pair, and the end
  std::vector<double> forces, torques, depths;
  std::vector<std::size_t> samples;

  void add(const BatchPair& pair, const ContactResult& result) {
    points.insert(points.end(), result.points.begin(), result.points.end());
    patches.insert(patches.end(), result.patches.begin(), result.patches.end());
    firstPoint.push_back(static_cast<std::int64_t>(points.size()));
    firstPatch.push_back(static_cast<std::int64_t>(patches.size()));
    const Wrench onB = wrenchOnB(result, pair.a.motion, pair.b.motion);
    for (const double f : onB.force) forces.push_back(f);
    for (const double t : onB.torque) torques.push_back(t);
    depths.push_back(depthOf(result));
    samples.push_back(result.samples);
  }
};
using BatchPtr = std::shared_ptr<BatchFound>;

BatchPtr findAll(ContactBatch& batch, const std::vector<BatchPair>& pairs) {
  const Turn turn(&batch);
  const Unlocked unlocked;
  auto found = std::make_shared<BatchFound>();
  const auto results = batch.find(pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) found->add(pairs[i], *results[i]);
  return found;
}

BatchPtr findPairs(ContactBatch& batch, const py::iterable& pairs, const Law& law, double margin,
                   std::size_t samples) {
  const ContactSettings settings = settingsFrom(law, margin, samples);
  std::vector<std::pair<OwnedBody, OwnedBody>> bodies;
  for (const auto& pair : pairs) {
    const auto two = py::reinterpret_borrow<py::object>(pair).cast<py::sequence>();
    if (two.size() != 2) throw std::invalid_argument("pairs: give two bodies for each pair");
    bodies.emplace_back(bodyFrom("a", py::object(two[0])), bodyFrom("b", py::object(two[1])));
  }
  std::vector<BatchPair> list;
  for (const auto& [a, b] : bodies) list.push_back({a.view(), b.view(), settings});
  return findAll(batch, list);
}

BatchPtr findPoses(ContactBatch& batch, const py::object& first, const py::object& second,
                   const py::object& posesB, const py::object& posesA, const Law& law,
                   double margin, std::size_t samples) {
  const ContactSettings settings = settingsFrom(law, margin, samples);
  const OwnedBody a = bodyFrom("a", first), b = bodyFrom("b", second);
  const std::vector<Pose> ofB = posesOf("poses_b", posesB);
  const std::vector<Pose> ofA =
      posesA.is_none() ? std::vector<Pose>(ofB.size(), a.pose) : posesOf("poses_a", posesA);
  if (ofA.size() != ofB.size())
    throw std::invalid_argument("poses_a: has " + std::to_string(ofA.size()) + " rows, poses_b " +
                                std::to_string(ofB.size()) + "; give as many");
  std::vector<BatchPair> list;
  for (std::size_t i = 0; i < ofB.size(); ++i) {
    BatchPair pair{a.view(), b.view(), settings};
    pair.a.pose = ofA[i], pair.b.pose = ofB[i];
    pair.a.motion.center = ofA[i].position, pair.b.motion.center = ofB[i].position;
    list.push_back(pair);
  }
  return findAll(batch, list);
}

template <typename Number>
py::array numbersOf(const BatchPtr& found, const std::vector<Number>& numbers,
                    py::ssize_t columns) {
  const auto size = static_cast<py::ssize_t>(sizeof(Number));
  const auto rows = static_cast<py::ssize_t>(numbers.size()) / columns;
  if (columns == 1) return viewOf(numbers.data(), {rows}, {size}, keeping(found));
  return viewOf(numbers.data(), {rows, columns}, {columns * size, size}, keeping(found));
}

void bindFound(py::module_& module) {
  py::class_<BatchFound, BatchPtr>(module, "BatchContacts",
                                   "The contacts of n pairs. Arrays share the result's memory.")
      .def("__len__", [](const BatchFound& f) { return f.depths.size(); })
      .def_property_readonly(
          "forces", [](const BatchPtr& f) { return numbersOf(f, f->forces, 3); },
          "On B, (n, 3) [N].")
      .def_property_readonly(
          "torques", [](const BatchPtr& f) { return numbersOf(f, f->torques, 3); },
          "On B about the world's origin, (n, 3) [N m].")
      .def_property_readonly(
          "depths", [](const BatchPtr& f) { return numbersOf(f, f->depths, 1); },
          "Of the pairs (n,) [m]; 0 without a contact.")
      .def_property_readonly(
          "points", [](const BatchPtr& f) { return recordsOf(pointType(), f->points, keeping(f)); },
          "Points of all pairs, as Contact.points.")
      .def_property_readonly(
          "first_points", [](const BatchPtr& f) { return numbersOf(f, f->firstPoint, 1); },
          "Pair i has points[first_points[i]:first_points[i + 1]]: (n + 1,).")
      .def_property_readonly(
          "patches",
          [](const BatchPtr& f) { return recordsOf(patchType(), f->patches, keeping(f)); },
          "Patches of all pairs, as Contact.patches.")
      .def_property_readonly(
          "first_patches", [](const BatchPtr& f) { return numbersOf(f, f->firstPatch, 1); },
          "Pair i has patches[first_patches[i]:first_patches[i + 1]]: (n + 1,).");
}

}  // namespace

void bindBatch(py::module_& module) {
  bindFound(module);
  const KelvinVoigt usual{1e4, 0};
  py::class_<ContactBatch>(
      module, "ContactBatch",
      "Contacts of many pairs on all cores or an OpenCL device, equal to the bit to those of a\n"
      "ContactFinder for each.")
      .def(
          py::init([](const std::string& backend, int threads) {
            const Backend where = program::readBackend(backend);
            if (threads < 0) throw std::invalid_argument("threads: must be 0 or more");
            const Unlocked unlocked;
            return ContactBatch({.backend = where, .threads = threads});
          }),
          "backend"_a = "cpu", "threads"_a = 0,
          "backend: \"cpu\", or \"opencl\", which falls back to the CPU where no device gives the\n"
          "same bits; `message` says why. threads: 0 for all cores.")
      .def("find", &findPairs, "pairs"_a, py::kw_only(), "law"_a = usual, "margin"_a = 0.0,
           "samples"_a = ContactSettings::kSamples,
           "BatchContacts of pairs (a, b), each body as for ContactFinder.find(). A pair that\n"
           "keeps its place in the list keeps its points' ids.")
      .def("find_poses", &findPoses, "a"_a, "b"_a, "poses_b"_a, "poses_a"_a = py::none(),
           py::kw_only(), "law"_a = usual, "margin"_a = 0.0,
           "samples"_a = ContactSettings::kSamples,
           "BatchContacts of one pair of bodies in many poses: arrays (n, 7), x y z qx qy qz qw,\n"
           "or (n, 3).")
      .def_property_readonly(
          "backend",
          [](const ContactBatch& b) { return std::string(program::nameOf(b.backend())); },
          "In use: \"cpu\" or \"opencl\".")
      .def_property_readonly("device", &ContactBatch::device, "Name of the OpenCL device.")
      .def_property_readonly("message", &ContactBatch::message, "Why no device is used, or empty.")
      .def_property_readonly(
          "on_device",
          [](const ContactBatch& b) {
            const Turn turn(&b);
            return b.report().onDevice;
          },
          "Pairs of the last call that the device solved.");
  module.def("opencl_devices", &openClDevices,
             "Names of the OpenCL devices, GPUs first; after one that cannot be used, why.");
}

}  // namespace cloudcontact::python
