#include "stonestack/kinematics/hand_eye.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/yaml.hpp"
#include "geometry/pose_yaml.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::kinematics {
namespace {

constexpr const char* kSchema = "stonestack.hand_eye/1";

/// Shortest text that reads back as the same number.
std::string number_text(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  const std::string plain(text, end);
  return plain.find_first_of(".e") == std::string::npos ? plain + ".0" : plain;
}

bool is_printable(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

/// In double quotes, control characters escaped; what is not ASCII stays as it is.
std::string escaped(const std::string& text) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\t')
      quoted += "\\t";
    else if (c == '\n')
      quoted += "\\n";
    else if (c == '"' || c == '\\')
      quoted += std::string("\\") + c;
    else if (byte < 0x20 || byte == 0x7F)
      quoted += std::string("\\x") + kHex[byte >> 4U] + kHex[byte & 15U];
    else
      quoted += c;
  }
  return quoted + '"';
}

/// Read back as this text, number or truth value without quotes.
bool stands_plain(const std::string& value) {
  if (!is_printable(value)) return false;
  YAML::Emitter plain;
  plain << value;
  return value == plain.c_str();
}

EasyHandEyeParameter read_parameter(yaml::Map& map, const std::string& key) {
  const YAML::Node node = map.node(key);
  if (node.IsNull()) return {key, "", true, false};
  const std::string value = map.text(key);
  const bool is_text = node.Tag() == "!" || node.Tag() == "tag:yaml.org,2002:str";  // in quotes, or !!str
  return {key, value, false, is_text || !stands_plain(value)};
}

