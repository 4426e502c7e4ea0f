#include "kinematics/gripper_file.hpp"

#include <algorithm>
#include <cmath>

#include "core/field_file.hpp"
#include "core/yaml.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

constexpr const char* kGripperFolder = "grippers";
constexpr const char* kGripperSchema = "stonestack.gripper/1";
constexpr const char* kGripperRemedy = "see docs/formats.md, Grippers, and data/grippers/robotiq-2f-85.yaml";
constexpr double kGripperFurthest = 0.6;  // m: no part of a gripper on these arms is further from its tips
constexpr std::size_t kMaxGripperBoxes = 16, kMaxGripperTips = 32;

/// The lists as they stand in the file, and the schema.
struct GripperFileText {
  std::string schema, boxes, tips;
};

FieldList gripper_file_fields(GripperFile& h, GripperFileText& text) {
  const FieldRange length{0.0, 0.3}, force{0.1, 1000.0}, speed{0.001, 1.0}, count{0.0, 255.0};
  return {
      field("schema", text.schema, kGripperSchema),
      field("name", h.name, "of the gripper"),
      field("against", h.against, {1, 2}, "", "fingers that face the single one"),
      field("tip", h.tip, {0.02, 0.5}, "m", "of the open fingers from the gripper's mount"),
      field("max_opening", h.max_opening, {0.005, 0.5}, "m", "between the pads"),
      field("min_object", h.min_object, {0.0, 0.2}, "m", "smallest that is gripped"),
      field("finger.width", h.finger_width, {0.002, 0.2}, "m", "along y"),
      field("finger.spacing", h.finger_spacing, length, "m", "between two fingers; 0: there is one"),
      field("finger.narrow_spacing", h.narrow_spacing, length, "m", "drawn together; 0: they cannot be"),
      field("pad.length", h.pad_length, {0.002, 0.2}, "m", "along z, to the tip"),
      field("pad.thickness", h.pad_thickness, {0.0002, 0.03}, "m", "of the rubber"),
      field("pad.stiffness", h.pad_stiffness, {1e5, 1e11}, "N/m^3", "pressure over depth"),
      field("pad.shear", h.pad_shear, {1e5, 1e11}, "N/m^3", "sideways"),
      field("pad.friction", h.friction, {0.05, 2.0}, "", "on stone"),
      field("force.min", h.min_force, force, "N", "of a pad"),
      field("force.max", h.max_force, force, "N", "of a pad"),
      field("force.grip", h.grip_force, force, "N", "of a pad, in plans"),
      field("speed.min", h.min_speed, speed, "m/s", "of the opening"),
      field("speed.max", h.max_speed, speed, "m/s", "of the opening"),
      field("count.open", h.open_count, count, "count", "reported when fully open"),
      field("count.closed", h.closed_count, count, "count", "reported when the pads meet"),
      field("mass", h.mass, {0.01, 20.0}, "kg", "of the gripper alone"),
      field("centre_of_mass", h.centre_of_mass, {-0.5, 0.0}, "m", "z from the tips"),
      field("payload", h.payload, {0.01, 50.0}, "kg", "at the finger tips"),
      field("tips", text.tips, "list of opening, advance: the arc of the finger tips"),
      field("boxes", text.boxes, "list of size, centre, and what moves them"),
  };
}

[[noreturn]] void refuse_gripper(const std::string& path, const std::string& problem) {
  throw FileError(path, problem, kGripperRemedy);
}

Eigen::Vector3d read_vector(yaml::Map map, double low) {
  Eigen::Vector3d v;
  for (Eigen::Index i = 0; i < 3; ++i) v[i] = map.number(std::string(1, "xyz"[i]), low, kGripperFurthest);
  map.finish();
  return v;
}

double number_or_0(yaml::Map& map, const char* key, double low, double high) {
  return map.has(key) ? map.number(key, low, high) : 0.0;
}

YAML::Node list_of(const std::string& text, const std::string& path, const char* key, std::size_t max) {
  const YAML::Node list = yaml::parse(text, path);
  if (!list.IsSequence() || list.size() > max)
    refuse_gripper(path, concat(key, " is not a list of at most ", max, " entries"));
  return list;
}

