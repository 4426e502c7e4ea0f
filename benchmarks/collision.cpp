// Prints whether collision checks agree with an exact reference (CGAL) over random configurations.
#include <memory>

#include "bench.hpp"
#include "collision_reference.hpp"
#include "core/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::bench {
namespace {

constexpr double kNear = 0.0001;  // m: nearer to the padding than this, either answer is right

/// Thirteen boxes and spheres of stone size: some stacked, the others around.
PlanningScene thirteen_objects(std::uint64_t seed) {
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  scene.T_F_T = CellLayout().T_F_T;
  Random random = Random::stream(seed, "thirteen objects");
  for (int i = 0; i < 13; ++i) {
    const Eigen::Vector3d p = i < 5 ? Eigen::Vector3d(0.7, 0.28, 0.05 + 0.1 * i)
                                    : Eigen::Vector3d(random.uniform(0.4, 0.9), random.uniform(-0.5, 0.1),
                                                      random.uniform(0.05, 0.6));
    const Mesh mesh = i % 2 == 0 ? make_sphere(0.06, 0) : make_box({0.12, 0.09, 0.07});
    scene.objects.push_back({"stone", {mesh}, make_pose(p, random.rotation())});
  }
  return scene;
}

void compare(int configurations, std::uint64_t seed, Results& results) {
  const PlanningScene scene = thirteen_objects(seed);
  const CollisionRules rules;
  const CollisionChecker checker(scene, rules);
  const CollisionReference reference(scene, rules);
  Random random = Random::stream(seed, "configurations");
  int collide = 0, on_the_edge = 0, missed = 0, invented = 0;
  for (int n = 0; n < configurations; ++n) {
    throw_if_interrupted();
    Joints q;
    for (double& angle : q) angle = random.uniform(-kPi, kPi);
    const double gap = reference.min_gap(q, kNear);
    const bool hit = checker.collides(q);
    collide += hit ? 1 : 0;
    if (std::abs(gap) <= kNear)
      ++on_the_edge;
    else if (gap < 0 && !hit)
      ++missed;
    else if (gap > 0 && hit)
      ++invented;
  }
  results.settings({{"robot", "ur10"},
                    {"objects", scene.objects.size()},
                    {"configurations", configurations},
                    {"padding_mm", 1e3 * rules.padding},
                    {"seed", static_cast<int>(seed)}});
  results.figures("against exact distances (CGAL)", {{"collide", collide},
                                                     {"at_padding_within_0.1_mm", on_the_edge},
                                                     {"missed", missed},
                                                     {"invented", invented}});
}

}  // namespace

void add_collision(CLI::App& app) {
  struct Command {
    int configurations = 2000;
    int seed = 1;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("collision", "Collision checks against exact distances");
  sub->add_option("--configurations", command->configurations)
      ->check(CLI::Range(1, 100000000))
      ->capture_default_str();
  sub->add_option("--seed", command->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->footer("Example:\n  stonestack-bench collision --configurations 100000");
  measure_by(*sub, [command](Results& results) {
    compare(command->configurations, static_cast<std::uint64_t>(command->seed), results);
  });
}

}  // namespace stonestack::bench
