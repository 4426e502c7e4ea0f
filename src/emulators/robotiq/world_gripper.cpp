#include <algorithm>
#include <cmath>
#include <mutex>

#include "emulators/robotiq/gripper_plant.hpp"
#include "simulation/finger_drive.hpp"
#include "simulation/shared_world.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kStalled = 0.15;         // s without motion until a drive reports rest
constexpr double kPositioned = 2.5e-4;    // m/s: slower is rest; the creep towards the force is faster
constexpr double kAtTarget = 1e-5;        // m
constexpr double kMovingCurrent = 0.15;   // A
constexpr double kScissorStart = 137.0;   // counts: basic mode
constexpr double kScissorNarrow = 220.0;  // counts: fingers B and C side by side; design choice

bool same(const AxisCommand& a, const AxisCommand& b) {
  return a.go == b.go && a.target == b.target && a.speed == b.speed && a.force == b.force;
}

class WorldGripper final : public GripperPlant {
 public:
  WorldGripper(SharedWorld& world, const GripperCounts& counts) : world_(&world), counts_(counts) {
    {
      const auto access = world.lock();
      const GripperModel& gripper = access.world.gripper_body().gripper;
      max_narrowed_ = std::max(0.0, gripper.finger_spacing - gripper.narrow_spacing);
      half_stroke_ = 0.5 * gripper.max_opening;
      against_ = gripper.against;
      place_ = access.world.gripper_pose().finger;
    }
    world.drive_fingers([this](const TrueWorld& now, double seconds) { return drive(now, seconds); });
  }
  ~WorldGripper() override { world_->drive_fingers({}); }
  WorldGripper(const WorldGripper&) = delete;
  WorldGripper& operator=(const WorldGripper&) = delete;

  void command(const std::array<AxisCommand, kGripperAxes>& axes) override {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if (same(axes[i], command_[i])) continue;
      command_[i] = axes[i];
      if (i >= drives_.size()) continue;
      still_[i] = 0.0;
      // A stands alone against B and C, which share its force, or against B.
      const double target = std::clamp(axes[i].target, counts_.min, counts_.closed);
      drives_[i] = {place_of(target), axes[i].speed / range() * half_stroke_,
                    i == 0 ? axes[i].force : axes[i].force / against_, world_->options().regrip};
    }
  }

  std::array<AxisReport, kGripperAxes> advance(double seconds) override {
    const std::lock_guard lock(mutex_);
    std::array<AxisReport, kGripperAxes> report;
    for (std::size_t f = 0; f < drives_.size(); ++f) report[f] = finger_report(f);
    report[3] = advance_scissor(seconds);
    return report;
  }

 private:
  [[nodiscard]] double range() const { return counts_.closed - counts_.open; }
  [[nodiscard]] double place_of(double count) const {
    return half_stroke_ * (1.0 - (count - counts_.open) / range());
  }

  // With the world locked.
  FingerPlaces drive(const TrueWorld& now, double seconds) {
    const std::lock_guard lock(mutex_);
    const std::array<double, kFingers> places = now.gripper_pose().finger;
    const std::array<double, kFingers> driven =
        next_finger_places(now.gripper_body(), drives_, places, now.finger_force(), seconds);
    std::array<double, kFingers> next = places;
    for (std::size_t f = 0; f < next.size(); ++f) {
      if (command_[f].go) next[f] = driven[f];
      const bool rests = std::abs(next[f] - places[f]) < kPositioned * seconds;
      still_[f] = rests ? still_[f] + seconds : 0.0;
    }
    place_ = next;
    const double share = (scissor_ - kScissorStart) / (kScissorNarrow - kScissorStart);
    return {next, max_narrowed_ * std::clamp(share, 0.0, 1.0)};
  }

  [[nodiscard]] AxisReport finger_report(std::size_t f) const {
    using Status = AxisReport::Status;
    AxisReport report;
    report.position = std::max(counts_.min, counts_.open + range() * (1.0 - place_[f] / half_stroke_));
    const double remaining = drives_[f].target - place_[f];
    if (!command_[f].go || std::abs(remaining) < kAtTarget) return report;
    report.status = remaining < 0 ? Status::kContactClosing : Status::kContactOpening;
    if (still_[f] >= kStalled) return report;
    report.status = Status::kMoving;
    report.current = kMovingCurrent;
    return report;
  }

  [[nodiscard]] AxisReport advance_scissor(double seconds) {
    const AxisCommand& command = command_[3];
    const double remaining = command.target - scissor_, step = command.speed * seconds;
    if (command.go) scissor_ += std::abs(remaining) <= step ? remaining : std::copysign(step, remaining);
    AxisReport report;
    report.position = scissor_;
    if (command.go && scissor_ != command.target) report.status = AxisReport::Status::kMoving;
    return report;
  }

  SharedWorld* world_;
  GripperCounts counts_;
  int against_ = 2;
  double half_stroke_ = 0.0;   // m
  double max_narrowed_ = 0.0;  // m
  std::mutex mutex_;           // of all below; taken after the world's, never before
  std::array<AxisCommand, kGripperAxes> command_{};
  std::array<FingerDriveState, kFingers> drives_{};
  std::array<double, kFingers> place_{};  // m
  std::array<double, kFingers> still_{};  // s
  double scissor_ = kScissorStart;
};

}  // namespace

std::unique_ptr<GripperPlant> make_world_gripper(SharedWorld& world, const GripperCounts& counts) {
  return std::make_unique<WorldGripper>(world, counts);
}

}  // namespace stonestack::emulators
