// Decides whether a stack stands: by simulation, and by statics with a margin.
#include <cstdio>

#include "stonestack/stonestack.hpp"

int main() try {
  const stonestack::Catalogue catalogue = stonestack::read_catalogue(stonestack::data_path("stones"));
  const stonestack::ShapeList shapes = stonestack::make_contact_shapes(catalogue.stones);

  // A planned tower of two, so that there is something to check.
  stonestack::SearchProblem problem;
  problem.shapes = &shapes;
  for (const int number : {0, 1})
    problem.available.push_back({stonestack::StoneIndex(number), stonestack::Pose::Identity()});
  stonestack::SearchOptions options;
  options.max_tilt = 3.14;
  stonestack::Stack stack;
  for (const auto& placement : stonestack::plan_tower(problem, 2, options).placements)
    stack.stones.push_back({placement.stone, placement.T_W_O});

  const auto verdict = stonestack::judge_stack(shapes, stack);
  const auto statics = stonestack::physics::stack_equilibrium(shapes, stack);
  std::printf("%zu stones: %s; margin %.3f g, smallest friction %.2f\n", stack.stones.size(),
              verdict.stands ? "stands" : verdict.reason.c_str(), statics.margin, statics.min_friction);
  return verdict.stands ? 0 : 5;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
