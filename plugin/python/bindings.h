// The parts of the module cloudcontact._core. Each function adds the classes and functions of its
// subject; those that others use come first.
#pragma once

#include <pybind11/pybind11.h>

namespace cloudcontact::python {

void bindBase(pybind11::module_& module);       // poses, mass properties
void bindLaw(pybind11::module_& module);        // laws, tissues, solids
void bindMesh(pybind11::module_& module);       // meshes
void bindCloud(pybind11::module_& module);      // clouds, digitizing, CT volumes
void bindField(pybind11::module_& module);      // surface fields
void bindContact(pybind11::module_& module);    // contacts of two bodies
void bindBatch(pybind11::module_& module);      // contacts of many pairs
void bindWorkpiece(pybind11::module_& module);  // base vectors, collisions, cutting
void bindHaptics(pybind11::module_& module);    // the haptic loop
void bindScene(pybind11::module_& module);      // scenes: bodies and joints
void bindWorld(pybind11::module_& module);      // running worlds
void bindWorlds(pybind11::module_& module);     // many of one scene

}  // namespace cloudcontact::python
