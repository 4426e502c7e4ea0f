#pragma once
#include <map>
#include <string>

#include "stonestack/experiment/experiment.hpp"

namespace stonestack::experiment {

/// Counts hits and trials of runs, apart for each set of stones (`Rate`).
class ClusteredCount {
 public:
  /// A trial of that run.
  void add(const RunReport& report, bool hit);
  [[nodiscard]] Rate rate() const;

 private:
  struct Tally {
    int hits = 0, trials = 0;
  };
  std::map<std::string, Tally> clusters_;
};

}  // namespace stonestack::experiment
