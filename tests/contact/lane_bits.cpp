// Prints the hashes of some fields and every bit of their contacts in many poses, also with windows
// stated. Built twice: as
// the library ships, with loops for the machine's instruction set, and with plain loops. Both must
// print the same (docs/engine.md, "One arithmetic").
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/contact/paper_body.h>

#include <cstdio>
#include <cstring>
#include <random>

#include "contact/contact_cases.h"
#include "field/mesh_field.h"

namespace {

using namespace cloudcontact;
using namespace cloudcontact::testing;

void print(const ContactResult& result) {
  for (const ContactPoint& p : result.points) {
    const double values[] = {p.position.x(), p.position.y(), p.position.z(), p.normal.x(),
                             p.normal.y(),   p.normal.z(),   p.depth,        p.stiffness};
    for (const double v : values) {
      unsigned long long bits = 0;
      std::memcpy(&bits, &v, sizeof v);
      std::printf("%016llx ", bits);
    }
    std::printf("%u\n", p.id);
  }
}

}  // namespace

int main() {
  // A cross of two beams has convex and concave edges; a drum has a curved side and rims.
  Mesh beams = boxMesh(Vec3(2, 0.5, 0.4));
  const Mesh other = boxMesh(Vec3(0.4, 1.6, 0.5));
  const std::uint32_t first = static_cast<std::uint32_t>(beams.vertices.size());
  beams.vertices.insert(beams.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (auto t : other.triangles) {
    for (auto& corner : t) corner += first;
    beams.triangles.push_back(t);
  }
  const auto cross = fieldOf(beams, 0.03), drum = fieldOf(cylinderMesh(0.6, 0.8, 1e-4), 0.04);
  for (const auto& field : {cross, drum})
    std::printf("%016llx\n", static_cast<unsigned long long>(field->hash()));
  const PaperBody ofCross = paperBody(cross->cloud(), {}), ofDrum = paperBody(drum->cloud(), {});
  const Solid shapes[] = {HalfSpace{}, Box{Vec3(0.5, 0.4, 0.3)}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int k = 0; k < 300; ++k) {
    ContactBody a, b;
    a.field = k % 2 ? cross.get() : drum.get();
    b.field = k % 3 ? drum.get() : cross.get();
    if (k % 5 == 0) {
      b.field = nullptr;
      b.shape = &shapes[k / 5 % 2];
    }
    b.pose.position = 0.9 * Vec3(any(random), any(random), any(random));
    b.pose.orientation =
        Eigen::Quaterniond(any(random), any(random), any(random), any(random)).normalized();
    ContactSettings settings;
    settings.margin = k % 7 ? 0 : 0.04;
    settings.samples = k % 4 ? 300 : 3000;
    ContactFinder finder;
    std::printf("%d\n", k);
    print(finder.find(a, b, settings));
    for (const WorkCounts::Named& each : WorkCounts::all())
      std::printf("%s %zu\n", each.name, finder.work().*each.count);
    a.paper = a.field == cross.get() ? &ofCross : &ofDrum;
    if (b.field) b.paper = b.field == cross.get() ? &ofCross : &ofDrum;
    settings.samples = k % 4 ? 20 : 300;
    print(ContactFinder().find(a, b, settings));
  }
}
