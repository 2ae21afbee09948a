// The bodies and the results of contacts, as Python holds them (contact_values.h).
#include "python/contact_values.h"

#include <stdexcept>

namespace cloudcontact::python {

ContactBody OwnedBody::view() const {
  ContactBody body;
  body.field = field.get();
  body.shape = shape ? &*shape : nullptr;
  body.pose = pose;
  body.motion = motion();
  body.tissues = tissues ? &*tissues : nullptr;
  body.spring = spring;
  body.paper = paper ? &*paper : nullptr;
  body.pivot = pivot;
  body.inverseInertia = inverseInertia;
  return body;
}

OwnedBody bodyFrom(const char* what, const py::object& value) {
  if (py::isinstance<OwnedBody>(value)) return value.cast<OwnedBody>();
  OwnedBody body;
  if (py::isinstance<SurfaceField>(value))
    body.field = value.cast<std::shared_ptr<SurfaceField>>();
  else if (isSolid(value))
    body.shape = solidOf(what, value);
  else
    throw std::invalid_argument(std::string(what) +
                                ": give a SurfaceField, a solid or a ContactBody");
  return body;
}

ContactSettings settingsFrom(const Law& law, double margin, std::size_t samples) {
  validate(law);
  if (std::holds_alternative<Maxwell>(law) || std::holds_alternative<StandardLinearSolid>(law))
    throw std::invalid_argument(
        "law: this one has a memory, which a single contact has not; run a "
        "World, or give KelvinVoigt, Foundation or Rigid");
  if (!(margin >= 0) || !std::isfinite(margin))
    throw std::invalid_argument("margin: must be 0 or more and finite");
  if (samples < 1) throw std::invalid_argument("samples: must be 1 or more");
  ContactSettings settings;
  settings.law = law;
  settings.margin = margin;
  settings.samples = samples;
  return settings;
}

py::dtype pointType() {
  return recordType({{"position", "(3,)f8", offsetOf(&ContactPoint::position)},
                     {"normal", "(3,)f8", offsetOf(&ContactPoint::normal)},
                     {"depth", "f8", offsetOf(&ContactPoint::depth)},
                     {"stiffness", "f8", offsetOf(&ContactPoint::stiffness)},
                     {"damping", "f8", offsetOf(&ContactPoint::damping)},
                     {"id", "u4", offsetOf(&ContactPoint::id)},
                     {"patch", "i4", offsetOf(&ContactPoint::patch)}},
                    sizeof(ContactPoint));
}

py::dtype patchType() {
  return recordType({{"position", "(3,)f8", offsetOf(&Patch::position)},
                     {"normal", "(3,)f8", offsetOf(&Patch::normal)},
                     {"depth", "f8", offsetOf(&Patch::depth)},
                     {"stiffness", "f8", offsetOf(&Patch::stiffness)},
                     {"damping", "f8", offsetOf(&Patch::damping)},
                     {"area", "f8", offsetOf(&Patch::area)},
                     {"confidence", "f8", offsetOf(&Patch::confidence)},
                     {"doubt", "u1", offsetOf(&Patch::doubt)},
                     {"first_point", "i4", offsetOf(&Patch::firstPoint)},
                     {"points", "i4", offsetOf(&Patch::points)}},
                    sizeof(Patch));
}

}  // namespace cloudcontact::python
