#pragma once
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stone {

/// How far one surface lies from another, metres.
struct Deviation {
  double median = 0.0;  ///< median distance [m]
  double worst = 0.0;   ///< largest distance [m]
};

/// Model of a stone: its scan, measured once. Frame O: origin at the centre of mass
/// of the uniform scan, axes of the scanned file unless asked otherwise.
struct Stone {
  std::string name;                  ///< name of the stone and of its folder
  Mesh mesh;                         ///< at most 500 faces: detection, rough search (paper §4.1)
  Mesh scan;                         ///< full resolution: contact, verdict, the true world
  std::vector<Mesh> pieces;          ///< convex pieces: motion's collision checks
  MassProperties mass;               ///< in O
  double friction = 0.1;             ///< stone on stone, what the planner assumes (paper §4.1)
  double density = 2600.0;           ///< [kg/m^3]
  Pose T_O_file = Pose::Identity();  ///< where the scanned file's frame, scaled to metres, lies in O
  double scale = 1.0;                ///< metres per unit of the scanned file
  std::string source;                ///< file or generator with seed
  Deviation mesh_deviation;          ///< of the reduced mesh from the scan, in both directions
  Deviation contact_deviation;       ///< of the surface that physics collides with from the scan
};

/// A stone somewhere, by index into whatever list of stones the owner holds.
struct PlacedStone {
  int stone = -1;                 ///< index into the owner's list
  Pose T_W_O = Pose::Identity();  ///< pose of the stone
};

}  // namespace stonestack::stone

#pragma GCC visibility pop
