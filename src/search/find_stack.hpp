#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/physics/stack.hpp"

namespace stonestack::search {

/// Surface above the table that belongs to no stone that was found.
struct UnknownThing {
  Eigen::Vector2d p_W{0.0, 0.0};           ///< its middle, seen from above
  double highest = 0.0;                    ///< above the table [m]
  std::vector<Eigen::Vector3d> surface_W;  ///< what is seen of it
  int on = -1;                             ///< index in the list of stones of one that it lies over; -1: none
};

/// Stones that were seen, sorted by what carries them.
struct SortedStones {
  std::vector<PlacedStone> stack;        ///< the tower to build on, from the table up; may be empty
  std::vector<PlacedStone> available;    ///< nothing lies on them: may be taken
  std::vector<PlacedStone> carrying;     ///< not in the stack, but a stone or an unknown thing lies on them
  std::vector<PlacedStone> unsupported;  ///< clear of the table, and no stone that was seen carries them
  std::vector<UnknownThing> unknown;     ///< seen above the table, and part of no stone that was found
  std::string note;  ///< why nothing may be built on this, for a person; empty where it may
};

/// Finds the tower among stones whose poses were measured to a few millimetres, by geometry: a stone carries
/// another where their surfaces lie within 6 mm of each other, the carrier's surface faces upwards there, and
/// the other's centre of mass is higher. A tower is a chain of stones from the table up, each carried by the
/// one below alone and carrying one at most. With `site` (W) the tower is the one whose lowest stone has its
/// centre of mass nearest to it, within 12 cm, and may be that stone alone; without, it is the highest of at
/// least two stones. z = 0 of W is the table.
///
/// The stones that were found may not be all that are there. A stone in the air that none of them carries,
/// and surface that none of them explains, are taken for parts of a tower: `note` then says so, with `site`
/// only within the reach of the tower there.
/// @param seen_W surface above the table that the view shows (`view_of_table`), a point in each cube of about
/// 5 mm; empty: not looked at.
/// @throws InvalidArgument for indices out of range.
[[nodiscard]] SortedStones find_stack(const ShapeList& shapes, const std::vector<PlacedStone>& stones,
                                      const std::optional<Eigen::Vector2d>& site = std::nullopt,
                                      const std::vector<Eigen::Vector3d>& seen_W = {});

/// The place on the table where the first stone of a tower lies best: of the places where any of the
/// `available` stones would lie within `table_W`, clear of all of `stones` with the gripper's fingers beside
/// it, the one nearest to `p_W_middle`; where no place is so clear, the clearest.
/// @param table_W centres of square cells, `cell` m wide, in which the bare table is seen.
/// @return empty where each place in view touches a stone.
[[nodiscard]] std::optional<Eigen::Vector2d> choose_site(const ShapeList& shapes,
                                                         const std::vector<PlacedStone>& stones,
                                                         const std::vector<PlacedStone>& available,
                                                         const std::vector<Eigen::Vector2d>& table_W,
                                                         double cell, const Eigen::Vector2d& p_W_middle);

}  // namespace stonestack::search
