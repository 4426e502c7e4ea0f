#pragma once
#include <functional>
#include <optional>

#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::modelling {

/// Completes the underside of a model of one object that stands still, by that: of the unseen surface that
/// looks down the lowest is set on the table, as little as the centre of mass lies over by a margin. Nothing
/// is left below the table.
/// @param model in the frame of a scene: the table is z = 0
void rest_on_table(ObjectModel& model);

/// Height above the table of what an object stands on [m]; empty beside that.
using HeightBelow = std::function<std::optional<double>(const Eigen::Vector2d& p_W)>;

/// Completes the underside of a model of an object that stands still on something else in the same way. No
/// unseen surface that looks down is left below what it stands on.
void rest_on(ObjectModel& model, const HeightBelow& height);

}  // namespace stonestack::modelling
