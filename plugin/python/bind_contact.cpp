// Python: the contact of two bodies.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/contact/depth_error.h>

#include "python/bindings.h"
#include "python/contact_values.h"
#include "python/turns.h"
#include "python/unlocked.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;

OwnedBody makeBody(const py::object& shape, const py::object& pose, const py::object& velocity,
                   const py::object& angularVelocity, std::optional<TissueTable> tissues,
                   std::optional<KelvinVoigt> spring, std::optional<PaperBody> paper,
                   const py::object& pivot, double inverseInertia) {
  OwnedBody body = bodyFrom("shape", shape);
  body.pose = poseOf("pose", pose);
  if (!velocity.is_none()) body.linear = vectorOf("velocity", velocity);
  if (!angularVelocity.is_none()) body.angular = vectorOf("angular_velocity", angularVelocity);
  if (tissues) {
    validate(*tissues);
    const std::size_t most =
        body.field ? std::max<std::size_t>(1, body.field->cloud().materials().size()) : 1;
    if (!body.field || (tissues->size() != 1 && tissues->size() != most))
      throw std::invalid_argument(
          "tissues: give one for each material of the field's cloud, or one");
    body.tissues = std::move(tissues);
  }
  body.spring = spring;
  body.paper = std::move(paper);
  if (!pivot.is_none()) body.pivot = vectorOf("pivot", pivot);
  if (!(inverseInertia >= 0) || !std::isfinite(inverseInertia))
    throw std::invalid_argument("inverse_inertia: must be 0 or more and finite");
  body.inverseInertia = inverseInertia;
  return body;
}

FoundContact findContact(ContactFinder& finder, const py::object& first, const py::object& second,
                         const Law& law, double margin, std::size_t samples) {
  const OwnedBody one = bodyFrom("a", first), two = bodyFrom("b", second);
  const ContactSettings settings = settingsFrom(law, margin, samples);
  const Turn turn(&finder);
  const Unlocked unlocked;
  const ContactBody a = one.view(), b = two.view();
  FoundContact found;
  found.result = finder.find(a, b, settings);
  found.onB = wrenchOnB(found.result, a.motion, b.motion);
  found.depth = depthOf(found.result);
  found.depthError = depthError(a, b, found.result);
  return found;
}

void bindBody(py::module_& module) {
  py::class_<OwnedBody>(module, "ContactBody", "One body of a pair: its shape, place and motion.")
      .def(
          py::init(&makeBody), "shape"_a, "pose"_a = py::none(), "velocity"_a = py::none(),
          "angular_velocity"_a = py::none(), "tissues"_a = py::none(), "spring"_a = py::none(),
          "paper"_a = py::none(), "pivot"_a = py::none(), "inverse_inertia"_a = 1.0,
          "shape: a SurfaceField or a solid; not both bodies may be solids. pose: where it is.\n"
          "velocity: of its frame's origin (3,) [m/s]. angular_velocity: (3,) [rad/s]. tissues:\n"
          "one for each material, or one; they replace the law's stiffness and damping. spring: a\n"
          "KelvinVoigt of a body without tissues beside one with; none: rigid. paper: a\n"
          "PaperBody, whose base vectors then give the direction; none: nothing is stated. pivot:\n"
          "what contacts turn it about, in its frame (3,) [m]; none: its origin. inverse_inertia:\n"
          "how easily they do, over the other body's; 0: not at all, as what is fixed.")
      .def_property(
          "pose", [](const OwnedBody& b) { return b.pose; },
          [](OwnedBody& b, const py::object& pose) { b.pose = poseOf("pose", pose); },
          "Where it is: a Pose.")
      .def_property(
          "velocity", [](const OwnedBody& b) { return b.linear; },
          [](OwnedBody& b, const py::object& v) { b.linear = vectorOf("velocity", v); },
          "(3,) [m/s]")
      .def_property(
          "angular_velocity", [](const OwnedBody& b) { return b.angular; },
          [](OwnedBody& b, const py::object& v) { b.angular = vectorOf("angular_velocity", v); },
          "(3,) [rad/s]");
}

