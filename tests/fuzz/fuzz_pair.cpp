// Two bodies in any poses and motions, of any law, materials and settings.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/contact/paper_body.h>
#include <cloudcontact/device/contact_batch.h>

#include <cmath>
#include <sstream>

#include "fuzz/fuzz_input.h"
#include "fuzz/fuzz_target.h"

namespace cloudcontact::fuzz {

namespace {

struct Bodies {
  std::vector<std::shared_ptr<const SurfaceField>> fields;
  Solid solids[4] = {HalfSpace{}, Sphere{0.004}, Box{Vec3(0.01, 0.004, 0.003)},
                     Cylinder{0.004, 0.006}};

  Bodies() {
    for (const Cloud& cloud : {smallBall(), smallPlate(), twoParts()})
      fields.push_back(fieldOf(cloud));
  }
};

const Bodies& bodies() {
  static const Bodies all;
  return all;
}

Pose pose(Draw& draw) {
  Pose place;
  place.position = draw.vector();
  if (draw.upTo(3) == 0) return place;
  for (int k = 0; k < 4; ++k) place.orientation.coeffs()[k] = 1000 * draw.length();
  if (draw.upTo(7)) place.orientation.normalize();
  return place;
}

TissueTable tissues(Draw& draw, std::size_t count) {
  TissueTable table;
  for (std::size_t k = 0; k < count; ++k)
    table.push_back({"t" + std::to_string(k), 1e6 * draw.length(), 1e3 * draw.length(),
                     1e9 * draw.length(), 1e5 * draw.length()});
  return table;
}

std::string text(const Vec3& v) {
  std::ostringstream out;
  out << v.transpose();
  return out.str();
}

void requireSound(const ContactResult& found) {
  const auto unit = [](const Vec3& v) { return v.allFinite() && std::abs(v.norm() - 1) < 1e-3; };
  for (const ContactPoint& p : found.points)
    require(p.position.allFinite() && unit(p.normal) && std::isfinite(p.depth) &&
                std::isfinite(p.stiffness) && p.stiffness >= 0 && p.damping >= 0,
            "a contact point: position " + text(p.position) + ", normal " + text(p.normal) +
                ", depth " + std::to_string(p.depth) + ", k " + std::to_string(p.stiffness) +
                ", c " + std::to_string(p.damping));
  for (const Patch& p : found.patches)
    require(p.position.allFinite() && unit(p.normal) && std::isfinite(p.depth) && p.area >= 0 &&
                p.confidence >= 0 && p.confidence <= 1 && p.firstPoint >= 0 &&
                p.firstPoint + p.points <= static_cast<int>(found.points.size()),
            "a patch: position " + text(p.position) + ", normal " + text(p.normal) + ", depth " +
                std::to_string(p.depth) + ", area " + std::to_string(p.area) + ", confidence " +
                std::to_string(p.confidence));
}

void readPair(std::string_view input) {
  Draw draw(input);
  TissueTable ofA = tissues(draw, static_cast<std::size_t>(draw.upTo(2))), ofB = tissues(draw, 1);
  ContactBody a, b;
  a.field = bodies().fields[static_cast<std::size_t>(draw.upTo(2))].get();
  if (draw.upTo(2))
    b.field = bodies().fields[static_cast<std::size_t>(draw.upTo(2))].get();
  else
    b.shape = &bodies().solids[draw.upTo(3)];
  ContactSettings settings;
  settings.margin = draw.upTo(1) ? 0 : draw.length();
  settings.samples = std::size_t(1) << draw.upTo(12);
  const double k = 1e6 * draw.length(), c = 1e3 * draw.length();
  const Law laws[] = {KelvinVoigt{k, c}, Foundation{k, c}, Rigid{}, Maxwell{k, c}};
  settings.law = laws[draw.upTo(3)];
  PaperBody paperA, paperB;
  ContactFinder finder;
  mayRefuse("", [&] {
    validate(settings.law);
    if (!ofA.empty()) validate(ofA), a.tissues = &ofA;
    if (draw.upTo(3) == 0) validate(ofB), b.tissues = &ofB;
    if (draw.upTo(5) == 0) {
      paperA = paperBody(a.field->cloud(), ofA), a.paper = &paperA;
      if (b.field) paperB = paperBody(b.field->cloud(), {}), b.paper = &paperB;
    }
    for (int step = draw.upTo(3); step >= 0; --step) {
      a.pose = pose(draw), b.pose = pose(draw);
      b.motion.linear = draw.vector();
      requireSound(finder.find(a, b, settings));
    }
  });
}

std::vector<std::string> seedsOfPair() {
  std::vector<std::string> all;
  unsigned state = 11;
  for (int n = 0; n < 40; ++n) {
    std::string seed;
    for (int k = 0; k < 160; ++k) {
      state = state * 1664525 + 1013904223;
      seed += static_cast<char>(state >> 24 & 7);
    }
    all.push_back(seed);
  }
  return all;
}

}  // namespace

Target pairTarget() {
  return {"pair", readPair, seedsOfPair, 512};
}

}  // namespace cloudcontact::fuzz
