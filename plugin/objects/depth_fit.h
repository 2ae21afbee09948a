// PixelFit: a least-squares quadratic over the columns and rows of pixels, for filling and
// smoothing depth images.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace cloudcontact {

// Fits `Values` numbers at once over the same pixels.
template <int Values>
class PixelFit {
 public:
  static constexpr int kTerms = 6;  // 1 x y xx xy yy
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using Row = Eigen::Matrix<double, 1, Values>;

  void add(double x, double y, const Row& value, double weight = 1) {
    const Terms t = terms(x, y);
    a_ += weight * t * t.transpose();
    b_ += weight * t * value;
    ++count_;
  }
  int count() const { return count_; }
  // Call after the last add(). Fits a plane to fewer than 9 pixels, a mean to fewer than 4.
  void solve() {
    const int n = count_ >= 9 ? 6 : count_ >= 4 ? 3 : 1;
    a_.diagonal().array() += 1e-9 * a_(0, 0);
    q_.setZero();
    q_.topRows(n) = a_.topLeftCorner(n, n).ldlt().solve(b_.topRows(n));
  }
  Row at(double x, double y) const { return terms(x, y).transpose() * q_; }

 private:
  static Terms terms(double x, double y) {
    Terms t;
    t << 1, x, y, x * x, x * y, y * y;
    return t;
  }
  Eigen::Matrix<double, kTerms, kTerms> a_ = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  Eigen::Matrix<double, kTerms, Values> b_ = Eigen::Matrix<double, kTerms, Values>::Zero();
  Eigen::Matrix<double, kTerms, Values> q_ = Eigen::Matrix<double, kTerms, Values>::Zero();
  int count_ = 0;
};

}  // namespace cloudcontact
