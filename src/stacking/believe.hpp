#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/: from sightings to a belief, and the belief in words.
namespace stonestack::stacking {

/// Which sightings are the stack and which lie loose. A stone belongs to the stack if it was expected there
/// (or not) and rests on the stone below: its lowest part is above the table and over the stone below. Poses
/// in the stack are made consistent: a measured pose floats or sinks by the camera's error, so the stone is
/// let settle from it onto the stack below, and the rest pose is taken if it is within a few millimetres of
/// what was measured.
[[nodiscard]] Belief believe(const ShapeList& shapes, const CellLayout& layout,
                             const std::vector<PlacedStone>& expected,
                             const std::vector<Sighting>& sightings);

/// A box over the field where stones of unknown place may lie, before the first look.
[[nodiscard]] SceneObject unseen_field(const CellLayout& layout);
/// The same for the site, as high as a tower may be that somebody left there.
[[nodiscard]] SceneObject unseen_site(const CellLayout& layout);

/// What looks tell of the site before anything is built: table only, something above it, or neither.
enum class SiteView { kUnseen, kFree, kTaken };
[[nodiscard]] SiteView view_of_site(const std::vector<Look>& looks, const Eigen::Vector2d& site);

/// Is it the same stone at nearly the same pose: centres of mass within `shift` (m), turned by at most `turn`
/// (rad)?
[[nodiscard]] bool same_place(const ShapeList& shapes, const PlacedStone& a, const PlacedStone& b,
                              double shift, double turn);

/// Lowest point of a stone, m in W.
[[nodiscard]] double lowest(const ContactShape& shape, const Pose& T_W_O);
/// Highest point of the stones, m in W; 0 for none.
[[nodiscard]] double top_height(const ShapeList& shapes, const std::vector<PlacedStone>& stones);

/// Is any of one stone's surface within `gap` (m, at most 10 mm) of the other's?
[[nodiscard]] bool lie_within(const ShapeList& shapes, const PlacedStone& a, const PlacedStone& b,
                              double gap);

/// Would a stone that is placed on those `below` come to lean on one of the loose ones that stays where it
/// is? What leans on a tower makes it none: such a stone is only taken off again.
[[nodiscard]] bool leans_on_loose(const ShapeList& shapes, const std::vector<PlacedStone>& loose,
                                  const PlacedStone& placed, const std::vector<PlacedStone>& below);

/// The lowest level of the stack that a loose stone touches (or nearly: measured poses err by a millimetre),
/// and that stone: such a stack is not clean from there on. Nothing if none does.
struct Stray {
  std::size_t level = 0;
  PlacedStone stone;
};
[[nodiscard]] std::optional<Stray> stray_at_stack(const ShapeList& shapes, const Belief& belief);

/// "stack: limestone_2, limestone_5; loose: limestone_1".
[[nodiscard]] std::string describe(const Catalogue& catalogue, const Belief& belief);
/// For the journal.
[[nodiscard]] std::string belief_json(const Catalogue& catalogue, const Belief& belief);
[[nodiscard]] std::string placement_json(const Catalogue& catalogue, const Placement& placement);

}  // namespace stonestack::stacking
