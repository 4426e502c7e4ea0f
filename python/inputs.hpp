#pragma once
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/experiment/option_sources.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/scene_file.hpp"

/// Private to the Python module: arguments that several functions take.
namespace stonestack::python {

using CataloguePtr = std::shared_ptr<stone::Catalogue>;

/// A catalogue, its folder, or None for the stones that come with stonestack.
/// @throws FileError.
[[nodiscard]] CataloguePtr catalogue_of(const pybind11::object& given);

/// Sets options from where the command takes them (files, environment), then `seed`, the arguments that are
/// `flags` of the command, and `options`.
/// @throws FileError, InvalidArgument.
void set_options(const core::FieldList& list, std::optional<int> seed, const pybind11::dict& options,
                 const std::vector<experiment::FlagValue>& flags = {});

/// A list of names, or one text with commas between; None: empty.
[[nodiscard]] std::vector<std::string> names_of(const pybind11::object& given);

/// One scene or a list of scenes, each a path or a DepthImage, with as many camera poses or None.
/// @throws FileError; InvalidArgument for several views of which one has no camera pose.
[[nodiscard]] std::vector<stone::SceneView> views_of(const pybind11::object& scene,
                                                     const pybind11::object& camera_pose, bool world,
                                                     const stone::DepthInput& input);
/// The views as detection takes them.
[[nodiscard]] std::vector<detection::DepthView> depth_views_of(const std::vector<stone::SceneView>& views);

}  // namespace stonestack::python
