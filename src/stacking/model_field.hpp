#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "stacking/journal.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/modelling/model_objects.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/model_stone.hpp"

/// Private to stacking/: models of stones that nobody scanned, made by the arm's own camera.
namespace stonestack::stacking {

/// How the stones in the field are modelled.
struct ModelFieldOptions {
  modelling::ModellingOptions modelling;
  ModelOptions stone;  ///< density, friction
  MotionOptions motion;
  const Catalogue* known = nullptr;  ///< stones of which some may lie there; null: none
  DetectionOptions detection;        ///< how these are found
  int first_views = 6;               ///< of the stones as they lie
  int turned_views = 4;              ///< each time that some were turned; 0: none is turned
  int turns = 3;                     ///< of a stone, at most
  double view_distance = 0.55;       ///< [m]
};

/// A stone as it was modelled.
struct ModelledStone {
  std::string name;
  bool known = false;                         ///< before: it was recognised, not modelled
  bool turned = false;                        ///< seen on two of its sides
  std::string note;                           ///< why it was not turned, or not found again; empty otherwise
  double seen_share = 0.0;                    ///< of its surface
  double sigma = 0.0;                         ///< median standard deviation of its surface [m]
  int views = 0;                              ///< that show it
  std::optional<double> mass = std::nullopt;  ///< weighed in the gripper [kg]; empty: from the density
  /// Where it lay before anything was moved; empty for a stone of which only the other side is modelled.
  std::optional<Pose> T_W_O_first = std::nullopt;
  std::optional<Pose> T_W_O = std::nullopt;  ///< where it lies at the end; empty: it was not found
};

/// Told of a stone that was modelled while a run went on.
using ModelledHook = std::function<void(const Stone& stone, const ModelledStone& made)>;

/// "stone_1" or, of that form, the first after all names that are taken.
[[nodiscard]] std::string modelled_name(const std::vector<std::string>& taken);

/// Everything that was found out about the stones in the field.
struct ModelledField {
  Catalogue catalogue;  ///< stone_1 and so on; no path
  std::vector<ModelledStone> stones;
  std::vector<std::string> left_out;  ///< objects that no stone was made of, with the reason
  int views = 0;
  double seconds = 0.0;       ///< by the cell's clock [s]
  double apart_before = 0.0;  ///< median distance of surfaces between views, by the arm's report [m]
  double apart_after = 0.0;   ///< once the views agree [m]
  std::string stopped;        ///< why the arm stopped before all was seen; empty: it did not
  bool interrupted = false;   ///< somebody ended it; the models are those from before
};

/// Looks at the field from several sides, parts and models what lies there, sets each stone down on another
/// of its sides and looks again, so that its underside is seen, too; a stone of which much is unseen after
/// that is turned once more. One that cannot be turned is lifted and weighed. Only what stands free, whole
/// and within what the gripper can hold becomes a stone; one of which two looks share too little to be joined
/// is modelled as it lies in the end. Stones that are known are recognised and left as they lie. Nothing else
/// is moved that was not modelled. Once there are models, a stop of the arm or an interruption ends it with
/// these.
/// @throws DeviceError when no view is reached or the arm stops before; Interrupted before.
[[nodiscard]] ModelledField model_field(Cell& cell, const RobotModel& robot,
                                        const ModelFieldOptions& options = {}, Journal* journal = nullptr);

}  // namespace stonestack::stacking
