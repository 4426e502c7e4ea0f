#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to the Python module: values of the library as numpy arrays, copied, and back.
namespace stonestack::python {

/// A pose as a 4 x 4 matrix.
[[nodiscard]] pybind11::array_t<double> to_array(const geometry::Pose& pose);
/// Poses as N x 4 x 4.
[[nodiscard]] pybind11::array_t<double> to_array(const std::vector<geometry::Pose>& poses);
/// A pose as a 4 x 4 matrix; None if it is not known.
[[nodiscard]] pybind11::object optional_pose(const std::optional<geometry::Pose>& pose);
/// A point or a vector as 3.
[[nodiscard]] pybind11::array_t<double> to_array(const Eigen::Vector3d& vector);
/// Points as N x 3.
[[nodiscard]] pybind11::array_t<double> to_array(const std::vector<Eigen::Vector3d>& points);
/// Corner indices of triangles as N x 3.
[[nodiscard]] pybind11::array_t<int> to_array(const std::vector<Eigen::Vector3i>& faces);
/// Joint angles as N x 6.
[[nodiscard]] pybind11::array_t<double> to_array(const std::vector<kinematics::Joints>& joints);
/// Numbers as N.
[[nodiscard]] pybind11::array_t<double> to_array(const std::vector<double>& numbers);
/// Any matrix of doubles, a row a row.
[[nodiscard]] pybind11::array_t<double> matrix_to_array(const Eigen::Ref<const Eigen::MatrixXd>& matrix);
/// Depths [m], height x width.
[[nodiscard]] pybind11::array_t<float> to_array(const geometry::DepthImage& image);
/// A cloud's points: height x width x 3 where it is organised, N x 3 else.
[[nodiscard]] pybind11::array_t<float> to_array(const geometry::Cloud& cloud);

/// A pose given as text, `x,y,z,qx,qy,qz,qw` or a scene file, or as a 4 x 4 matrix.
/// @throws InvalidArgument
[[nodiscard]] geometry::Pose to_pose(const pybind11::object& given);
/// The same as text that `parse_pose` reads; None: empty.
[[nodiscard]] std::string to_pose_text(const pybind11::object& given);

}  // namespace stonestack::python
