// Python: poses and mass properties.
#include <cloudcontact/base/mass_properties.h>

#include <sstream>

#include "python/bindings.h"
#include "python/numpy_views.h"

namespace cloudcontact::python {
namespace {

// Points (..., 3), each by `move`, in an array of the same shape.
template <typename Move>
py::array_t<double> pointsBy(const char* what, const Numbers& points, const Move& move) {
  if (points.ndim() < 1 || points.shape(points.ndim() - 1) != 3)
    throw std::invalid_argument(std::string(what) + ": give points (3,) or (..., 3)");
  py::array_t<double> made(
      std::vector<py::ssize_t>(points.shape(), points.shape() + points.ndim()));
  const double* from = points.data();
  double* to = made.mutable_data();
  for (py::ssize_t i = 0; i < points.size(); i += 3)
    Eigen::Map<Vec3>(to + i) = move(Eigen::Map<const Vec3>(from + i));
  return made;
}

}  // namespace

void bindBase(py::module_& module) {
  using namespace py::literals;
  py::class_<Pose>(module, "Pose",
                   "A rigid transform, world = orientation * local + position.\n\n"
                   "Where a pose is asked for, three numbers (a position [m]), seven numbers\n"
                   "(x y z qx qy qz qw) or a matrix (4, 4) do as well.")
      .def(py::init([](const py::object& position, const py::object& orientation) {
             Pose pose = poseOf("position", position);
             if (orientation.is_none()) return pose;
             const Numbers q = rowsOf("orientation", orientation, 4);
             if (q.shape(0) != 1)
               throw std::invalid_argument("orientation: give one quaternion, x y z w");
             const double row[7] = {pose.position.x(), pose.position.y(), pose.position.z(),
                                    q.at(0, 0),        q.at(0, 1),        q.at(0, 2),
                                    q.at(0, 3)};
             return poseOf("orientation", row, 7);
           }),
           "position"_a = py::none(), "orientation"_a = py::none(),
           "position: [m], or all that a pose may be given by. orientation: quaternion x y z w,\n"
           "which is normalized. Raises ValueError where a number is not finite.")
      .def_static(
          "from_rotation_vector",
          [](const py::object& rotation, const py::object& position) {
            const Vec3 turn = vectorOf("turn", rotation);
            const double angle = turn.norm();
            Pose pose;
            if (angle > 0) pose.orientation = Eigen::AngleAxisd(angle, turn / angle);
            if (!position.is_none()) pose.position = vectorOf("position", position);
            return pose;
          },
          "turn"_a, "position"_a = py::none(),
          "A pose turned by |turn| [rad] about the axis `turn`, at `position` [m].")
      .def_property_readonly("position", copied(&Pose::position), "Array (3,) [m].")
      .def_property_readonly(
          "orientation", [](const Pose& p) { return Eigen::Vector4d(p.orientation.coeffs()); },
          "Quaternion x y z w, array (4,).")
      .def_property_readonly(
          "matrix",
          [](const Pose& p) {
            Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
            m.topLeftCorner<3, 3>() = p.orientation.toRotationMatrix();
            m.topRightCorner<3, 1>() = p.position;
            return m;
          },
          "Array (4, 4).")
      .def(
          "to_world",
          [](const Pose& pose, const Numbers& local) {
            return pointsBy("local", local, [&](const Vec3& x) { return pose.toWorld(x); });
          },
          "local"_a, "Points of the frame in the world, (3,) or (..., 3) [m].")
      .def(
          "to_local",
          [](const Pose& pose, const Numbers& world) {
            return pointsBy("world", world, [&](const Vec3& x) { return pose.toLocal(x); });
          },
          "world"_a, "Points of the world in the frame, (3,) or (..., 3) [m].")
      .def("inverse", &Pose::inverse, "The pose of the world in this frame.")
      .def(
          "__matmul__", [](const Pose& a, const Pose& b) { return a * b; }, "inner"_a,
          "The world's pose of `inner`, which is given in this frame.")
      .def(py::pickle(
          [](const Pose& p) {
            return py::make_tuple(p.position, Eigen::Vector4d(p.orientation.coeffs()));
          },
          [](const py::tuple& parts) {
            Pose pose;
            pose.position = parts[0].cast<Vec3>();
            pose.orientation.coeffs() = parts[1].cast<Eigen::Vector4d>();
            return pose;
          }))
      .def("__repr__", [](const Pose& p) {
        std::ostringstream text;
        const auto& q = p.orientation;
        text << "Pose(position=(" << p.position.x() << ", " << p.position.y() << ", "
             << p.position.z() << "), orientation=(" << q.x() << ", " << q.y() << ", " << q.z()
             << ", " << q.w() << "))";
        return text.str();
      });

  py::class_<MassProperties>(module, "MassProperties",
                             "Mass, center of mass and inertia, in the body's frame.")
      .def_readonly("volume", &MassProperties::volume, "[m^3]")
      .def_readonly("mass", &MassProperties::mass, "[kg]")
      .def_property_readonly("center_of_mass", copied(&MassProperties::centerOfMass),
                             "Array (3,) [m].")
      .def_property_readonly("inertia", copied(&MassProperties::inertia),
                             "About the center of mass, array (3, 3) [kg m^2].")
      .def("__repr__", [](const MassProperties& m) {
        std::ostringstream text;
        text << "MassProperties(volume=" << m.volume << ", mass=" << m.mass << ")";
        return text.str();
      });
}

}  // namespace cloudcontact::python
