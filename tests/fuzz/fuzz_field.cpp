// `.field` files: a good field with arrays changed, saved with a right checksum, read, and used in
// a contact. And the bytes of such a file changed, which the checksum finds.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/field/field_file.h>

#include <sstream>

#include "field/field_bytes.h"
#include "field/field_data.h"
#include "fuzz/fuzz_input.h"
#include "fuzz/fuzz_target.h"

namespace cloudcontact::fuzz {

namespace {

using Field = std::shared_ptr<const SurfaceField>;

const Field& goodField(int number) {
  static const Field fields[] = {fieldOf(smallBall()), fieldOf(smallPlate()), fieldOf(twoParts())};
  return fields[number];
}

// Visits all arrays of a field but the cloud's (those are fuzz_cloud.cpp's).
template <typename Visit>
void forEachArray(FieldRecords& records, SampleSet& samples, Visit&& visit) {
  FieldRecords::forEachArray(records, visit);
  for (SampleLevel& level : samples.levels) {
    SampleColumns& s = level.samples;
    for (auto* column : {&s.x, &s.y, &s.z, &s.nx, &s.ny, &s.nz, &s.area, &s.width}) visit(*column);
    visit(level.clusters.rise);
    for (auto& column : level.clusters.spread) visit(column);
    visit(level.cellOf), visit(level.finer);
  }
  SampleBricks& b = samples.bricks;
  visit(b.x), visit(b.y), visit(b.z), visit(b.radius), visit(b.runs);
}

// Changes the array of this number: its length, or some bytes.
void change(FieldRecords& records, SampleSet& samples, int number, Draw& draw) {
  int at = 0;
  forEachArray(records, samples, [&](auto& array) {
    if (at++ != number) return;
    const int kind = draw.upTo(4);
    const auto value = draw.take<std::uint32_t>();
    const auto place = draw.take<std::uint16_t>();
    if (kind == 0 || array.empty()) {
      array.resize(array.size() + value % 5);
    } else if (kind == 1) {
      array.resize(array.size() - std::min<std::size_t>(array.size(), 1 + value % 3));
    } else {
      auto& item = array[place % array.size()];
      std::memcpy(static_cast<void*>(&item), &value, std::min(sizeof item, sizeof value));
    }
  });
}

void use(const SurfaceField& field) {
  for (int k = 0; k < 30; ++k) field.at(1e-3 * Vec3(k % 17, 8, k * 7 % 17));
  field.hash();
  scaled(field, 2);
  for (const double shift : {0.0, 0.004, 0.009, 0.03}) {
    ContactFinder finder;
    ContactBody a, b;
    a.field = &field, b.field = goodField(0).get();
    b.pose.position = Vec3(shift, 0, shift / 3);
    for (const std::size_t samples : {1, 300, 100000}) {
      ContactSettings settings;
      settings.samples = samples;
      for (const ContactPoint& point : finder.find(a, b, settings).points)
        require(point.position.allFinite() && point.normal.allFinite() &&
                    std::isfinite(point.depth) && std::isfinite(point.stiffness),
                "a contact point that is not finite");
    }
  }
}

void readChanged(std::string_view input) {
  Draw draw(input);
  const FieldData& data = goodField(draw.upTo(2))->data();
  FieldRecords records = data.records();
  SampleSet samples = data.samples();
  for (int left = draw.upTo(5); left > 0; --left) change(records, samples, draw.upTo(60), draw);
  // A constructor looks at all samples, but at no length.
  for (auto* column : {&samples.levels[0].samples.y, &samples.levels[0].samples.z})
    if (column->empty()) return;
  const SurfaceField changed(
      std::make_shared<const FieldData>(data.cloud(), std::move(records), std::move(samples)));
  std::ostringstream out;
  writeField(changed, out);
  std::string bytes = out.str();
  const auto load = [&] {
    std::istringstream in(bytes);
    mayRefuse("a.field", [&] { use(*readField(in, bytes.size(), "a.field")); });
  };
  load();
  const auto place = draw.take<std::uint32_t>();
  const auto cut = draw.take<std::uint16_t>();
  bytes[place % bytes.size()] = static_cast<char>(bytes[place % bytes.size()] ^ 1);
  bytes.resize(bytes.size() - cut % bytes.size());
  load();
}

std::vector<std::string> seedsOfField() {
  std::vector<std::string> all;
  for (char field = 0; field < 3; ++field)
    for (char array = 0; array < 60; array = static_cast<char>(array + 4)) {
      std::string seed{field, 1, array, 2};
      add(seed, std::uint32_t{0x7fc00000});
      add(seed, std::uint16_t{3});
      all.push_back(seed);
    }
  all.push_back(std::string(6, '\0'));
  return all;
}

}  // namespace

Target fieldTarget() {
  return {"field", readChanged, seedsOfField, 80};
}

}  // namespace cloudcontact::fuzz
