#pragma once
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"
#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Something that stands in a cell and that the arm must not touch: a wall, a camera stand, a screen.
struct Obstacle {
  std::string name;
  std::vector<Mesh> pieces;  ///< convex, in O
  Pose T_W_O = Pose::Identity();
};

/// Reads a YAML list of obstacles; each has a name, one shape and a pose, metres:
///
///   - {name: wall, box: {x: 0.02, y: 2.0, z: 1.5},
///      T_W_O: {x: -0.3, y: 0, z: 0.75, qx: 0, qy: 0, qz: 0, qw: 1}}
///   - {name: post, cylinder: {radius: 0.03, length: 1.2}, T_W_O: {...}}     # about z, middle at the origin
///   - {name: lamp, sphere: {radius: 0.1}, T_W_O: {...}}
///   - {name: stand, mesh: stand.stl, T_W_O: {...}}                          # beside the file `path`
///
/// Round shapes become polyhedra around them, at most 2 % larger; a mesh its convex pieces, or its hull if it
/// is open or has more than 4000 faces. `where` names the list in messages. An empty text is an empty list.
/// Throws FileError with file, key and value.
[[nodiscard]] std::vector<Obstacle> parse_obstacles(const std::string& text, const std::string& path,
                                                    const std::string& where);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
