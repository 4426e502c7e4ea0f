#include <charconv>
#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::stone {

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const auto to = std::min(text.find(',', from), text.size());
    parts.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

std::vector<double> parse_numbers(const std::string& text, std::size_t count, const char* form) {
  std::vector<double> numbers;
  for (const auto& part : split_list(text)) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    require(error == std::errc() && end == part.data() + part.size() && std::isfinite(value), "'", part,
            "' in '", text, "' is not a number; expected ", form);
    numbers.push_back(value);
  }
  require(numbers.size() == count, "'", text, "' has ", numbers.size(), " numbers; expected ", form);
  return numbers;
}

Pose parse_pose(const std::string& text) {
  if (is_scene_file(text)) {
    const SceneFile scene = read_scene_file(text);
    if (!scene.T_W_C)
      throw FileError(text, "has no T_W_C", "add the camera's pose or give it as x,y,z,qx,qy,qz,qw");
    return *scene.T_W_C;
  }
  const auto v = parse_numbers(text, 7, "x,y,z,qx,qy,qz,qw");
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  require(std::abs(q.norm() - 1.0) < 0.01, "the rotation of '", text, "' has length ", q.norm(),
          "; it must be 1");
  return make_pose({v[0], v[1], v[2]}, q);
}

Eigen::Vector2d parse_point(const std::string& text) {
  const auto v = parse_numbers(text, 2, "x,y");
  return {v[0], v[1]};
}

}  // namespace stonestack::stone
