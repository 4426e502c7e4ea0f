#include <cmath>

#include "core/yaml.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::search {
namespace {

constexpr const char* kTargetSchema = "stonestack.target/1";
constexpr double kMaxCourses = 50, kMaxInCourse = 1000;
constexpr double kMinLength = 0.05, kMaxLength = 100.0;  // m
constexpr double kMaxJointGap = 0.1;                     // m
constexpr const char* kTargetForm = "4+3+2+1 (stones a course), 0.8x3 (metres and courses), or a target file";

std::vector<int> counts_of(const std::string& text) {
  std::vector<int> counts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('+', begin), text.size());
    const double count = parse_numbers(text.substr(begin, end - begin), 1, kTargetForm).front();
    require(count >= 1 && count <= kMaxInCourse && count == std::floor(count), "--wall '", text,
            "': a course needs a whole number of stones from 1 to ", kMaxInCourse);
    counts.push_back(static_cast<int>(count));
    begin = end + 1;
  }
  return counts;
}

WallTarget target_of_file(const std::string& path) {
  yaml::Map map(yaml::read_file(path), path);
  const std::string schema = map.text("schema");
  if (schema != kTargetSchema)
    map.fail("schema", concat("is '", schema, "'"), concat("this version reads ", kTargetSchema));
  WallTarget target;
  yaml::Map wall = map.map("wall");
  if (wall.has("courses")) {
    const auto list = wall.node("courses");
    if (!list.IsSequence() || list.size() == 0)
      wall.fail("courses", "is not a list", "give the stones of each course from the table up: [4, 3, 2, 1]");
    for (std::size_t k = 0; k < list.size(); ++k) {
      int count = 0;
      if (!YAML::convert<int>::decode(list[k], count) || count < 1 || count > kMaxInCourse)
        wall.fail("courses", "has an entry that is no number of stones", "give whole numbers from 1");
      target.courses.push_back(count);
    }
  } else {
    target.length = wall.number("length", kMinLength, kMaxLength);
    const double levels = wall.number("levels", 1, kMaxCourses);
    if (levels != std::floor(levels))
      wall.fail("levels", concat("is ", levels), "give a whole number of courses");
    target.levels = static_cast<int>(levels);
  }
  wall.finish();
  if (map.has("centre")) {
    yaml::Map centre = map.map("centre");
    const double x = centre.number("x", -kMaxLength, kMaxLength);
    target.centre_W = Eigen::Vector2d(x, centre.number("y", -kMaxLength, kMaxLength));
    centre.finish();
  }
  if (map.has("joint_gap")) target.joint_gap = map.number("joint_gap", 0.0, kMaxJointGap);
  if (map.has("yaw_deg")) target.yaw = map.number("yaw_deg", -360, 360) * M_PI / 180.0;
  map.finish();
  return target;
}

}  // namespace

WallTarget read_wall_target(const std::string& text) {
  require(!text.empty(), "a wall needs ", kTargetForm);
  if (is_scene_file(text)) return target_of_file(text);
  WallTarget target;
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos) {
    target.courses = counts_of(text);
    return target;
  }
  target.length = parse_numbers(text.substr(0, cross), 1, kTargetForm).front();
  const double levels = parse_numbers(text.substr(cross + 1), 1, kTargetForm).front();
  require(target.length >= kMinLength && target.length <= kMaxLength, "--wall '", text,
          "': the length must be in [", kMinLength, ", ", kMaxLength, "] m");
  require(levels >= 1 && levels <= kMaxCourses && levels == std::floor(levels), "--wall '", text,
          "': the number of courses must be a whole number from 1 to ", kMaxCourses);
  target.levels = static_cast<int>(levels);
  return target;
}

}  // namespace stonestack::search
