#pragma once
#include <optional>

#include "detection/preprocess.hpp"

namespace stonestack {

/// What a view saw, in C as its reported camera pose has it.
struct ViewSurface {
  const SurfacePoints& points;
  std::optional<Plane> table;
};

/// The small motion that carries what a further view saw onto what earlier ones saw, point to plane over the
/// surfaces that both see, the table among them: hand-eye and arm calibration err, and two views of one stone
/// must agree to be judged together. Identity if they share too little, if the shared surface does not fix
/// six degrees of freedom, or if the motion would exceed `align_shift` and `align_turn`.
[[nodiscard]] Pose alignment(const ViewSurface& earlier, const ViewSurface& further,
                             const DetectionOptions& options);

}  // namespace stonestack
