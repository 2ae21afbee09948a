// Exceptions of C++ in Python (raised_errors.h).
#include "python/raised_errors.h"

#include <new>
#include <stdexcept>

#include "io/errors.h"
#include "python/python_words.h"

namespace cloudcontact::python {
namespace {

void raise(PyObject* kind, const std::exception& thrown) {
  PyErr_SetObject(kind, textOf(inPython(thrown.what())).ptr());
}

// Those of the standard library as pybind11 maps them.
void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const py::cast_error&) {
    PyErr_SetString(PyExc_TypeError, "an argument is of a wrong type; help() tells which fit");
  } catch (const py::error_already_set&) {
    throw;
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const program::BadInput& e) {
    raise(PyExc_ValueError, e);
  } catch (const std::domain_error& e) {
    raise(PyExc_ValueError, e);
  } catch (const std::invalid_argument& e) {
    raise(PyExc_ValueError, e);
  } catch (const std::length_error& e) {
    raise(PyExc_ValueError, e);
  } catch (const std::range_error& e) {
    raise(PyExc_ValueError, e);
  } catch (const std::out_of_range& e) {
    raise(PyExc_IndexError, e);
  } catch (const std::overflow_error& e) {
    raise(PyExc_OverflowError, e);
  } catch (const std::bad_alloc& e) {
    raise(PyExc_MemoryError, e);
  } catch (const std::exception& e) {
    raise(PyExc_RuntimeError, e);
  }
}

}  // namespace

py::str textOf(const std::string& text) {
  PyObject* made =
      PyUnicode_DecodeFSDefaultAndSize(text.data(), static_cast<py::ssize_t>(text.size()));
  if (!made) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(made);
}

void registerErrors() {
  py::register_exception_translator(&translate);
}

}  // namespace cloudcontact::python
