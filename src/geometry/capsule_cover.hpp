#pragma once
#include <vector>

#include "geometry/capsule.hpp"
#include "stonestack/geometry/mesh.hpp"

/// Private: a mesh covered by capsules, so that what keeps clear of them keeps clear of it.
namespace stonestack::geometry {

/// At most `max` capsules; each triangle of the mesh lies wholly in them (its parts each in one). The mesh
/// is split where that saves the most volume, as long as it saves a twentieth; neither closed nor
/// consistently oriented faces are needed. The inside of a thick body may be left out. Deterministic; a link
/// of an arm takes 0.1 to 0.3 s. Throws InvalidArgument for a mesh without faces or of no size.
[[nodiscard]] std::vector<Capsule> cover_by_capsules(const Mesh& mesh, std::size_t max);

}  // namespace stonestack::geometry
