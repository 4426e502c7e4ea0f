#pragma once
#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::modelling {

/// Completes the underside of a model of one object that stands still, by that: of the unseen surface that
/// looks down the lowest is set on the table, as little as the centre of mass lies over by a margin. Nothing
/// is left below the table.
/// @param model in the frame of a scene: the table is z = 0
void rest_on_table(ObjectModel& model);

}  // namespace stonestack::modelling
