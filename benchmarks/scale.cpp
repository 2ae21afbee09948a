// Growth of a step's time with the number of bodies, pairs, contacts and voxels, compared with
// Bullet's convex parts (HACD) of the same nuts; and the memory of a field.
//   scale [--quick] [--threads N] [--out FILE.json]
// Prints a table. FILE.json holds all results, and FILE.csv beside it the rows.
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/digitize.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "command.h"
#include "nuts.h"

namespace {

using namespace cloudcontact;
using nlohmann::json;

constexpr double kVoxel = 1e-3;
constexpr int kSettle = 10, kMeasured = 5;  // steps
// Of the diagonal. A nut has 23 parts; at 0.01 it has 170, and 30 nuts take 20 s a step.
constexpr double kConcavity = 0.1;
constexpr int kMaxPartBodies = 316;  // which take seconds a step

std::shared_ptr<const SurfaceField> fieldAt(double voxel) {
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  return SurfaceField::build(digitize(nut(), settings));
}

json rowOf(const char* method, double voxel, std::size_t bandVoxels, const HeapRow& row) {
  std::printf(
      "%6s %7d bodies %8.0f pairs %9.0f contacts  step %9.3f ms, narrow phase %9.3f ms, "
      "deepest %.3f mm\n",
      method, row.bodies, row.pairs, row.contacts, 1e3 * row.stepSeconds, 1e3 * row.narrowSeconds,
      1e3 * row.deepest);
  std::fflush(stdout);
  return {{"method", method},
          {"voxel", voxel},
          {"bandVoxels", bandVoxels},
          {"bodies", row.bodies},
          {"overlaps", row.overlaps},
          {"pairs", row.pairs},
          {"contacts", row.contacts},
          {"stepSeconds", row.stepSeconds},
          {"narrowPhaseSeconds", row.narrowSeconds},
          {"deepest", row.deepest}};
}

json cloudRow(const std::shared_ptr<const SurfaceField>& field, int bodies, int threads) {
  HeapSettings settings = nutHeap(bodies, field->cloud().voxelSize(), threads);
  settings.shape = [&] { return std::make_shared<CloudShape>(field); };
  Heap heap(settings);
  json row = rowOf("cloud", settings.voxel, field->bandVoxels(), heap.run(kSettle, kMeasured));
  std::set<const SurfaceField*> fields;
  for (const auto& shape : heap.shapes())
    fields.insert(&static_cast<const CloudShape&>(*shape).field());
  if (fields.size() != 1) throw std::runtime_error("equal shapes should share one field");
  row["fieldBytes"] = field->bytes();
  return row;
}

json partsRow(const program::ConvexParts& parts, int bodies) {
  HeapSettings settings = nutHeap(bodies, kVoxel, 1);
  std::vector<std::shared_ptr<void>> keep;
  makeOfParts(settings, parts, keep);
  Heap heap(settings);
  return rowOf("hacd", 0, 0, heap.run(2, 3));
}

// The slope of log(time) over log(count), by least squares.
double exponent(const json& rows, const char* count, const char* time) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const json& row : rows) {
    const double a = std::log(row[count].get<double>()), b = std::log(row[time].get<double>());
    n += 1, x += a, y += b, xx += a * a, xy += a * b;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

json exponents(const json& rows, std::initializer_list<const char*> counts) {
  json out;
  for (const char* count : counts)
    for (const char* time : {"narrowPhaseSeconds", "stepSeconds"}) {
      out[time][count] = exponent(rows, count, time);
      std::printf("%s ~ %s^%.3f\n", time, count, out[time][count].get<double>());
    }
  return out;
}

void writeFiles(const std::string& path, const json& all) {
  std::ofstream(path) << all.dump(2) << '\n';
  std::ofstream csv(path.substr(0, path.rfind('.')) + ".csv");
  bool first = true;
  for (const char* group : {"byBodies", "byVoxels", "hacd"})
    for (const json& row : all[group]) {
      if (first) {
        csv << "group";
        for (const auto& [name, value] : all["byBodies"][0].items()) csv << ',' << name;
        csv << '\n';
      }
      first = false;
      csv << group;
      for (const auto& [name, value] : all["byBodies"][0].items()) {
        csv << ',';
        if (row.contains(name)) csv << row[name].dump();
      }
      csv << '\n';
    }
  if (!csv) throw std::runtime_error(path + ": cannot write the file");
}

struct Options {
  bool quick = false;
  int threads = 1;
  std::string out;
};

void measure(const Options& options) {
  json all;
  const std::vector<int> counts =
      options.quick ? std::vector{100, 316, 1000} : std::vector{100, 316, 1000, 3162, 10000};
  const auto field = fieldAt(kVoxel);
  for (const int bodies : counts)
    all["byBodies"].push_back(cloudRow(field, bodies, options.threads));
  all["byBodiesExponents"] = exponents(all["byBodies"], {"bodies", "pairs", "contacts"});
  for (const double voxel : {2 * kVoxel, kVoxel, kVoxel / 2})
    all["byVoxels"].push_back(cloudRow(fieldAt(voxel), 100, options.threads));
  all["byVoxelsExponents"] = exponents(all["byVoxels"], {"bandVoxels"});
  const program::ConvexParts parts = program::convexParts(nut(), kConcavity);
  all["hacdParts"] = parts.corners.size();
  for (const int bodies : counts)
    if (bodies <= (options.quick ? 100 : kMaxPartBodies))
      all["hacd"].push_back(partsRow(parts, bodies));
  all["threads"] = options.threads;
  all["bytesPerBandVoxel"] = double(field->bytes()) / double(field->bandVoxels());
  std::printf("one field serves all shapes: %zu band voxels of %.1f bytes\n", field->bandVoxels(),
              all["bytesPerBandVoxel"].get<double>());
  if (!options.out.empty()) writeFiles(options.out, all);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App words("Growth of time with bodies, pairs, contacts and voxels", "scale");
  words.add_flag("--quick", options.quick);
  words.add_option("--threads", options.threads);
  words.add_option("--out", options.out, "a JSON file");
  return runCommand(words, argc, argv, [&options] { measure(options); });
}
