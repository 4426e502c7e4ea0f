#include "motion/problem_file.hpp"

#include <cmath>
#include <limits>
#include <sstream>

#include "geometry/enclosing_shapes.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::motion {
namespace {

constexpr std::size_t kMaxFile = std::size_t{1} << 22;
constexpr std::size_t kMaxObjects = 10000, kMaxProblems = 100000;
constexpr double kFurthest = 100.0;       ///< nothing a robot plans with is larger or further away [m]
constexpr double kGripperLength = 0.264;  ///< flange to tip of the gripper that a file has by default [m]

/// The statements of one line and where it stands, for messages.
class ProblemFileLine {
 public:
  ProblemFileLine(const std::string& text, const std::string& file, int number)
      : stream_(text), file_(file), number_(number) {}

  [[noreturn]] void refuse(const std::string& problem) const {
    throw FileError(file_, concat("line ", number_, ": ", problem), "see docs/formats.md, Motion problems");
  }
  /// Empty at the end of the line.
  std::string word() {
    std::string word;
    stream_ >> word;
    return word;
  }
  double number(const char* what, double low, double high) {
    const std::string text = word();
    if (text.empty()) refuse(concat("lacks ", what));
    std::size_t used = 0;
    double value = std::numeric_limits<double>::quiet_NaN();
    try {
      value = std::stod(text, &used);
    } catch (const std::logic_error&) {
      used = 0;
    }
    if (used != text.size() || !(value >= low && value <= high))
      refuse(concat(what, " '", text, "' is not a number in [", low, ", ", high, "]"));
    return value;
  }
  double size(const char* what) { return number(what, 1e-4, kFurthest); }
  Eigen::Vector3d point() {
    const double x = number("x", -kFurthest, kFurthest), y = number("y", -kFurthest, kFurthest);
    return {x, y, number("z", -kFurthest, kFurthest)};
  }
  /// x y z, then qx qy qz qw or nothing.
  Pose pose() {
    const Eigen::Vector3d p = point();
    if ((stream_ >> std::ws).eof()) return make_pose(p);
    const double x = number("qx", -1.01, 1.01), y = number("qy", -1.01, 1.01), z = number("qz", -1.01, 1.01);
    const Eigen::Quaterniond q(number("qw", -1.01, 1.01), x, y, z);
    if (std::abs(q.norm() - 1.0) > 1e-3) refuse(concat("the quaternion has the norm ", q.norm(), ", not 1"));
    return make_pose(p, q.normalized());
  }
  Joints joints(const RobotModel& robot) {
    Joints q;
    for (Eigen::Index i = 0; i < 6; ++i)
      q[i] = number("a joint angle", robot.lower[i] - 1e-9, robot.upper[i] + 1e-9);
    return q;
  }
  void end() {
    if (const std::string more = word(); !more.empty()) refuse(concat("has '", more, "' too many"));
  }

 private:
  std::istringstream stream_;
  const std::string& file_;
  int number_;
};

/// A shape statement; false if `word` names none.
bool read_shape(const std::string& word, ProblemFileLine& line, PlanningScene& scene) {
  if (word != "box" && word != "sphere" && word != "cylinder" && word != "capsule") return false;
  if (scene.objects.size() >= kMaxObjects) line.refuse(concat("is object ", kMaxObjects + 1, ", too many"));
  SceneObject object;
  object.name = line.word();
  if (object.name.empty()) line.refuse(concat("a ", word, " lacks its name"));
  if (word == "box") {
    const double x = line.size("size x"), y = line.size("size y");
    object.pieces = {make_box({x, y, line.size("size z")})};
  } else {
    const double radius = line.size("radius");
    if (word == "sphere") object.pieces = {around_sphere(radius)};
    if (word == "cylinder") object.pieces = {around_cylinder(radius, line.size("length"))};
    if (word == "capsule") object.pieces = {around_capsule(radius, line.size("length"))};
  }
  object.T_W_object = line.pose();
  scene.objects.push_back(std::move(object));
  return true;
}

void read_statement(const std::string& word, ProblemFileLine& line, MotionProblems& out) {
  if (read_shape(word, line, out.scene)) return;
  const bool begun = !out.problems.empty();
  if (word == "robot" && !begun) {
    const std::string robot = line.word();
    if (robot.empty() || robot.find('/') != std::string::npos)
      line.refuse(concat("'", robot, "' names no robot of data/robots"));
    out.scene.robot = read_robot(robot);
  } else if (word == "hand" && !begun) {
    const std::string gripper = line.word();
    if (gripper != "none" && gripper != "robotiq_3f")
      line.refuse(concat("hand '", gripper, "' is not known"));
    if (gripper == "none") out.scene.gripper.boxes.clear();
  } else if (word == "tool") {
    out.scene.T_F_T = line.pose();
  } else if (word == "base") {
    out.scene.T_W_R = line.pose();
  } else if (word == "table") {
    out.scene.table_z = line.number("table height", -kFurthest, kFurthest);
  } else if (word == "padding") {
    out.padding = line.number("padding", 0.0, 1.0);
  } else if (word == "start") {
    if (out.problems.size() >= kMaxProblems)
      line.refuse(concat("is problem ", kMaxProblems + 1, ", too many"));
    out.problems.push_back({line.joints(out.scene.robot), {}});
  } else if (word == "goal") {
    if (!begun) line.refuse("a goal comes after its start");
    out.problems.back().goals.push_back(line.joints(out.scene.robot));
  } else {
    line.refuse(concat("does not know '", word, begun ? "' after the first start" : "'"));
  }
}

}  // namespace

MotionProblems parse_motion_problems(const std::string& text, const std::string& name) {
  MotionProblems out;
  out.scene.robot = read_robot("ur10");
  bool has_tool = false;
  std::istringstream lines(text);
  std::string content;
  for (int number = 1; std::getline(lines, content); ++number) {
    ProblemFileLine line(content.substr(0, content.find('#')), name, number);
    const std::string word = line.word();
    if (word.empty()) continue;
    read_statement(word, line, out);
    has_tool = has_tool || word == "tool";
    line.end();
  }
  for (std::size_t i = 0; i < out.problems.size(); ++i)
    if (out.problems[i].goals.empty())
      throw FileError(name, concat("problem ", i + 1, " has no goal"),
                      "see docs/formats.md, Motion problems");
  if (!has_tool && !out.scene.gripper.boxes.empty()) out.scene.T_F_T.translation().z() = kGripperLength;
  if (out.problems.empty()) throw FileError(name, "has no start", "see docs/formats.md, Motion problems");
  return out;
}

MotionProblems read_motion_problems(const std::string& path) {
  return parse_motion_problems(read_file(path, kMaxFile), path);
}

}  // namespace stonestack::motion