void bindResult(py::module_& module) {
  using ContactPtr = std::shared_ptr<FoundContact>;
  py::class_<FoundContact, ContactPtr>(
      module, "Contact", "What ContactFinder finds. False where the bodies do not touch.")
      .def_property_readonly(
          "points",
          [](const ContactPtr& f) { return recordsOf(pointType(), f->result.points, keeping(f)); },
          "Contact points, a structured array (n,): position (3,) midway between the surfaces\n"
          "[m], normal (3,) from A to B, depth [m], positive inside, stiffness [N/m] and damping\n"
          "[N s/m] of the point's share, id, the same from call to call, patch: index into\n"
          "`patches`.")
      .def_property_readonly(
          "patches",
          [](const ContactPtr& f) { return recordsOf(patchType(), f->result.patches, keeping(f)); },
          "Areas of contact, a structured array (m,): position (3,) of the pressure's center [m],\n"
          "normal (3,) from A to B, depth [m], stiffness [N/m], damping [N s/m], area [m^2],\n"
          "confidence 0..1, doubt (0 none, 1 few samples, 2 opposed, 3 deep), first_point, points.")
      .def_property_readonly(
          "force", [](const FoundContact& f) { return f.onB.force; }, "Of the law on B, (3,) [N].")
      .def_property_readonly(
          "torque", [](const FoundContact& f) { return f.onB.torque; },
          "On B about the world's origin, (3,) [N m].")
      .def_readonly("depth", &FoundContact::depth, "The pair's [m]; negative: a gap.")
      .def_readonly("depth_error", &FoundContact::depthError,
                    "The depth is right to this in 95 % of poses [m].")
      .def_property_readonly(
          "samples", [](const FoundContact& f) { return f.result.samples; },
          "Samples of either body that lie in the other.")
      .def("__len__", [](const FoundContact& f) { return f.result.points.size(); })
      .def("__bool__", [](const FoundContact& f) { return !f.result.points.empty(); })
      .def("__repr__", [](const FoundContact& f) {
        return "Contact(" + std::to_string(f.result.points.size()) + " points in " +
               std::to_string(f.result.patches.size()) + " patches)";
      });
}

}  // namespace

void bindContact(py::module_& module) {
  py::class_<PaperBody>(module, "PaperBody", "What a body states of base vectors.")
      .def(py::init([](const Cloud& cloud, const TissueTable& tissues, const py::object& area,
                       bool hardness, double ability) {
             PaperSettings settings;
             if (!area.is_none()) settings.area = placedSolidOf("area", area);
             settings.hardness = hardness;
             settings.ability = abilityOf(ability);
             const Unlocked unlocked;
             return paperBody(cloud, tissues, settings);
           }),
           "cloud"_a, "tissues"_a = TissueTable(), "area"_a = py::none(), "hardness"_a = true,
           "ability"_a = 1.0,
           "cloud: that of the body's field. tissues: of its materials. area: D, a solid in the\n"
           "body's frame; none: the whole body. hardness: h in (5'). ability: to cut.");
  bindBody(module);
  bindResult(module);
  py::class_<ContactFinder>(
      module, "ContactFinder",
      "Finds the contacts of one pair, call by call. It keeps the points' ids and lists between\n"
      "calls.")
      .def(py::init<>())
      .def(
          "find", &findContact, "a"_a, "b"_a, py::kw_only(), "law"_a = KelvinVoigt{1e4, 0},
          "margin"_a = 0.0, "samples"_a = ContactSettings::kSamples,
          "The Contact of two bodies, each a ContactBody, or a SurfaceField or solid at the\n"
          "origin.\n\n"
          "law: KelvinVoigt, Foundation ...; its k and c are shared out among the points. margin:\n"
          "bodies nearer than this get points with a negative depth [m]. samples: hits that a\n"
          "search looks for. Raises ValueError where both bodies are solids or a pose is not "
          "finite.");
}

}  // namespace cloudcontact::python
