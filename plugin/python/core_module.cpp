// The module cloudcontact._core: all that the package has of C++.
#include <cloudcontact/version.h>

#include "io/errors.h"
#include "python/bindings.h"

namespace py = pybind11;

PYBIND11_MODULE(_core, module) {
  using namespace cloudcontact::python;
  module.doc() = "CloudContact's library. Use it by `import cloudcontact`.";
  module.attr("__version__") = cloudcontact::version();
  // numpy 2 has another layout of types, which pybind11 knows from 2.12 on.
  module.attr("_knows_numpy_2") = PYBIND11_VERSION_HEX >= 0x020C0000;
  py::options options;
  options.disable_function_signatures();  // _core.pyi has them
  py::register_exception_translator([](std::exception_ptr error) {
    try {
      if (error) std::rethrow_exception(error);
    } catch (const cloudcontact::program::BadInput& bad) {
      PyErr_SetString(PyExc_ValueError, bad.what());
    } catch (const py::cast_error&) {
      // pybind11's own is a RuntimeError that speaks of C++.
      PyErr_SetString(PyExc_TypeError, "an argument is of a wrong type; help() tells which fit");
    }
  });
  bindBase(module);
  bindLaw(module);
  bindMesh(module);
  bindCloud(module);
  bindField(module);
  bindContact(module);
  bindBatch(module);
  bindWorkpiece(module);
  bindHaptics(module);
  bindScene(module);
  bindWorld(module);
}
