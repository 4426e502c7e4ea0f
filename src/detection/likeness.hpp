#pragma once
#include <vector>

#include "detection/models.hpp"

namespace stonestack {

/// Turns of a stone that bring it nearly onto itself, as a cube's 23 or some of a ball's: T_O_S such that the
/// model at T_C_O * T_O_S looks much like the model at T_C_O. Best first, none of less than 0.3 rad, any two
/// 0.3 rad apart; empty for a stone that looks like nothing but itself.
[[nodiscard]] std::vector<Pose> turns_onto_itself(const DetectionModel& model);

/// Compares each detection with the poses that the turns of its model lead to: takes a pose that fits better,
/// and states what is left of certainty when others fit nearly as well. `covariance` is left alone.
[[nodiscard]] std::vector<Detection> among_its_likes(std::vector<Detection> found,
                                                     const DetectionModels::Data& data,
                                                     const DetectionScene& scene,
                                                     const DetectionOptions& options);

/// The covariance of the mixture: `P` of the pose itself, and the poses it may as well be.
void widen_by_likes(Detection& detection);

}  // namespace stonestack
