#include "bench.hpp"
#include "problems.hpp"
#include "program.hpp"
#include "sensors.hpp"
#include "soak.hpp"
#include "structures.hpp"
#include "walls.hpp"

namespace {

using namespace stonestack::bench;

void set_up(CLI::App& app) {
  app.name("stonestack-bench");
  app.description("stonestack-bench: every figure that the documentation states comes from one of these.");
  app.footer(
      "Each reports its seed and settings, as text or with --json as data. Times are of this machine.\n"
      "Examples:\n"
      "  stonestack-bench kinematics\n"
      "  stonestack-bench detection --scenes 100 --methods default,paper --json");
  for (const auto add :
       {add_detection, add_segmentation, add_search,   add_calibration, add_equilibrium, add_kinematics,
        add_grasp,     add_hold,         add_rest,     add_motion,      add_collision,   add_cartesian,
        add_timing,    add_descent,      add_rtde,     add_results,     add_site,        add_structures,
        add_walls,     add_tasks,        add_problems, add_solve,       add_score,       add_grippers,
        add_modelling, add_schedule,     add_soak,     add_resume,      add_push,        add_faults,
        add_sensors,   add_mount})
    add(app);
}

}  // namespace

int main(int argc, char** argv) {
  return stonestack::apps::run_program(argc, argv, set_up);
}
