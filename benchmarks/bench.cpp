#include "bench.hpp"

#include "commands.hpp"

namespace stonestack::apps {

void add_bench(CLI::App& app) {
  CLI::App* bench = app.add_subcommand("bench", "Measure: every figure we state comes from one of these");
  bench->require_subcommand(1);
  for (const auto add :
       {add_bench_detection, add_bench_search, add_bench_calibration, add_bench_equilibrium,
        add_bench_kinematics, add_bench_grasp, add_bench_hold, add_bench_rest, add_bench_motion,
        add_bench_collision, add_bench_cartesian, add_bench_timing, add_bench_descent, add_bench_rtde})
    add(*bench);
  bench->footer(
      "Each prints its seed and settings. Times are of this machine.\n"
      "Examples:\n"
      "  stonestack bench kinematics\n"
      "  stonestack bench detection --scenes 100 --methods default,paper");
}

}  // namespace stonestack::apps
