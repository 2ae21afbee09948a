// Halves along the widest axis.
#include "field/ball_tree.h"

#include "field/field_data.h"
#include "kernels/contact/search.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace cloudcontact {

namespace {

static_assert(kLevels == 3, "a cell of the coarsest level holds samples of the middle one");

}  // namespace

// Of the finest samples below a run of the middle level, where each sample has a cell of its own.
BallTree::Ball BallTree::ballOf(const SampleSet& samples, const SampleRun& ofMiddle) {
  const SampleLevel &middle = samples.levels[1], &finest = samples.levels[0];
  const auto each = [&](const auto& visit) {
    for (std::uint32_t i = ofMiddle.first; i < ofMiddle.first + ofMiddle.count; ++i) {
      const SampleRun run = middle.finer[middle.cellOf[i]];
      for (std::uint32_t k = run.first; k < run.first + run.count; ++k)
        visit(Eigen::Vector3f(finest.samples.x[k], finest.samples.y[k], finest.samples.z[k]),
              finest.samples.width[k]);
    }
  };
  Eigen::AlignedBox3f box;
  each([&](const Eigen::Vector3f& x, float) { box.extend(x); });
  Ball ball{box.center(), 0};
  each([&](const Eigen::Vector3f& x, float width) {
    ball.radius = std::max(ball.radius, (x - ball.center).norm() + CC_HALF_DIAGONAL * width);
  });
  return ball;
}

BallTree::BallTree(const SampleSet& samples) {
  std::vector<Ball> leaves;
  for (const SampleRun& run : samples.levels[kLevels - 1].finer)
    if (run.count > 0) leaves.push_back(ballOf(samples, run));
  if (leaves.empty()) return;
  nodes_.reserve(2 * leaves.size() - 1);
  divide(leaves.data(), leaves.data() + leaves.size());
}

void BallTree::divide(Ball* first, Ball* last) {
  const std::size_t at = nodes_.size();
  Eigen::AlignedBox3f box;
  for (const Ball* ball = first; ball != last; ++ball) box.extend(ball->center);
  Node& node = nodes_.emplace_back();
  node.center = box.center();
  node.far = 0;
  node.radius = 0;
  for (const Ball* ball = first; ball != last; ++ball)
    node.radius = std::max(node.radius, (ball->center - node.center).norm() + ball->radius);
  if (last - first == 1) return;
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  Ball* const middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [axis](const Ball& x, const Ball& y) {
    return x.center[axis] < y.center[axis];
  });
  divide(first, middle);
  nodes_[at].far = static_cast<std::uint32_t>(nodes_.size());
  divide(middle, last);
}

const BallTree& ballTree(const FieldData& field) {
  LazyBallTree& lazy = field.lazyBalls();
  std::call_once(lazy.once, [&] { lazy.made = std::make_shared<const BallTree>(field.samples()); });
  return *lazy.made;
}

}  // namespace cloudcontact
