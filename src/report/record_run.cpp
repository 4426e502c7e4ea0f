#include "stonestack/report/record_run.hpp"

#include "report/perform_run.hpp"
#include "report/run_folder.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::report {

RecordedRun record_run(const RunOrder& order, const Catalogue& catalogue) {
  const RecordFolder folder = take_run_folder(order.out, order.run.seed);
  const CellFile* const file = order.cell ? &*order.cell : nullptr;
  if (file != nullptr) (void)with_option_gripper(to_layout(file->cell()), order.run.build.gripper, true);
  if (file != nullptr && !file->simulate)
    return perform_real(order.run, catalogue, *file, folder, order.version, order.view);
  const RobotModel robot = file == nullptr ? order.robot : read_cell_robot(file->cell());
  const CellLayout layout = with_option_gripper(file == nullptr ? CellLayout{} : to_layout(file->cell()),
                                                order.run.build.gripper, file != nullptr);
  const auto present = draw_stones(catalogue, order.per_run, order.run.seed, gripper_of(layout), robot);
  return perform(order.run, catalogue, robot, present, folder, order.version, nullptr, file, order.view);
}

}  // namespace stonestack::report