std::vector<GripperFileBox> read_boxes(const std::string& text, const std::string& path) {
  const YAML::Node list = list_of(text, path, "boxes", kMaxGripperBoxes);
  std::vector<GripperFileBox> boxes;
  for (std::size_t i = 0; i < list.size(); ++i) {
    yaml::Map entry(list[i], path, concat("boxes[", i, "]"));
    GripperFileBox box;
    box.size = read_vector(entry.map("size"), 1e-4);
    box.p_T_centre = read_vector(entry.map("centre"), -kGripperFurthest);
    box.finger_side = number_or_0(entry, "finger_side", -1.0, 1.0);
    box.spread = number_or_0(entry, "spread", -1.0, 1.0);
    box.advance = number_or_0(entry, "advance", 0.0, 1.0);
    if (entry.has("camera")) {
      const std::string word = entry.text("camera");
      if (word != "true" && word != "false") entry.fail("camera", "is '" + word + "'", "write true or false");
      box.camera = word == "true";
    }
    entry.finish();
    boxes.push_back(box);
  }
  return boxes;
}

std::vector<GripperFileTip> read_tips(const std::string& text, const GripperFile& file) {
  if (text.empty()) return {};
  const YAML::Node list = list_of(text, file.path, "tips", kMaxGripperTips);
  std::vector<GripperFileTip> tips;
  for (std::size_t i = 0; i < list.size(); ++i) {
    yaml::Map entry(list[i], file.path, concat("tips[", i, "]"));
    const GripperFileTip tip{entry.number("opening", 0.0, file.max_opening),
                             entry.number("advance", -0.1, 0.1)};
    entry.finish();
    if (!tips.empty() && tip.opening <= tips.back().opening)
      refuse_gripper(file.path,
                     concat("tips[", i, "].opening is ", tip.opening, ", not above the one before"));
    tips.push_back(tip);
  }
  if (tips.size() < 2 || tips.front().opening != 0.0 || tips.back().opening != file.max_opening ||
      tips.back().advance != 0.0)
    refuse_gripper(file.path, concat("tips must go from opening 0 to max_opening (", file.max_opening,
                                     " m), where the advance is 0"));
  return tips;
}

/// Checks figures against each other.
void check_gripper(const GripperFile& h) {
  const auto need = [&](bool good, const std::string& problem) {
    if (!good) refuse_gripper(h.path, problem);
  };
  const auto rises = [&](const char* what, double low, double high) {
    need(low < high, concat(what, ": ", low, " is not below ", high));
  };
  rises("min_object and max_opening", h.min_object, h.max_opening);
  rises("force.min and force.max", h.min_force, h.max_force);
  need(h.min_force <= h.grip_force && h.grip_force <= h.max_force,
       concat("force.grip ", h.grip_force, " N does not lie in ", h.min_force, " to ", h.max_force, " N"));
  rises("speed.min and speed.max", h.min_speed, h.max_speed);
  rises("count.open and count.closed", h.open_count, h.closed_count);
  need(h.pad_length < h.tip, concat("pad.length ", h.pad_length, " m is not shorter than tip ", h.tip, " m"));
  if (h.against == 1)
    need(h.finger_spacing == 0.0 && h.narrow_spacing == 0.0,
         "finger.spacing and finger.narrow_spacing are for two fingers against one; against is 1");
  else
    need(h.finger_spacing >= h.finger_width &&
             (h.narrow_spacing == 0.0 || h.narrow_spacing < h.finger_spacing),
         concat("finger.spacing ", h.finger_spacing, " m does not hold two fingers of ", h.finger_width,
                " m, or is not above finger.narrow_spacing"));
  int sides = 0, palm = 0;
  for (const GripperFileBox& box : h.boxes) {
    if (box.finger_side > 0.0) sides |= 1;
    if (box.finger_side < 0.0) sides |= 2;
    if (box.finger_side == 0.0 && !box.camera) ++palm;
  }
  need(sides == 3 && palm > 0, "boxes need fingers on both sides (finger_side 1 and -1) and a palm");
}

}  // namespace

bool is_gripper_path(const std::string& text) {
  return core::is_yaml_path(text);
}

GripperFile read_gripper_file(const std::string& name_or_path) {
  GripperFile file;
  GripperFileText text;
  file.path = core::data_file("gripper", kGripperFolder, name_or_path);
  core::read_fields(file.path, gripper_file_fields(file, text), kGripperRemedy, {"tips"});
  if (text.schema != kGripperSchema)
    refuse_gripper(file.path, concat("schema is '", text.schema, "', not ", kGripperSchema));
  if (file.name.empty()) refuse_gripper(file.path, "name is empty");
  file.boxes = read_boxes(text.boxes, file.path);
  file.tips = read_tips(text.tips, file);
  check_gripper(file);
  return file;
}

std::vector<std::string> gripper_file_names() {
  return core::data_names(kGripperFolder);
}

}  // namespace stonestack::kinematics
