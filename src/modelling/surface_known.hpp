#pragma once
#include <optional>
#include <vector>

#include "stonestack/modelling/model_objects.hpp"
#include "stonestack/stone/stone.hpp"

namespace stonestack::modelling {

/// How well the surface of a stone is known that was made of a model.
/// @param up_at_rest unit vectors in the frame of the model that pointed up while it lay on the table
/// @return empty where the scan has other vertices than the model: it was repaired
[[nodiscard]] std::optional<SurfaceKnowledge> surface_known(const Stone& stone, const ObjectModel& model,
                                                            const std::vector<Eigen::Vector3d>& up_at_rest);

}  // namespace stonestack::modelling
