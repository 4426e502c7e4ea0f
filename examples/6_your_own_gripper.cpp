// A gripper of one's own: implement three methods, put it into the cell. This one counts what it is asked.
#include <cstdio>

#include "stonestack/stonestack.hpp"

namespace {

/// Wraps another gripper. A driver of yours talks to its device here.
class CountingGripper : public stonestack::hardware::Gripper {
 public:
  explicit CountingGripper(Gripper& device) : device_(device) {}
  stonestack::hardware::GripperState state() override { return device_.state(); }
  stonestack::hardware::GripperState move(double opening, double speed, double force) override {
    ++moves_;
    return device_.move(opening, speed, force);
  }
  void spread(double spacing) override { device_.spread(spacing); }
  [[nodiscard]] int moves() const { return moves_; }

 private:
  Gripper& device_;
  int moves_ = 0;
};

}  // namespace

int main() try {
  const stonestack::Catalogue catalogue = stonestack::read_catalogue(stonestack::data_path("stones"));
  const stonestack::RobotModel robot = stonestack::read_robot("ur10");
  stonestack::SimulatedCell world(catalogue.stones, stonestack::first_stones(1), robot,
                                  stonestack::CellLayout{});

  stonestack::Cell simulated = world.cell();
  CountingGripper gripper(simulated.gripper);
  stonestack::Cell cell{simulated.arm,    gripper,         simulated.force_torque,
                        simulated.camera, simulated.clock, simulated.layout};
  const stonestack::RunResult result = stonestack::build_tower(cell, catalogue, robot, {});
  std::printf("%d stone stands; the gripper moved %d times\n", result.height, gripper.moves());
  return gripper.moves() >= 2 ? 0 : 6;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
