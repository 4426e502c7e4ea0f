#include "inputs.hpp"

#include <pybind11/stl.h>

#include "arrays.hpp"
#include "calls.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::python {
namespace {

namespace py = pybind11;

CataloguePtr read_stones(const std::string& path) {
  return call([&] {
    return std::make_shared<stone::Catalogue>(
        stone::read_catalogue(path.empty() ? core::data_path("stones") : path));
  });
}

std::string option_text(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  return py::str(value).cast<std::string>();
}

stone::SceneView view_of(const py::handle& scene, const std::string& camera_pose, bool world,
                         const stone::DepthInput& input) {
  if (!py::isinstance<geometry::DepthImage>(scene))
    return stone::read_view(py::str(scene).cast<std::string>(), camera_pose, world, input);
  core::require(!world, "world is for clouds; a DepthImage is in its camera's frame");
  stone::SceneView view{scene.cast<geometry::DepthImage>(), {}, false};
  if (!camera_pose.empty()) view.T_W_C = stone::parse_pose(camera_pose);
  return view;
}

/// A list as it is; another value as a list of its own.
py::list list_of(const py::object& given) {
  return py::isinstance<py::list>(given) ? py::list(given) : py::list(py::make_tuple(given));
}

}  // namespace

CataloguePtr catalogue_of(const py::object& given) {
  if (py::isinstance<stone::Catalogue>(given)) return given.cast<CataloguePtr>();
  return read_stones(given.is_none() ? "" : py::str(given).cast<std::string>());
}

void set_options(const core::FieldList& list, std::optional<int> seed, const py::dict& options,
                 const std::vector<experiment::FlagValue>& flags) {
  experiment::OptionSources sources;
  sources.flags = flags;
  if (seed) sources.flags.push_back({"seed", "*.seed", std::to_string(*seed)});
  for (const auto& [name, value] : options)
    sources.assignments.push_back(py::str(name).cast<std::string>() + "=" + option_text(value));
  (void)experiment::apply_options(list, sources);
}

std::vector<std::string> names_of(const py::object& given) {
  if (given.is_none()) return {};
  if (py::isinstance<py::str>(given)) return stone::split_list(given.cast<std::string>());
  return given.cast<std::vector<std::string>>();
}

std::vector<stone::SceneView> views_of(const py::object& scene, const py::object& camera_pose, bool world,
                                       const stone::DepthInput& input) {
  const py::list scenes = list_of(scene), poses = list_of(camera_pose);
  core::require(!scenes.empty(), "give a scene: the list is empty");
  core::require(camera_pose.is_none() || poses.size() == scenes.size(),
                "give one camera_pose a scene: there are ", scenes.size(), " scenes and ", poses.size(),
                " poses");
  std::vector<stone::SceneView> views;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::string pose = camera_pose.is_none() ? "" : to_pose_text(py::object(poses[i]));
    views.push_back(view_of(scenes[i], pose, world, input));
    core::require(scenes.size() == 1 || views.back().T_W_C, "scene ", i,
                  " has no camera pose: several views need one each");
  }
  return views;
}

std::vector<detection::DepthView> depth_views_of(const std::vector<stone::SceneView>& views) {
  std::vector<detection::DepthView> depth;
  for (const auto& view : views)
    depth.push_back({view.image, view.T_W_C.value_or(geometry::Pose::Identity())});
  return depth;
}

}  // namespace stonestack::python
