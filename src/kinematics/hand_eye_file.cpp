#include "stonestack/kinematics/hand_eye_file.hpp"

#include <algorithm>
#include <charconv>

#include "core/yaml.hpp"
#include "geometry/pose_yaml.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack {
namespace {

constexpr const char* kSchema = "stonestack.hand_eye/1";

/// Shortest text that reads back as the same number.
std::string number_text(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  const std::string plain(text, end);
  return plain.find_first_of(".e") == std::string::npos ? plain + ".0" : plain;
}

}  // namespace

HandEyeFile read_hand_eye_pairs(const std::string& path) {
  yaml::Map map(yaml::read_file(path), path);
  const std::string schema = map.text("schema");
  if (schema != kSchema)
    map.fail("schema", concat("is '", schema, "'"), concat("this version reads ", kSchema));
  HandEyeFile file;
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
    text += concat("  - {T_R_F: ", to_text(p.T_R_F), ", T_C_B: ", to_text(p.T_C_B), "}\n");
  write_file(path, text);
}

EasyHandEye read_easy_handeye(const std::string& path) {
  yaml::Map map(yaml::read_file(path), path);
  EasyHandEye out;
  yaml::Map parameters = map.map("parameters");
  const std::string on_hand = parameters.text("eye_on_hand");
  if (on_hand != "true" && on_hand != "false")
    parameters.fail("eye_on_hand", concat("is '", on_hand, "'"), "it must be true or false");
  out.mount = on_hand == "true" ? CameraMount::kOnHand : CameraMount::kOnBase;
  for (const auto& entry : map.node("parameters")) {
    const std::string key = entry.first.Scalar();
    if (key != "eye_on_hand") out.parameters.emplace_back(key, parameters.text(key));
  }
  out.T_A_C = read_pose(map.map("transformation"));
  map.finish();
  return out;
}

void write_easy_handeye(const std::string& path, const EasyHandEye& calibration) {
  auto parameters = calibration.parameters;
  parameters.emplace_back("eye_on_hand", calibration.mount == CameraMount::kOnHand ? "true" : "false");
  std::sort(parameters.begin(), parameters.end());
  Eigen::Quaterniond q(calibration.T_A_C.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d& p = calibration.T_A_C.translation();
  const std::vector<std::pair<std::string, double>> numbers = {
      {"qw", q.w()}, {"qx", q.x()}, {"qy", q.y()}, {"qz", q.z()}, {"x", p.x()}, {"y", p.y()}, {"z", p.z()}};
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "parameters" << YAML::Value << YAML::BeginMap;
  for (const auto& [key, value] : parameters) out << YAML::Key << key << YAML::Value << value;
  out << YAML::EndMap << YAML::Key << "transformation" << YAML::Value << YAML::BeginMap;
  for (const auto& [key, value] : numbers) out << YAML::Key << key << YAML::Value << number_text(value);
  out << YAML::EndMap << YAML::EndMap;
  write_file(path, std::string(out.c_str()) + "\n");
}

}  // namespace stonestack
