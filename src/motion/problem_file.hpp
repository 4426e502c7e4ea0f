#pragma once
#include <string>
#include <vector>

#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {

/// One question to a planner: from `start` to any of `goals`.
struct MotionProblem {
  Joints start = Joints::Zero();
  std::vector<Joints> goals;
};

/// A scene with questions about it.
struct MotionProblems {
  PlanningScene scene;
  double padding = 0.010;  ///< [m]
  std::vector<MotionProblem> problems;
};

/// Reads the text of a problem file (docs/motion-problems.md): one statement a line, `#` begins a comment,
/// metres and radians. Round shapes become polyhedra that contain them, at most 2 % larger. `name` is used in
/// messages. Throws FileError with the line.
[[nodiscard]] MotionProblems parse_motion_problems(const std::string& text, const std::string& name);
[[nodiscard]] MotionProblems read_motion_problems(const std::string& path);

}  // namespace stonestack::motion
