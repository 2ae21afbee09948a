// The module cloudcontact._core: all that the package has of C++.
#include <cloudcontact/version.h>

#include "python/bindings.h"
#include "python/raised_errors.h"
#include "python/unlocked.h"

namespace py = pybind11;

PYBIND11_MODULE(_core, module) {
  using namespace cloudcontact::python;
  module.doc() = "CloudContact's library. Use it by `import cloudcontact`.";
  module.attr("__version__") = cloudcontact::version();
  // numpy 2 has another layout of types, which pybind11 knows from 2.12 on.
  module.attr("_knows_numpy_2") = PYBIND11_VERSION_HEX >= 0x020C0000;
  py::options options;
  options.disable_function_signatures();  // _core.pyi has them
  waitAtExit();
  registerErrors();
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
  bindWorlds(module);
}
