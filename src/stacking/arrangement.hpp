#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "physics/shape.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/: which stones are stacked and which lie loose, and what follows from that.
namespace stonestack::stacking {

/// Stack and loose stones, from what was seen and what was expected. A stone belongs to the stack if it was
/// expected there and rests over the stone below by geometry; a stone of the stack that did not move keeps
/// its estimate (no random walk of the base, no uncertainty about half-hidden stones). One that is not
/// recognised stays where it was expected if something recognised rests on it, or unless its place is
/// refuted. The stack is settled (settle_stack.hpp) at `options.max_friction`.
struct StoneEstimates {
  std::vector<StoneEstimate> stack, loose;
};
/// @param refuted of a tower: does what is seen show that a stone is not there? Empty: it does for every
/// stone that is not recognised
[[nodiscard]] StoneEstimates estimate_stones(const ShapeList& shapes, const CellLayout& layout,
                                             const std::vector<StoneEstimate>& expected,
                                             const std::vector<Sighting>& sightings,
                                             const BuildOptions& options = {},
                                             const std::function<bool(const PlacedStone&)>& refuted = {});
/// Does a stone at that pose rest over `below`, by geometry alone: clear of the table, its centre over the
/// other's extent?
[[nodiscard]] bool rests_over(const ShapeList& shapes, const PlacedStone& upper, const PlacedStone& below);

/// A box over the field where stones of unknown place may lie, before the first view.
[[nodiscard]] SceneObject unseen_field(const CellLayout& layout);
/// A box over the site, as high as a tower may be that somebody left there.
[[nodiscard]] SceneObject unseen_site(const CellLayout& layout);

/// The site by views of it before anything is built: table only, something above it, or neither.
[[nodiscard]] SiteStatus site_in(const Views& views, const Eigen::Vector2d& site);

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
/// is? A stack that something leans on is not clean: the stone would only be unstacked again.
[[nodiscard]] bool leans_on_loose(const ShapeList& shapes, const std::vector<PlacedStone>& loose,
                                  const PlacedStone& placed, const std::vector<PlacedStone>& below);

/// The lowest level of the stack that a loose stone touches (or nearly: measured poses err by a millimetre),
/// and that stone: such a stack is not clean from there on. Nothing if none does.
struct Stray {
  std::size_t level = 0;
  PlacedStone stone;
};
[[nodiscard]] std::optional<Stray> stray_at_stack(const ShapeList& shapes, const Arrangement& arrangement);
/// Stones of the stack up to the first that a loose stone touches.
[[nodiscard]] int clean_height(const ShapeList& shapes, const Arrangement& arrangement);
/// Centre of mass, m, W.
[[nodiscard]] Eigen::Vector3d com_of(const ShapeList& shapes, const PlacedStone& stone);

}  // namespace stonestack::stacking
