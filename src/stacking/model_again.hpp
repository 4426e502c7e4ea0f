#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stacking/model_field.hpp"
#include "stonestack/modelling/model_objects.hpp"

/// Private to stacking/: a stone that nobody scanned, until its model is done.
namespace stonestack::stacking {

/// One stone while it is being modelled. A known stone is among them as it lies.
struct StoneCandidate {
  int object = 0;  ///< in the first scene; -1: of a known stone
  modelling::ObjectModel model;
  std::vector<modelling::LyingObject> made_of;  ///< what `model` shows; O of it is W of the first of these
  std::vector<modelling::LyingObject> apart;    ///< seen of it, too, and not joined with these
  Stone stone;
  Pose T_W_O;                               ///< of `stone`: where it is, or should have come to lie
  bool moved = false;                       ///< since it was recognised last
  bool found_again = false;                 ///< in the survey after that
  bool let_go = false;                      ///< it was set down otherwise than it lay, if all went as planned
  std::vector<Eigen::Vector3d> up_tried;    ///< frame of the model: upwards where it was let go of
  std::vector<Pose> T_model_T_failed;       ///< grasps that did not hold it
  std::optional<Eigen::Vector2d> p_W_seen;  ///< middle of what was seen of it once it was moved
  std::vector<Mesh> seen_W;  ///< hulls of what was seen of it, down to the table, once it was moved
  ModelledStone made;
};

/// Should the next survey show more of it? It was moved, or one survey shows it so far.
[[nodiscard]] bool is_looked_for(const StoneCandidate& candidate);
/// Where it was seen last, or should lie, seen from above.
[[nodiscard]] Eigen::Vector2d place_on_table(const StoneCandidate& candidate);
/// Middle of what a scene shows of an object, in W [m].
[[nodiscard]] Eigen::Vector3d middle_of_object(const modelling::AlignedScene& scene, int object);
/// Share of a cloud that lies within 10 mm of a closed surface or inside it.
[[nodiscard]] double share_on(const Cloud& cloud_C, const Pose& T_W_C, const Mesh& surface_W);
/// Does a known stone among the candidates explain most of what is seen of an object?
[[nodiscard]] bool is_of_known(const modelling::AlignedScene& scene, int object,
                               std::span<const StoneCandidate> candidates);
/// Why an object is not seen well enough to make a stone of it; empty if it is.
[[nodiscard]] std::string unfit_view(const modelling::AlignedScene& scene, int object);
/// Why an object of the field is not made a stone of; empty if it is.
[[nodiscard]] std::string unfit_object(const modelling::AlignedScene& scene, int object,
                                       const CellLayout& layout);
/// The stone of a model, with the mass that was weighed.
/// @param up_at_rest in the frame of the model: upwards while it lay on the table
/// @throws FileError for a model that is no stone
[[nodiscard]] Stone stone_of_model(const modelling::ObjectModel& model, const ModelledStone& made,
                                   const ModelFieldOptions& options,
                                   const std::vector<Eigen::Vector3d>& up_at_rest = {
                                       Eigen::Vector3d::UnitZ()});
/// Writes into `made` how much of the candidate was seen, and how well.
void describe_model(StoneCandidate& candidate);
/// Models the stones anew with what one more survey shows of those that were moved, or seen in one survey
/// only: joined with what was seen of them before where both share enough; of the last survey alone, as the
/// stone lies, where they do not, until a later one shows how both belong together.
/// @param last lasts as long as the candidates
void model_again(const modelling::AlignedScene& last, const CellLayout& layout,
                 const ModelFieldOptions& options, std::vector<StoneCandidate>& candidates);

}  // namespace stonestack::stacking
