#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "emulators/robotiq/ft_simulator.hpp"
#include "protocol/ft_frames.hpp"

namespace stonestack::emulators {

/// Samples the plant at the sensor's rate in a thread of its own; whoever serves a link takes the newest.
/// Thread-safe. Holds the faults, because they belong to the sensor and not to one link.
class FtSource {
 public:
  FtSource(WrenchPlant& plant, double rate, double speed_up);
  ~FtSource();

  struct Sample {
    long number = 0;
    FtReading reading{};
  };
  /// The newest sample if it is newer than `number`, waiting up to `seconds`.
  [[nodiscard]] std::optional<Sample> newer_than(long number, double seconds);
  [[nodiscard]] FtReading newest();
  void set_faults(const FtFaults& faults);
  [[nodiscard]] FtFaults faults();
  /// True if the counted fault is armed; uses one up.
  [[nodiscard]] bool take(int FtFaults::*fault);
  [[nodiscard]] bool take_power_cycle();

 private:
  void run();
  [[nodiscard]] FtReading spoil(FtReading reading);

  WrenchPlant* plant_;
  double rate_, speed_up_;
  std::mutex mutex_;
  std::condition_variable sampled_;
  Sample newest_;
  FtFaults faults_;
  double drifted_ = 0.0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace stonestack::emulators
