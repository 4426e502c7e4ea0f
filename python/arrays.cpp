#include "arrays.hpp"

#include <algorithm>
#include <cstdio>

#include "stonestack/core/error.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::python {
namespace {

namespace py = pybind11;

/// N rows of `width` numbers that `get(row, column)` gives.
template <class Number, class Get>
py::array_t<Number> rows(std::size_t count, std::size_t width, const Get& get) {
  py::array_t<Number> array({count, width});
  Number* out = array.mutable_data();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < width; ++k) *out++ = get(i, static_cast<Eigen::Index>(k));
  return array;
}

void put(const geometry::Pose& pose, double* out) {
  for (Eigen::Index r = 0; r < 4; ++r)
    for (Eigen::Index c = 0; c < 4; ++c) *out++ = pose.matrix()(r, c);
}

}  // namespace

py::array_t<double> to_array(const geometry::Pose& pose) {
  py::array_t<double> array({4, 4});
  put(pose, array.mutable_data());
  return array;
}

py::array_t<double> to_array(const std::vector<geometry::Pose>& poses) {
  py::array_t<double> array({poses.size(), std::size_t{4}, std::size_t{4}});
  for (std::size_t i = 0; i < poses.size(); ++i) put(poses[i], array.mutable_data() + 16 * i);
  return array;
}

py::object optional_pose(const std::optional<geometry::Pose>& pose) {
  return pose ? py::object(to_array(*pose)) : py::none();
}

py::array_t<double> to_array(const Eigen::Vector3d& vector) {
  return py::array_t<double>(3, vector.data());
}

py::array_t<double> to_array(const std::vector<Eigen::Vector3d>& points) {
  return rows<double>(points.size(), 3, [&](std::size_t i, Eigen::Index k) { return points[i][k]; });
}

py::array_t<int> to_array(const std::vector<Eigen::Vector3i>& faces) {
  return rows<int>(faces.size(), 3, [&](std::size_t i, Eigen::Index k) { return faces[i][k]; });
}

py::array_t<double> to_array(const std::vector<kinematics::Joints>& joints) {
  return rows<double>(joints.size(), 6, [&](std::size_t i, Eigen::Index k) { return joints[i][k]; });
}

py::array_t<double> to_array(const std::vector<double>& numbers) {
  return py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

py::array_t<double> matrix_to_array(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  return rows<double>(static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols()),
                      [&](std::size_t i, Eigen::Index k) { return matrix(static_cast<Eigen::Index>(i), k); });
}

py::array_t<float> to_array(const geometry::DepthImage& image) {
  py::array_t<float> array({image.camera.height, image.camera.width});
  std::copy(image.z.begin(), image.z.end(), array.mutable_data());
  return array;
}

py::array_t<float> to_array(const geometry::Cloud& cloud) {
  const auto& points = cloud.points;
  auto flat = rows<float>(points.size(), 3, [&](std::size_t i, Eigen::Index k) { return points[i][k]; });
  if (cloud.height <= 1) return flat;
  return flat.reshape({cloud.height, cloud.width, 3});
}

geometry::Pose to_pose(const py::object& given) {
  if (py::isinstance<py::str>(given)) return stone::parse_pose(given.cast<std::string>());
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(given);
  if (!array) PyErr_Clear();
  core::require(static_cast<bool>(array) && array.ndim() == 2 && array.shape(0) == 4 && array.shape(1) == 4,
                "a pose is a 4 x 4 matrix or the text x,y,z,qx,qy,qz,qw");
  geometry::Pose pose = geometry::Pose::Identity();
  for (py::ssize_t r = 0; r < 4; ++r)
    for (py::ssize_t c = 0; c < 4; ++c) pose.matrix()(r, c) = array.at(r, c);
  core::require(geometry::is_valid(pose) && pose.matrix().row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1)),
                "a pose must be rigid: rotation orthonormal, last row 0, 0, 0, 1; got\n", pose.matrix());
  return pose;
}

std::string to_pose_text(const py::object& given) {
  if (given.is_none()) return "";
  if (py::isinstance<py::str>(given)) return given.cast<std::string>();
  const geometry::Pose pose = to_pose(given);
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d p = pose.translation();
  char text[256];
  std::snprintf(text, sizeof text, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", p.x(), p.y(), p.z(), q.x(),
                q.y(), q.z(), q.w());
  return text;
}

}  // namespace stonestack::python
