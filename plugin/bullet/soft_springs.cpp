// Backward Euler as a minimum: the places at the step's end minimize
//
//   sum m |x - free|^2 / 2 + h^2 sum (k (l - L)^2 / 2 + c (l - before)^2 / (2 h))
//
// over nodes and links, l a link's length. Newton's method finds it. The change of a link's
// direction counts where the link is stretched only, so each system is positive definite, and a
// step that would raise the sum is halved. The systems are solved by conjugate gradients,
// preconditioned by each node's own block. Forces act along links at the places at the step's end:
// pairs of equal and opposite ones, so linear momentum is kept. What little of it is lost where
// a system is not solved to the last bit is given back to each piece as a whole.
#include "bullet/soft_springs.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

constexpr int kMostNewton = 8, kMostGradients = 400, kMostHalvings = 12;
constexpr double kSolved = 1e-5;   // residual of a system relative to its right side
constexpr double kSettled = 1e-9;  // [cells] change of the places at which Newton stops

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

double dotOf(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

}  // namespace

double SoftSprings::energy(const std::vector<SoftLink>& links,
                           const std::vector<SoftNode>& nodes) const {
  double sum = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i].inverseMass > 0)
      sum += (nodes[i].place - free_[i]).squaredNorm() / nodes[i].inverseMass;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const SoftLink& link = links[k];
    const double length = (nodes[at(link.b)].place - nodes[at(link.a)].place).norm();
    const double stretch = length - link.length, late = length - before_[k];
    sum += square_ * link.stiffness * stretch * stretch + step_ * link.damping * late * late;
  }
  return 0.5 * sum;
}

// The gradient's negative in residual_, and the rows and blocks of the second derivative.
void SoftSprings::linearize(const std::vector<SoftLink>& links,
                            const std::vector<SoftNode>& nodes) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double mass = nodes[i].inverseMass > 0 ? 1 / nodes[i].inverseMass : 0;
    residual_[i] = mass * (free_[i] - nodes[i].place);
    inverse_[i] = mass * Eigen::Matrix3d::Identity();
  }
  for (std::size_t k = 0; k < links.size(); ++k) {
    const SoftLink& link = links[k];
    const Vec3 way = nodes[at(link.b)].place - nodes[at(link.a)].place;
    const double length = way.norm();
    Row& row = rows_[k];
    row.along = length > 0 ? Vec3(way / length) : Vec3::UnitX();
    const double pull = square_ * link.stiffness * (length - link.length) +
                        step_ * link.damping * (length - before_[k]);
    row.stiff = square_ * link.stiffness + step_ * link.damping;
    row.turn = length > 0 ? std::max(0.0, pull / length) : 0;
    residual_[at(link.a)] += pull * row.along;
    residual_[at(link.b)] -= pull * row.along;
    const Eigen::Matrix3d block = (row.stiff - row.turn) * row.along * row.along.transpose() +
                                  row.turn * Eigen::Matrix3d::Identity();
    inverse_[at(link.a)] += block;
    inverse_[at(link.b)] += block;
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].inverseMass > 0) {
      inverse_[i] = inverse_[i].inverse().eval();
    } else {
      inverse_[i].setZero();
      residual_[i].setZero();
    }
  }
}

// image_ = the second derivative times direction_.
void SoftSprings::multiply(const std::vector<SoftLink>& links, const std::vector<SoftNode>& nodes) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    image_[i] =
        nodes[i].inverseMass > 0 ? Vec3(direction_[i] / nodes[i].inverseMass) : Vec3(Vec3::Zero());
  for (std::size_t k = 0; k < links.size(); ++k) {
    const Row& row = rows_[k];
    const int a = links[k].a, b = links[k].b;
    const Vec3 way = direction_[at(b)] - direction_[at(a)];
    const Vec3 pull = row.turn * way + (row.stiff - row.turn) * row.along.dot(way) * row.along;
    image_[at(a)] -= pull;
    image_[at(b)] += pull;
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!(nodes[i].inverseMass > 0)) image_[i].setZero();
}

// change_ = Newton's step.
void SoftSprings::solve(const std::vector<SoftLink>& links, const std::vector<SoftNode>& nodes) {
  const std::size_t count = nodes.size();
  for (std::size_t i = 0; i < count; ++i) {
    change_[i].setZero();
    scaled_[i] = inverse_[i] * residual_[i];
    direction_[i] = scaled_[i];
  }
  double now = dotOf(residual_, scaled_);
  const double enough = kSolved * kSolved * now;
  for (int k = 0; k < kMostGradients && now > enough; ++k) {
    multiply(links, nodes);
    const double step = now / dotOf(direction_, image_);
    for (std::size_t i = 0; i < count; ++i) {
      change_[i] += step * direction_[i];
      residual_[i] -= step * image_[i];
      scaled_[i] = inverse_[i] * residual_[i];
    }
    const double next = dotOf(residual_, scaled_);
    for (std::size_t i = 0; i < count; ++i) direction_[i] = scaled_[i] + next / now * direction_[i];
    now = next;
  }
}

// Moves the nodes by change_, or by as much of it as lowers the sum. False: nothing does.
bool SoftSprings::advance(const std::vector<SoftLink>& links, std::vector<SoftNode>& nodes) {
  const double before = energy(links, nodes);
  double part = 1;
  for (int k = 0; k < kMostHalvings; ++k, part /= 2) {
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i].place += part * change_[i];
    if (energy(links, nodes) <= before) return true;
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i].place -= part * change_[i];
  }
  return false;
}

void SoftSprings::keepMomentum(const std::vector<int>& pieces, std::vector<SoftNode>& nodes) {
  const auto count = static_cast<std::size_t>(*std::max_element(pieces.begin(), pieces.end())) + 1;
  astray_.assign(count, Vec3::Zero());
  heavy_.assign(count, 0.0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double mass = nodes[i].inverseMass > 0 ? 1 / nodes[i].inverseMass : HUGE_VAL;
    heavy_[at(pieces[i])] += mass;
    if (nodes[i].inverseMass > 0) astray_[at(pieces[i])] += mass * (free_[i] - nodes[i].place);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i].inverseMass > 0) nodes[i].place += astray_[at(pieces[i])] / heavy_[at(pieces[i])];
}

void SoftSprings::step(const std::vector<SoftLink>& links, const std::vector<int>& pieces,
                       std::vector<SoftNode>& nodes, double seconds) {
  step_ = seconds;
  square_ = seconds * seconds;
  const std::size_t count = nodes.size();
  before_.resize(links.size());
  rows_.resize(links.size());
  inverse_.resize(count);
  for (auto* all : {&free_, &residual_, &change_, &direction_, &image_, &scaled_})
    all->resize(count);
  double shortest = HUGE_VAL;
  for (std::size_t k = 0; k < links.size(); ++k) {
    before_[k] = (nodes[at(links[k].b)].start - nodes[at(links[k].a)].start).norm();
    shortest = std::min(shortest, links[k].length);
  }
  for (std::size_t i = 0; i < count; ++i) free_[i] = nodes[i].place;
  for (int k = 0; k < kMostNewton; ++k) {
    linearize(links, nodes);
    missed_ = 0;
    for (std::size_t i = 0; i < count; ++i)
      missed_ = std::max(missed_, (inverse_[i] * residual_[i]).norm());
    if (!(missed_ > kSettled * shortest)) break;
    solve(links, nodes);
    if (!advance(links, nodes)) break;
  }
  keepMomentum(pieces, nodes);
}

}  // namespace cloudcontact
