#pragma once
#include <vector>

#include "detection/features/models.hpp"

namespace stonestack::detection {

/// Turns of a stone that bring it nearly onto itself, as a cube's 23 or some of a ball's: T_O_S such that the
/// model at T_C_O * T_O_S looks much like the model at T_C_O. Best first, none of less than 0.3 rad, any two
/// 0.3 rad apart; empty for a stone that looks like nothing but itself.
[[nodiscard]] std::vector<Pose> turns_onto_itself(const DetectionModel& model);

/// The detection's own pose and those that the turns of its model lead to, judged alike; best score first.
[[nodiscard]] std::vector<Detection> judged_alternatives(const Detection& d, const DetectionModel& model,
                                                         const DetectionScene& alone);

/// The covariance of the mixture: of the pose itself, and of the poses that the same stone may as well have.
void widen_by_alternatives(Detection& detection);

}  // namespace stonestack::detection
