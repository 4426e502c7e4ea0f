#pragma once
#include <span>
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"
#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Something that stands in a cell and that the arm must not touch: a wall, a camera stand, a screen.
struct Obstacle {
  std::string name;               ///< name for messages and for pairs of paddings
  std::vector<Mesh> pieces;       ///< convex, in O
  Pose T_W_O = Pose::Identity();  ///< pose of the obstacle in W
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

/// How far one thing that moves stays away from one that stands, instead of what motions keep from all
/// others.
struct PairPadding {
  std::string a;   ///< arm, hand, held, or a link: shoulder, upper arm, forearm, wrist 1, wrist 2, wrist 3
  std::string b;   ///< table, or an obstacle's name
  double m = 0.0;  ///< [m]
};

/// Reads a YAML list of them:
///
///   - {a: hand, b: table, m: 0.004}
///   - {a: arm, b: wall, m: 0.05}
///
/// `obstacles`: names that may stand for `b`. `where` names the list in messages. An empty text is an empty
/// list. Throws FileError with file, key and value, also for a name that nothing has.
[[nodiscard]] std::vector<PairPadding> parse_pair_paddings(const std::string& text, const std::string& path,
                                                           const std::string& where,
                                                           std::span<const std::string> obstacles);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
