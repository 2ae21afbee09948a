// The bodies and the results of contacts, as Python holds them.
#pragma once

#include <cloudcontact/contact/contact.h>
#include <cloudcontact/contact/paper_body.h>

#include <memory>
#include <optional>
#include <vector>

#include "python/numpy_views.h"

namespace cloudcontact::python {

// A ContactBody that owns what it points to.
struct OwnedBody {
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> shape;
  Pose pose;
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  std::optional<TissueTable> tissues;
  std::optional<KelvinVoigt> spring;
  std::optional<PaperBody> paper;
  Vec3 pivot = Vec3::Zero();
  double inverseInertia = 1;

  Motion motion() const { return {linear, angular, pose.position}; }
  // Valid as long as this.
  ContactBody view() const;
};

// From a SurfaceField or a solid, or an OwnedBody.
OwnedBody bodyFrom(const char* what, const py::object& value);

// A result that outlives the finder's memory.
struct FoundContact {
  ContactResult result;
  Wrench onB;  // torque about the world's origin
  double depth = 0, depthError = 0;
};

ContactSettings settingsFrom(const Law& law, double margin, std::size_t samples);

// numpy's types of the records.
py::dtype pointType();
py::dtype patchType();

}  // namespace cloudcontact::python
