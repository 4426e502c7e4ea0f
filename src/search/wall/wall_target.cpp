#include <charconv>
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
constexpr double kMaxHeight = 5.0;                       // m
constexpr const char* kTargetForm =
    "4+3+2+1 (stones a course), 0.8x3 (metres and courses), bridge:0.08 (metres), or a target file";
constexpr const char* kBridge = "bridge:";
constexpr double kMinSpan = 0.01, kMaxSpan = 2.0;  // m of a bridge

/// The number that a part of a target is. `option`: with its value, for the message.
double number_of(const std::string& part, const std::string& option) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
  require(error == std::errc() && end == part.data() + part.size() && std::isfinite(value), option, ": '",
          part, "' is not a number; expected ", kTargetForm);
  return value;
}

std::vector<int> counts_of(const std::string& text) {
  std::vector<int> counts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('+', begin), text.size());
    const double count = number_of(text.substr(begin, end - begin), "--wall '" + text + "'");
    require(count >= 1 && count <= kMaxInCourse && count == std::floor(count), "--wall '", text,
            "': a course needs a whole number of stones from 1 to ", kMaxInCourse);
    counts.push_back(static_cast<int>(count));
    begin = end + 1;
  }
  return counts;
}

/// The maps of a list, each read by `read`.
template <typename Read>
void each_of(yaml::Map& map, const std::string& key, const std::string& path, const Read& read) {
  const auto list = map.node(key);
  if (!list.IsSequence() || list.size() == 0) map.fail(key, "is not a list", "give a list of maps");
  for (std::size_t k = 0; k < list.size(); ++k) {
    yaml::Map item(list[k], path, concat(key, "[", k, "]"));
    read(item);
    item.finish();
  }
}

SpanTask task_of_file(yaml::Map& map, const std::string& path) {
  SpanTask task;
  each_of(map, "spans", path, [&](yaml::Map& item) {
    Span span;
    span.from = item.number("from", -kMaxLength, kMaxLength);
    span.to = item.number("to", -kMaxLength, kMaxLength);
    if (item.has("clear")) span.clear = item.number("clear", 0.0, kMaxHeight);
    if (span.to <= span.from) item.fail("to", "is not beyond `from`", "give the larger x");
    task.spans.push_back(span);
  });
  if (map.has("supports"))
    each_of(map, "supports", path, [&](yaml::Map& item) {
      TargetSupport support;
      support.from = item.number("from", -kMaxLength, kMaxLength);
      support.to = item.number("to", -kMaxLength, kMaxLength);
      support.height = item.number("height", 0.005, kMaxHeight);
      if (item.has("depth")) support.depth = item.number("depth", 0.005, kMaxLength);
      if (support.to < support.from + 0.005)
        item.fail("to", "is not beyond `from` by 5 mm", "give the larger x");
      task.supports.push_back(support);
    });
  if (map.has("on_table")) {
    const std::string answer = map.text("on_table");
    if (answer != "true" && answer != "false")
      map.fail("on_table", concat("is '", answer, "'"), "give true or false");
    task.on_table = answer == "true";
  }
  if (map.has("carry")) task.carry = map.number("carry", -kMaxLength, kMaxLength);
  return task;
}

void read_wall(yaml::Map& wall, WallTarget& target) {
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
}

WallTarget target_of_file(const std::string& path) {
  yaml::Map map(yaml::read_file(path), path);
  const std::string schema = map.text("schema");
  if (schema != kTargetSchema)
    throw FileError(path, concat("is a ", schema, " file by its schema"),
                    concat("give a ", kTargetSchema, " file, as those in data/targets"));
  WallTarget target;
  if (map.has("spans")) {
    target.task = task_of_file(map, path);
  } else {
    yaml::Map wall = map.map("wall");
    read_wall(wall, target);
  }
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
  if (text.starts_with(kBridge)) {
    const std::string length = text.substr(std::string(kBridge).size());
    const double span = number_of(length, "--bridge '" + length + "'");
    require(span >= kMinSpan && span <= kMaxSpan, "--bridge ", span, ": the span must be in [", kMinSpan,
            ", ", kMaxSpan, "] m");
    target.task = SpanTask{{}, {{-0.5 * span, 0.5 * span}}, true, std::nullopt};
    return target;
  }
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos) {
    target.courses = counts_of(text);
    return target;
  }
  target.length = number_of(text.substr(0, cross), "--wall '" + text + "'");
  const double levels = number_of(text.substr(cross + 1), "--wall '" + text + "'");
  require(target.length >= kMinLength && target.length <= kMaxLength, "--wall '", text,
          "': the length must be in [", kMinLength, ", ", kMaxLength, "] m");
  require(levels >= 1 && levels <= kMaxCourses && levels == std::floor(levels), "--wall '", text,
          "': the number of courses must be a whole number from 1 to ", kMaxCourses);
  target.levels = static_cast<int>(levels);
  return target;
}

}  // namespace stonestack::search
