// Arrays of numpy over memory of C++, and values of C++ from what Python passes.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/law/law.h>
#include <cloudcontact/law/solid.h>

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

namespace cloudcontact::python {

namespace py = pybind11;

// Rows of numbers that Python passes; other types of number are converted, which copies them.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Integers = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

// Whole numbers of any type; empty where `value` is no array of numbers. Throws
// std::invalid_argument, naming `what`, where a number is not whole or does not fit.
Integers integersOf(const char* what, const py::object& value);

// A Python object that keeps a value alive.
template <typename Value>
py::object keeping(Value value) {
  return py::capsule(new Value(std::move(value)), [](void* p) { delete static_cast<Value*>(p); });
}

// Reads a member, or what a function without arguments returns, as a value of Python's own; of
// references pybind11 makes arrays over the object's memory.
template <typename Value, typename Class>
auto copied(Value Class::*member) {
  return [member](const Class& object) {
    return std::decay_t<decltype(std::invoke(member, object))>(std::invoke(member, object));
  };
}

// An array over memory that lives as long as `owner` does. Strides in bytes.
template <typename Number>
py::array viewOf(const Number* data, std::vector<py::ssize_t> shape,
                 std::vector<py::ssize_t> strides, const py::object& owner, bool writable = false) {
  py::array array(py::dtype::of<Number>(), std::move(shape), std::move(strides), data, owner);
  if (!writable) array.attr("setflags")(py::arg("write") = false);
  return array;
}

// A field of a record: its numpy format and where it is in the record.
struct RecordField {
  const char* name;
  const char* format;
  std::size_t offset;
};
py::dtype recordType(std::initializer_list<RecordField> fields, std::size_t size);
// Records of C++ as an array that nobody may write to.
template <typename Record>
py::array recordsOf(const py::dtype& type, const std::vector<Record>& records,
                    const py::object& owner) {
  py::array array(type, {static_cast<py::ssize_t>(records.size())}, {type.itemsize()},
                  records.data(), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

// Where a member is in its object.
template <typename Object, typename Member>
std::size_t offsetOf(Member Object::*member) {
  static const Object object{};
  return static_cast<std::size_t>(reinterpret_cast<const char*>(&(object.*member)) -
                                  reinterpret_cast<const char*>(&object));
}

// Rows of `columns` numbers, as (n, columns), or one row as (columns,). Throws
// std::invalid_argument that begins with `what`.
Numbers rowsOf(const char* what, const py::object& values, py::ssize_t columns);
// Three finite numbers. Throws std::invalid_argument that begins with `what`.
Vec3 vectorOf(const char* what, const py::object& value);
// A number of Python or numpy. Throws TypeError that begins with `what`.
double numberOf(const char* what, const py::object& value);
// A copy of vectors as an array (n, 3).
py::array_t<double> arrayOf(const std::vector<Vec3>& vectors);

// A Pose, three numbers (a position), seven (position, then quaternion x y z w), a matrix (4, 4),
// or None. Throws std::invalid_argument that begins with `what`.
Pose poseOf(const char* what, const py::object& value);
Pose poseOf(const char* what, const double* row, py::ssize_t columns);
// Poses as rows of three or seven numbers.
std::vector<Pose> posesOf(const char* what, const py::object& values);

// A solid of Python, a Cloud, or a PlacedSolid. Throws std::invalid_argument that begins with
// `what`.
Solid solidOf(const char* what, const py::object& value);
PlacedSolid placedSolidOf(const char* what, const py::object& value);
bool isSolid(const py::object& value);

// The ability to cut of (5'): finite, 0 or more. Throws std::invalid_argument.
double abilityOf(double ability);

// Meters of a unit: a name, or meters per unit. Throws ValueError as the program does.
double unitOf(const py::object& value);

}  // namespace cloudcontact::python
