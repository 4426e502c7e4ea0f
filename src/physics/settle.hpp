#pragma once
#include "physics/world.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack::physics {

/// Letting one stone come to rest on a stack.
struct SettleOptions {
  WorldOptions world;
  double seconds = 1.0;       ///< at most
  double damping = 0.4;       ///< linear and angular, while dropping
  double max_travel = 0.03;   ///< further is a fall, the trial ends early [m]
  double calm_speed = 0.001;  ///< of the centre of mass plus radius times turning [m/s]
  int calm_samples = 8;       ///< samples in a row (4 steps apart) below the calm speed end the trial
  bool any_support = false;   ///< it may rest on any stones and the table, not on the top stone alone
  bool fixed_stack = true;    ///< the stack does not move while the new stone settles
  Eigen::Vector3d com_error_O = Eigen::Vector3d::Zero();  ///< of the new stone [m]: see StandOptions
};
struct SettleResult {
  bool rests = false;  ///< calm, touching what it may: the top stone (or the table for an empty stack)
  Pose T_W_O = Pose::Identity();
  std::vector<Contact>
      contacts;  ///< of the new stone, collected over the calm steps; index `above` is the new stone
  double kinetic_energy = 0.0;  ///< energy [J] at the end
  double travel = 0.0;          ///< distance [m] from the start
  std::string reason;           ///< when it does not rest
};
/// Puts `stone` at T_W_O above the stack and lets go.
[[nodiscard]] SettleResult settle(const ShapeList& shapes, const Stack& stack, StoneIndex stone,
                                  const Pose& T_W_O, const SettleOptions& options = {});

}  // namespace stonestack::physics
