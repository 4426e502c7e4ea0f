#include "segmentation.hpp"

#include <pybind11/stl.h>

#include <algorithm>

#include "arrays.hpp"
#include "calls.hpp"
#include "inputs.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/detection/segment.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::python {
namespace {

namespace py = pybind11;

/// A segmentation with the views that it is of.
struct Segmented {
  std::vector<stone::SceneView> views;
  detection::Segmentation result;
};

/// An object with the pose of the camera in whose frame it is given.
struct FoundObject {
  detection::SegmentedObject object;
  std::optional<geometry::Pose> T_W_C;
};

/// A number within the limits that the command has for its flag.
void require_within(const char* name, double value, double lowest, double highest) {
  core::require(value >= lowest && value <= highest, name, " must be ", lowest, " to ", highest, " m, got ",
                value);
}

Segmented segment(const py::object& scene, const py::object& camera_pose, bool world, double min_width,
                  double usual_size, double farthest, const stone::DepthInput& input) {
  require_within("min_width", min_width, 0.002, 1.0);
  require_within("usual_size", usual_size, 0.02, 5.0);
  require_within("farthest", farthest, 0.2, 20.0);
  detection::SegmentOptions options;
  options.min_width = min_width;
  options.usual_size = usual_size;
  options.farthest = farthest;
  Segmented done{views_of(scene, camera_pose, world, input), {}};
  done.result = call([&] {
    auto result = detection::segment(depth_views_of(done.views), options);
    stone::check_level(done.views.front(), result.table_C, "the cloud");
    return result;
  });
  return done;
}

/// Numbers of objects as height x width, a view each.
std::vector<py::array_t<int>> label_images(const Segmented& s) {
  std::vector<py::array_t<int>> images;
  for (std::size_t v = 0; v < s.result.labels.size(); ++v) {
    const auto& camera = s.views[v].image.camera;
    py::array_t<int> image({camera.height, camera.width});
    std::copy(s.result.labels[v].begin(), s.result.labels[v].end(), image.mutable_data());
    images.push_back(std::move(image));
  }
  return images;
}

std::vector<FoundObject> objects_of(const Segmented& s) {
  std::vector<FoundObject> list;
  for (const auto& object : s.result.objects) list.push_back({object, s.views.front().T_W_C});
  return list;
}

void add_objects(py::module_& m) {
  py::class_<FoundObject>(m, "SegmentedObject")
      .def_property_readonly("cloud_C", [](const FoundObject& f) { return to_array(f.object.cloud_C); })
      .def_property_readonly("normals_C",
                             [](const FoundObject& f) {
                               geometry::Cloud normals;
                               normals.points = f.object.cloud_C.normals;
                               return to_array(normals);
                             })
      .def_property_readonly("p_C_middle", [](const FoundObject& f) { return to_array(f.object.p_C_middle); })
      .def_property_readonly("p_W_middle",
                             [](const FoundObject& f) -> py::object {
                               if (!f.T_W_C) return py::none();
                               return to_array(Eigen::Vector3d(*f.T_W_C * f.object.p_C_middle));
                             })
      .def_property_readonly("size", [](const FoundObject& f) { return to_array(f.object.size); })
      .def_property_readonly("pixels", [](const FoundObject& f) { return f.object.pixels; })
      .def_property_readonly("views", [](const FoundObject& f) { return f.object.views; })
      .def_property_readonly("confidence", [](const FoundObject& f) { return f.object.confidence; })
      .def_property_readonly("cut_off", [](const FoundObject& f) { return f.object.cut_off; });
}

}  // namespace

void add_segmentation(py::module_& m) {
  py::class_<geometry::Plane>(m, "Plane")
      .def_property_readonly("normal", [](const geometry::Plane& p) { return to_array(p.normal); })
      .def_readonly("offset", &geometry::Plane::offset);
  add_objects(m);
  py::class_<Segmented>(m, "Segmentation")
      .def_property_readonly("objects", &objects_of)
      .def_property_readonly("labels", &label_images)
      .def_property_readonly("table_C", [](const Segmented& s) { return s.result.table_C; })
      .def_property_readonly("T_W_C", [](const Segmented& s) { return optional_pose(s.views.front().T_W_C); })
      .def_property_readonly("note", [](const Segmented& s) { return s.result.note; })
      .def_property_readonly("warnings",
                             [](const Segmented& s) { return report::segmentation_warnings(s.result); })
      .def("__len__", [](const Segmented& s) { return s.result.objects.size(); })
      .def("json",
           [](const Segmented& s) { return report::segmentation_json(s.result, s.views.front().T_W_C); })
      .def(
          "write",
          [](const Segmented& s, const std::string& folder) {
            report::write_segmentation(folder, s.result, s.views);
          },
          py::arg("folder"))
      .def(
          "draw",
          [](const Segmented& s, const std::string& path) {
            report::draw_segmentation(path, s.result, s.views);
          },
          py::arg("path"));
  const detection::SegmentOptions defaults;
  m.def("segment", &segment, py::arg("scene"), py::kw_only(), py::arg("camera_pose") = py::none(),
        py::arg("world") = false, py::arg("min_width") = defaults.min_width,
        py::arg("usual_size") = defaults.usual_size, py::arg("farthest") = defaults.farthest,
        py::arg("depth") = stone::DepthInput{});
}

}  // namespace stonestack::python
