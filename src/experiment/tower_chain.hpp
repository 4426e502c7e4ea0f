#pragma once
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "simulation/true_world.hpp"

/// Which stones of the true world are a tower.
namespace stonestack::experiment {

/// The table in the contact graph, where it is a neighbour like any other.
inline constexpr StoneIndex kTableNode = kNoStone;

/// Contact graph of the stones and the table.
class Neighbours {
 public:
  /// `T_W_O` by stone index; nearer than `touch_gap` (m) counts as touching.
  Neighbours(const TrueWorld& world, const std::vector<Pose>& T_W_O, double touch_gap);
  [[nodiscard]] std::vector<StoneIndex> of(StoneIndex stone) const;

 private:
  std::set<std::pair<StoneIndex, StoneIndex>> pairs_;
};

/// Poses by stone index, identity for absent stones: as the world stands, or of a judge's world.
[[nodiscard]] std::vector<Pose> true_poses(const TrueWorld& world);
[[nodiscard]] std::vector<Pose> judged_poses(const TrueWorld& world, const RigidWorld& judge);

/// Stones of a tower, from the table up.
struct TowerChain {
  std::vector<StoneIndex> stones;
  std::string unclean;  ///< what ended the tower other than its top; empty: nothing
};
/// Goes from the table up, as long as one stone, and only one, rests on the last and touches nothing below
/// but it.
[[nodiscard]] TowerChain find_chain(const TrueWorld& world, const std::vector<Pose>& T_W_O,
                                    const Neighbours& neighbours, const Eigen::Vector2d& site);

/// Part of a tower that is still a clean one.
struct CleanPart {
  int stones = 0;       ///< number, from the table up
  std::string unclean;  ///< what the next stone has come to touch; empty: nothing, all are clean
};
/// The chain after a wait: stones that touch nothing that they did not touch before, for what has come to
/// lean on a neighbour by then is no clean tower either.
[[nodiscard]] CleanPart still_clean(const TrueWorld& world, const Neighbours& before, const Neighbours& after,
                                    const std::vector<StoneIndex>& chain);

}  // namespace stonestack::experiment
