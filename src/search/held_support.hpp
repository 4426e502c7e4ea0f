#pragma once
#include <cstdint>

#include "search/top_surface.hpp"

namespace stonestack::search {

/// Where the held stones of a tower rest, which their models do not tell, and what is on them. They stand:
/// each support contains the centre of mass of the held stones from there on, by a margin that nobody knows.
/// The supports are octagons about those centres, as wide as resting stones have it in the median; at the
/// lowest point of the stone upon each.
/// @param bodies the tower, bottom first; the lowest `held` are held
[[nodiscard]] std::vector<Interface> held_interfaces(std::span<const BodyPose> bodies, int held);

/// Does what was put on the held stones tip them over, where their supports have drawn margins? It does where
/// it moves the common centre of mass above a support sideways by more than that one's margin. Margins are
/// the same for one stone, seed and world.
/// @param stones of the tower, one for each body
[[nodiscard]] bool tips_held(std::span<const BodyPose> bodies, std::span<const PlacedStone> stones, int held,
                             std::uint64_t seed, int world);

}  // namespace stonestack::search
