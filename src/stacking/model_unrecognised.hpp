#pragma once
#include <vector>

#include "stacking/model_field.hpp"
#include "stacking/run_memory.hpp"
#include "stacking/workcell.hpp"

/// Private to stacking/: stones that lie otherwise than any model shows.
namespace stonestack::stacking {

/// Models what the views of `world` show, is part of no stone, and was not there while all stones were seen:
/// from up to four views of each thing, as it lies, as many as stones are lost. Nothing is moved. What is not
/// whole, or beyond the gripper, is left out. With one stone lost and one thing found the weighed mass is
/// that of the lost one. Names go on after those of the catalogue. A stone in sight is modelled where it
/// stands, also if the gripper could not take it; on others, from the model that it has, whose unseen
/// underside is brought onto the stone below.
/// @throws DeviceError when the arm stops
[[nodiscard]] ModelledField model_unrecognised(Workcell& workcell, const WorldEstimate& world,
                                               const RunMemory& memory, const ModelAnew& action,
                                               Journal* journal);

}  // namespace stonestack::stacking
