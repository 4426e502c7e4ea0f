// Problem files of a planner: refused with a FileError or read into finite shapes and joints within limits.
#include <algorithm>
#include <cstdlib>

#include "motion/problem_file.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

void check(bool held) {
  if (!held) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + std::min<std::size_t>(size, 4000));
  try {
    const MotionProblems file = parse_motion_problems(text, "fuzz");
    check(!file.problems.empty() && file.padding >= 0.0);
    for (const auto& object : file.scene.objects) {
      check(is_valid(object.T_W_object) && object.pieces.size() == 1);
      for (const auto& p : object.pieces.front().vertices) check(p.allFinite());
    }
    for (const auto& problem : file.problems) {
      check(problem.start.allFinite() && !problem.goals.empty());
      for (const auto& goal : problem.goals)
        check((goal.array() <= file.scene.robot.upper.array() + 1e-6).all());
    }
  } catch (const FileError&) {
  }
  return 0;
}
