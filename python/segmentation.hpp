#pragma once
#include <pybind11/pybind11.h>

/// Private to the Python module: unknown objects on a table.
namespace stonestack::python {

/// Adds `segment` and its result to the module.
void add_segmentation(pybind11::module_& module);

}  // namespace stonestack::python
