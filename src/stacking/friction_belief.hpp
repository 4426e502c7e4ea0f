#pragma once
#include <cstddef>
#include <vector>

#include "stonestack/core/rooms.hpp"

/// Private to stacking/: which of the frictions that are assumed the stones may have.
namespace stonestack::stacking {

/// How likely each of some frictions is. At first the higher the likelier (ours: dry stone has more rather
/// than less); by Bayes' rule less so each time a placement falls that it would have held.
class FrictionBelief {
 public:
  /// Rising, at least one.
  explicit FrictionBelief(std::vector<double> frictions);

  [[nodiscard]] const std::vector<double>& frictions() const { return frictions_; }
  /// All of them sum to 1.
  [[nodiscard]] double weight(std::size_t level) const { return weights_[level]; }
  [[nodiscard]] bool least_is_likeliest() const;
  /// A placement fell of which `success[level]` (0 to 1) was to be expected with each friction.
  void fell(const std::vector<double>& success);

 private:
  std::vector<double> frictions_, weights_;
};

}  // namespace stonestack::stacking
