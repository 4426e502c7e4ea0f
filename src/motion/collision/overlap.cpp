#include "motion/collision/overlap.hpp"

#include <algorithm>

#include "motion/collision/convex_core.hpp"

namespace stonestack::motion {

bool objects_overlap(const SceneObject& a, const SceneObject& b) {
  const btTransform T_W_a = to_bullet(a.T_W_object), T_W_b = to_bullet(b.T_W_object);
  return std::any_of(a.pieces.begin(), a.pieces.end(), [&](const Mesh& own) {
    const ConvexCore core = make_core(own.vertices, 0.0);
    return std::any_of(b.pieces.begin(), b.pieces.end(), [&](const Mesh& other) {
      return hull_distance(core, T_W_a, make_core(other.vertices, 0.0), T_W_b) <= 0.0;
    });
  });
}

}  // namespace stonestack::motion
