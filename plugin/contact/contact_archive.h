// A contact to bytes and back (base/byte_archive.h).
#pragma once

#include <cloudcontact/contact/contact.h>

#include <cmath>
#include <stdexcept>

#include "base/byte_archive.h"

namespace cloudcontact {

template <typename Archive>
void matrixIn(Archive& archive, Eigen::Matrix2d& m) {
  archive(m(0, 0), m(0, 1), m(1, 0), m(1, 1));
}

template <typename Archive>
void patchIn(Archive& archive, Patch& p) {
  PatchTangent& t = p.tangent;
  archive(p.position, p.normal, p.depth, p.stiffness, p.damping, p.area, p.confidence, p.doubt,
          p.beside, p.firstPoint, p.points, t.along[0], t.along[1], t.middle, t.aside, t.trustA,
          t.perDepth, t.twist);
  for (Eigen::Matrix2d* m : {&t.roll, &t.tilt, &t.bend, &t.lean}) matrixIn(archive, *m);
}

template <typename Archive>
void pointIn(Archive& archive, ContactPoint& p) {
  archive(p.position, p.normal, p.depth, p.stiffness, p.slope, p.damping, p.id, p.patch);
}

inline bool isFinite(const Patch& p) {
  const PatchTangent& t = p.tangent;
  const Eigen::Matrix2d matrices = t.roll + t.tilt + t.bend + t.lean;
  const Eigen::Vector2d vectors = t.middle + t.aside;
  return p.position.allFinite() && p.normal.allFinite() && t.along[0].allFinite() &&
         t.along[1].allFinite() && matrices.allFinite() && vectors.allFinite() &&
         std::isfinite(p.depth + p.stiffness + p.damping + p.area + t.trustA + t.perDepth +
                       t.twist);
}

inline bool isFinite(const ContactPoint& p) {
  return p.position.allFinite() && p.normal.allFinite() &&
         std::isfinite(p.depth + p.stiffness + p.slope + p.damping);
}

// Throws std::runtime_error where bytes are no contact.
template <typename Archive>
void contactIn(Archive& archive, ContactResult& contact) {
  auto samples = static_cast<std::uint64_t>(contact.samples);
  archive(samples, contact.level, contact.depthError, contact.pointed);
  contact.samples = static_cast<std::size_t>(samples);
  listIn(archive, contact.patches, [](Archive& a, Patch& patch) { patchIn(a, patch); });
  listIn(archive, contact.points, [](Archive& a, ContactPoint& point) { pointIn(a, point); });
  const auto points = static_cast<std::int64_t>(contact.points.size()),
             patches = static_cast<std::int64_t>(contact.patches.size());
  for (const Patch& p : contact.patches) {
    if (p.firstPoint < 0 || p.points < 0 || std::int64_t(p.firstPoint) + p.points > points)
      throw std::runtime_error("a record has a patch without its points");
    if (!isFinite(p)) throw std::runtime_error("a record has a patch that is not finite");
  }
  for (const ContactPoint& p : contact.points) {
    if (p.patch < 0 || p.patch >= patches)
      throw std::runtime_error("a record has a contact point of no patch");
    if (!isFinite(p)) throw std::runtime_error("a record has a contact point that is not finite");
  }
}

}  // namespace cloudcontact