/// PyYAML takes single quotes unless something must be escaped.
std::string scalar_text(const EasyHandEyeParameter& p) {
  if (p.is_null) return "null";
  if (!p.is_quoted && stands_plain(p.value)) return p.value;
  if (!is_printable(p.value)) return escaped(p.value);
  std::string quoted = "'";
  for (const char c : p.value) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

CameraMount read_on_hand(yaml::Map& parameters) {
  const std::string on_hand = parameters.text("eye_on_hand");
  if (on_hand != "true" && on_hand != "false")
    parameters.fail("eye_on_hand", concat("is '", on_hand, "'"), "it must be true or false");
  return on_hand == "true" ? CameraMount::kOnHand : CameraMount::kOnBase;
}

CameraMount read_type(yaml::Map& parameters) {
  const std::string type = parameters.text("calibration_type");
  if (type != "eye_in_hand" && type != "eye_on_base")
    parameters.fail("calibration_type", concat("is '", type, "'"), "it must be eye_in_hand or eye_on_base");
  return type == "eye_in_hand" ? CameraMount::kOnHand : CameraMount::kOnBase;
}

/// geometry_msgs/Transform as ROS 2 writes it in YAML, within the bounds of read_pose.
Pose read_transform(yaml::Map map) {
  constexpr double kFarthest = 100.0;  // m
  yaml::Map p = map.map("translation"), q = map.map("rotation");
  const Eigen::Vector3d translation(p.number("x", -kFarthest, kFarthest),
                                    p.number("y", -kFarthest, kFarthest),
                                    p.number("z", -kFarthest, kFarthest));
  const Eigen::Quaterniond rotation(q.number("w", -2, 2), q.number("x", -2, 2), q.number("y", -2, 2),
                                    q.number("z", -2, 2));
  p.finish(), q.finish(), map.finish();
  if (std::abs(rotation.norm() - 1.0) > 0.01)
    map.fail("rotation", concat("has length ", rotation.norm()), "a rotation has length 1");
  return make_pose(translation, rotation);
}

/// The rotation with w not negative.
Eigen::Quaterniond rotation_of(const EasyHandEye& calibration) {
  Eigen::Quaterniond q(calibration.T_A_C.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return q;
}

std::string line_of(const EasyHandEyeParameter& parameter) {
  return concat("  ", scalar_text({parameter.key, parameter.key}), ": ", scalar_text(parameter), "\n");
}

std::string text_of_ros(const EasyHandEye& calibration) {
  auto parameters = calibration.parameters;
  parameters.push_back({"eye_on_hand", calibration.mount == CameraMount::kOnHand ? "true" : "false"});
  std::sort(parameters.begin(), parameters.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
  const Eigen::Quaterniond q = rotation_of(calibration);
  const Eigen::Vector3d& p = calibration.T_A_C.translation();
  const std::vector<std::pair<std::string, double>> numbers = {
      {"qw", q.w()}, {"qx", q.x()}, {"qy", q.y()}, {"qz", q.z()}, {"x", p.x()}, {"y", p.y()}, {"z", p.z()}};
  std::string text = "parameters:\n";
  for (const auto& parameter : parameters) text += line_of(parameter);
  text += "transformation:\n";
  for (const auto& [key, value] : numbers) text += concat("  ", key, ": ", number_text(value), "\n");
  return text;
}

std::string text_of_ros2(const EasyHandEye& calibration) {
  const EasyHandEyeParameter type{"calibration_type",
                                  calibration.mount == CameraMount::kOnHand ? "eye_in_hand" : "eye_on_base"};
  std::string text = "parameters:\n";
  const auto& parameters = calibration.parameters;
  const bool named = !parameters.empty() && parameters.front().key == "name";
  if (!named) text += line_of(type);
  for (const auto& parameter : parameters) {
    text += line_of(parameter);
    if (named && &parameter == &parameters.front()) text += line_of(type);
  }
  const Eigen::Quaterniond q = rotation_of(calibration);
  const Eigen::Vector3d& p = calibration.T_A_C.translation();
  const auto line = [](const char* key, double value) {
    return concat("    ", key, ": ", number_text(value), "\n");
  };
  text += "transform:\n  translation:\n" + line("x", p.x()) + line("y", p.y()) + line("z", p.z());
  text += "  rotation:\n" + line("x", q.x()) + line("y", q.y()) + line("z", q.z()) + line("w", q.w());
  return text;
}

}  // namespace

HandEyeFile read_hand_eye_pairs(const std::string& path) {
  yaml::Map map(yaml::read_file(path), path);
  const std::string schema = map.text("schema");
  if (schema != kSchema)
    throw FileError(path, concat("is a ", schema, " file by its schema"),
                    concat("give a ", kSchema, " file, as `calibrate --write-pairs` writes"));
  HandEyeFile file;
  file.path = path;
  const std::string camera = map.text("camera");
  if (camera != "on_hand" && camera != "on_base")
    map.fail("camera", concat("is '", camera, "'"), "it must be on_hand or on_base");
  file.mount = camera == "on_hand" ? CameraMount::kOnHand : CameraMount::kOnBase;
  const auto list = map.node("pairs");
  if (!list.IsSequence())
    map.fail("pairs", "is not a list", "write one '- {T_R_F: {...}, T_C_B: {...}}' each");
  for (std::size_t i = 0; i < list.size(); ++i) {
    yaml::Map entry(list[i], path, concat("pairs[", i, "]"));
    file.pairs.push_back({read_pose(entry.map("T_R_F")), read_pose(entry.map("T_C_B"))});
    entry.finish();
  }
  map.finish();
  return file;
}

void write_hand_eye_pairs(const std::string& path, const HandEyeFile& file) {
  std::string text = concat("schema: ", kSchema, "\ncamera: ", to_text(file.mount), "\npairs:\n");
  for (const auto& p : file.pairs)
    text +=
        concat("  - {T_R_F: ", geometry::to_text(p.T_R_F), ", T_C_B: ", geometry::to_text(p.T_C_B), "}\n");
  write_file(path, text);
}

EasyHandEye read_easy_handeye(const std::string& path) {
  yaml::Map map(yaml::read_file(path), path);
  EasyHandEye out;
  yaml::Map parameters = map.map("parameters");
  out.of_ros2 = parameters.has("calibration_type");
  out.mount = out.of_ros2 ? read_type(parameters) : read_on_hand(parameters);
  for (const auto& entry : map.node("parameters")) {
    const std::string key = entry.first.Scalar();
    if (key != "eye_on_hand" && key != "calibration_type")
      out.parameters.push_back(read_parameter(parameters, key));
  }
  out.T_A_C = out.of_ros2 ? read_transform(map.map("transform")) : read_pose(map.map("transformation"));
  map.finish();
  return out;
}

void write_easy_handeye(const std::string& path, const EasyHandEye& calibration) {
  write_file(path, calibration.of_ros2 ? text_of_ros2(calibration) : text_of_ros(calibration));
}

}  // namespace stonestack::kinematics
