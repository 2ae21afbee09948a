// Arrays over memory of C++, and values of C++ from Python (numpy_views.h).
#include "python/numpy_views.h"

#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/workpiece/cloud_solid.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "io/options.h"

namespace cloudcontact::python {

py::dtype recordType(std::initializer_list<RecordField> fields, std::size_t size) {
  py::list names, formats, offsets;
  for (const RecordField& field : fields) {
    names.append(field.name);
    formats.append(field.format);
    offsets.append(field.offset);
  }
  return py::dtype(names, formats, offsets, static_cast<py::ssize_t>(size));
}

Numbers rowsOf(const char* what, const py::object& values, py::ssize_t columns) {
  Numbers rows = Numbers::ensure(values);
  if (!rows) {
    PyErr_Clear();
    throw std::invalid_argument(std::string(what) + ": no numbers; give an array");
  }
  if (rows.ndim() == 1 && rows.size() == columns)
    return Numbers(rows.reshape({py::ssize_t{1}, columns}));
  if (rows.ndim() != 2 || rows.shape(1) != columns)
    throw std::invalid_argument(std::string(what) + ": give an array of the shape (n, " +
                                std::to_string(columns) + ")");
  return rows;
}

Vec3 vectorOf(const char* what, const py::object& value) {
  const Numbers numbers = Numbers::ensure(value);
  if (!numbers) PyErr_Clear();
  if (!numbers || numbers.ndim() != 1 || numbers.size() != 3)
    throw std::invalid_argument(std::string(what) + ": give three numbers, x y z");
  const Vec3 vector(numbers.at(0), numbers.at(1), numbers.at(2));
  if (!vector.allFinite())
    throw std::invalid_argument(std::string(what) + ": not finite; give finite numbers");
  return vector;
}

double numberOf(const char* what, const py::object& value) {
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred()) {
    PyErr_Clear();
    throw py::type_error(std::string(what) + ": give a number, not " +
                         py::str(py::type::of(value).attr("__name__")).cast<std::string>());
  }
  return number;
}

py::array_t<double> arrayOf(const std::vector<Vec3>& vectors) {
  py::array_t<double> array({static_cast<py::ssize_t>(vectors.size()), py::ssize_t{3}});
  auto out = array.mutable_unchecked<2>();
  for (std::size_t i = 0; i < vectors.size(); ++i)
    for (int k = 0; k < 3; ++k) out(static_cast<py::ssize_t>(i), k) = vectors[i][k];
  return array;
}

Pose poseOf(const char* what, const double* row, py::ssize_t columns) {
  Pose pose;
  pose.position = Vec3(row[0], row[1], row[2]);
  if (columns == 7) pose.orientation = Eigen::Quaterniond(row[6], row[3], row[4], row[5]);
  const double length = pose.orientation.norm();
  if (!pose.position.allFinite() || !std::isfinite(length))
    throw std::invalid_argument(std::string(what) + ": not finite; give finite numbers");
  if (length < 1e-9)
    throw std::invalid_argument(std::string(what) + ": the quaternion is 0; give x y z w");
  pose.orientation.normalize();
  return pose;
}

namespace {

Pose poseOfMatrix(const char* what, const Numbers& matrix) {
  Eigen::Matrix4d m;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) m(r, c) = matrix.at(r, c);
  const Eigen::Matrix3d turn = m.topLeftCorner<3, 3>();
  if (!m.allFinite() || !(turn * turn.transpose()).isIdentity(1e-6) || turn.determinant() < 0 ||
      m.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw std::invalid_argument(std::string(what) +
                                ": the matrix does not turn and move alone; give a rigid one");
  return {Eigen::Quaterniond(turn).normalized(), m.topRightCorner<3, 1>()};
}

}  // namespace

Pose poseOf(const char* what, const py::object& value) {
  if (value.is_none()) return {};
  if (py::isinstance<Pose>(value)) return value.cast<Pose>();
  const Numbers numbers = Numbers::ensure(value);
  if (!numbers) PyErr_Clear();
  if (numbers && numbers.ndim() == 1 && (numbers.size() == 3 || numbers.size() == 7))
    return poseOf(what, numbers.data(), numbers.size());
  if (numbers && numbers.ndim() == 2 && numbers.shape(0) == 4 && numbers.shape(1) == 4)
    return poseOfMatrix(what, numbers);
  throw std::invalid_argument(std::string(what) +
                              ": give a Pose, x y z, x y z qx qy qz qw, or a matrix (4, 4)");
}

Integers integersOf(const char* what, const py::object& value) {
  const py::array array = py::array::ensure(value);
  if (!array) PyErr_Clear();
  if (!array || std::string("biuf").find(array.dtype().kind()) == std::string::npos) return {};
  // numpy cuts 0.5 to 0 and 2^32 to 0 without a word.
  if (!py::isinstance<Integers>(array)) {
    const Numbers numbers = Numbers::ensure(array);
    constexpr double kMost = std::numeric_limits<std::int32_t>::max();
    for (py::ssize_t i = 0; i < numbers.size(); ++i)
      if (const double n = numbers.data()[i]; !(std::abs(n) <= kMost && n == std::floor(n)))
        throw std::invalid_argument(std::string(what) +
                                    ": a number is not whole, or too large; give integers");
  }
  return Integers::ensure(array);
}

std::vector<Pose> posesOf(const char* what, const py::object& values) {
  const Numbers rows = Numbers::ensure(values);
  if (!rows) PyErr_Clear();
  if (!rows || rows.ndim() != 2 || (rows.shape(1) != 3 && rows.shape(1) != 7))
    throw std::invalid_argument(
        std::string(what) + ": give an array of the shape (n, 7), x y z qx qy qz qw, or (n, 3)");
  std::vector<Pose> poses;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    poses.push_back(poseOf(what, rows.data(i, 0), rows.shape(1)));
  return poses;
}

namespace {

// The first of the types that the object is of.
template <typename... Kinds>
std::optional<Solid> solidAmong(const py::object& value) {
  std::optional<Solid> solid;
  ((py::isinstance<Kinds>(value) ? (solid = value.cast<Kinds>(), true) : false) || ...);
  return solid;
}

std::optional<Solid> solidIf(const py::object& value) {
  return solidAmong<HalfSpace, Sphere, Box, Ellipsoid, Capsule, Cylinder, Cone>(value);
}

}  // namespace

bool isSolid(const py::object& value) {
  return solidIf(value).has_value();
}

Solid solidOf(const char* what, const py::object& value) {
  if (auto solid = solidIf(value)) return *solid;
  if (py::isinstance<Cloud>(value)) return cloudSolid(value.cast<Cloud>()).solid;
  throw std::invalid_argument(std::string(what) +
                              ": give a Sphere, Box, Ellipsoid, Capsule, Cylinder, Cone, HalfSpace "
                              "or Cloud");
}

PlacedSolid placedSolidOf(const char* what, const py::object& value) {
  if (py::isinstance<PlacedSolid>(value)) return value.cast<PlacedSolid>();
  return {solidOf(what, value), {}};
}

double abilityOf(double ability) {
  if (!(ability >= 0) || !std::isfinite(ability))
    throw std::invalid_argument("ability: must be 0 or more and finite");
  return ability;
}

double unitOf(const py::object& value) {
  if (py::isinstance<py::str>(value)) return program::readUnit(value.cast<std::string>());
  const double meters = numberOf("unit", value);
  if (!(meters > 0) || !std::isfinite(meters))
    throw std::invalid_argument("unit: must be a positive number of meters, or mm, cm, in, m");
  return meters;
}

}  // namespace cloudcontact::python
