#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "hardware/ur/primary_client.hpp"
#include "hardware/ur/ur_arm.hpp"
#include "hardware/ur/ur_status.hpp"

/// The connections to one controller, its heartbeat, and whether motions are allowed.
namespace stonestack::hardware {

class UrLink {
 public:
  explicit UrLink(const UrArmOptions& options);
  ~UrLink();
  UrLink(const UrLink&) = delete;
  UrLink& operator=(const UrLink&) = delete;

  /// The newest status. Throws DeviceError if it is stale.
  [[nodiscard]] UrStatus status() const;
  /// The first status that comes in within a few control steps, else the newest; throws if that is stale.
  [[nodiscard]] UrStatus next_status() const;
  /// Streams a force (N, axes of the controller's base) under a new counter.
  void send_force(const Eigen::Vector3d& force);
  /// Why motions are refused; empty: they are not.
  [[nodiscard]] std::string stop_reason() const;
  /// No motion until `rearm`.
  void disarm(const std::string& reason);
  /// Ends the link for a stop that did not get through: no heartbeat any more either, so that the
  /// controller's watchdog ends what runs.
  void starve(const std::string& reason);
  void rearm();
  /// Why the arm may not move with the safety configuration that the controller says on the present script
  /// connection; empty: it may, or the options name none. Connects again if that connection was lost.
  /// @throws DeviceError
  [[nodiscard]] std::string other_safety_configuration();
  [[nodiscard]] std::optional<std::uint32_t> wait_for_safety_checksum() const;
  /// Explains a script that did not start.
  [[nodiscard]] std::string explain_silence() const;
  [[nodiscard]] int next_run();

  const UrArmOptions options;
  RtdeClient rtde;
  PrimaryClient primary;
  const UrVersion version;
  const int registers;
  std::atomic<bool> program_in_transit{false};  ///< sent, and its run id not seen yet

 private:
  void beat();
  void send_inputs();

  std::mutex inputs_mutex_;
  std::int32_t heartbeat_ = 0, force_count_ = 0;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();
  mutable std::mutex arming_mutex_;
  std::string stop_reason_;
  std::atomic<bool> starved_{false};
  std::atomic<int> run_{0};
  std::mutex ending_mutex_;
  std::condition_variable ending_changed_;
  bool ending_ = false;
  std::thread heart_;
};

}  // namespace stonestack::hardware
