#pragma once
#include <numeric>
#include <vector>

/// Private to drivers and simulated devices: force readings of one guarded motion.
namespace stonestack::hardware {

/// Forces against the direction of a guarded motion, in order [N].
class GuardReadings {
 public:
  void add(double force) { forces_.push_back(force); }
  /// Mean of the second half: of a motion whose speed is constant then. 0 without readings.
  [[nodiscard]] double mean_of_second_half() const {
    if (forces_.empty()) return 0.0;
    const auto from = forces_.begin() + static_cast<std::ptrdiff_t>(forces_.size() / 2);
    return std::accumulate(from, forces_.end(), 0.0) / static_cast<double>(forces_.end() - from);
  }

 private:
  std::vector<double> forces_;
};

}  // namespace stonestack::hardware
