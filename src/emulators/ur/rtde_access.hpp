#pragma once
#include <functional>
#include <string>

#include "emulators/ur/controller.hpp"
#include "protocol/rtde_fields.hpp"

namespace stonestack::emulators {

using RtdeReader = std::function<RtdeValue(const UrController&)>;
using RtdeWriter = std::function<void(UrController&, const RtdeValue&)>;

/// Where an output field comes from. What a simulated robot does not have (voltages of a tool) reads zero.
[[nodiscard]] RtdeReader rtde_reader(const RtdeField& field);
/// Where an input field goes. Masked ones take effect when `apply_masked_inputs` is called after a package,
/// with the names of that package's fields: a mask of another one has had its effect and has it no more, or
/// else an output that a program has set since would be set back.
[[nodiscard]] RtdeWriter rtde_writer(const RtdeField& field);
void apply_masked_inputs(UrController& controller, const std::vector<std::string>& names);

}  // namespace stonestack::emulators
