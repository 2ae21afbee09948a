// A batch of pairs has the contacts of a finder for each pair.
#include <cstdio>
#include <vector>

#include <outside/cube.h>

int main() {
  using namespace cloudcontact;
  DigitizeSettings settings;
  settings.voxelSize = 0.002;
  const auto field = SurfaceField::build(digitize(cube(0.04), settings));
  std::vector<BatchPair> pairs(8);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].a.field = pairs[i].b.field = field.get();
    pairs[i].b.pose.position.z() = 0.04 - 0.0002 * static_cast<double>(i + 1);
  }
  ContactBatch batch;
  const auto results = batch.find(pairs);
  int equal = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    ContactFinder finder;
    const ContactResult& alone = finder.find(pairs[i].a, pairs[i].b, pairs[i].settings);
    equal += !alone.points.empty() && depthOf(*results[i]) == depthOf(alone);
  }
  std::printf("%d of %zu pairs equal\n", equal, pairs.size());
  return equal == 8 ? 0 : 1;
}
