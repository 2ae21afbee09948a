// Sums of mass properties, and principal axes of inertia.
#include <cloudcontact/base/mass_properties.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace cloudcontact {

MassProperties placed(const MassProperties& body, const Pose& place) {
  const Eigen::Matrix3d turn = place.orientation.toRotationMatrix();
  MassProperties result = body;
  result.centerOfMass = place.toWorld(body.centerOfMass);
  result.inertia = turn * body.inertia * turn.transpose();
  return result;
}

MassProperties sumOf(const std::vector<MassProperties>& parts) {
  MassProperties sum;
  for (const MassProperties& part : parts) {
    sum.volume += part.volume;
    sum.mass += part.mass;
    sum.centerOfMass += part.mass * part.centerOfMass;
  }
  sum.centerOfMass /= sum.mass;
  for (const MassProperties& part : parts) {
    const Vec3 r = part.centerOfMass - sum.centerOfMass;
    sum.inertia += part.inertia +
                   part.mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  return sum;
}

PrincipalAxes principalAxes(const Eigen::Matrix3d& inertia, const Eigen::Quaterniond& near,
                            double enough) {
  const Eigen::Matrix3d wanted = near.toRotationMatrix();
  if (enough > 0) {
    const Eigen::Matrix3d seen = wanted.transpose() * inertia * wanted;
    const Eigen::Matrix3d products = seen - Eigen::Matrix3d(seen.diagonal().asDiagonal());
    if (products.cwiseAbs().maxCoeff() <= enough * seen.diagonal().cwiseAbs().maxCoeff())
      return {near, seen.diagonal()};
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  const Eigen::Matrix3d found = solver.eigenvectors();
  Eigen::Matrix3d axes;
  Vec3 moments;
  bool taken[3] = {};
  for (int i = 0; i < 3; ++i) {
    int best = -1;
    for (int k = 0; k < 3; ++k)
      if (!taken[k] && (best < 0 || std::abs(found.col(k).dot(wanted.col(i))) >
                                        std::abs(found.col(best).dot(wanted.col(i)))))
        best = k;
    taken[best] = true;
    const double side = found.col(best).dot(wanted.col(i)) < 0 ? -1 : 1;
    axes.col(i) = side * found.col(best);
    moments[i] = solver.eigenvalues()[best];
  }
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  return {Eigen::Quaterniond(axes).normalized(), moments};
}

}  // namespace cloudcontact
