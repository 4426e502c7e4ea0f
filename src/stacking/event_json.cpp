#include <nlohmann/json.hpp>

#include "geometry/pose_json.hpp"
#include "stonestack/stacking/event.hpp"

namespace stonestack::stacking {
namespace {

using nlohmann::json;
using Record = std::pair<std::string, json>;

/// One event after the other for the journal; an empty kind: not recorded.
struct Records {
  const Catalogue& catalogue;

  [[nodiscard]] const std::string& name(StoneIndex stone) const { return catalogue[stone].name; }
  [[nodiscard]] json list(const std::vector<StoneEstimate>& stones) const {
    json array = json::array();
    for (const auto& stone : stones)
      array.push_back({{"stone", name(stone.stone)},
                       {"T_W_O", pose_json(stone.T_W_O_at_rest)},
                       {"T_W_O_seen", pose_json(stone.T_W_O_seen)}});
    return array;
  }
  [[nodiscard]] json placement(const Placement& p) const {
    return {{"stone", name(p.stone)}, {"T_W_O", pose_json(p.T_W_O)}, {"cost", p.cost}};
  }

  template <class Other>
  Record operator()(const Other&) const {
    return {};
  }
  Record operator()(const Observed& e) const {
    return {"observed", {{"stack", list(e.world.stack)}, {"loose", list(e.world.loose)}}};
  }
  Record operator()(const WallMeasured& e) const {
    return {"wall",
            {{"placed", e.wall.placed},
             {"length_m", e.wall.length},
             {"height_m", e.wall.height},
             {"margin_g", e.wall.margin},
             {"spanned_m", e.wall.spanned},
             {"to_span_m", e.wall.to_span}}};
  }
  [[nodiscard]] json names(const std::vector<StoneIndex>& stones) const {
    json array = json::array();
    for (const StoneIndex stone : stones) array.push_back(name(stone));
    return array;
  }
  Record operator()(const ModellingBegun& e) const {
    return {"model_anew", {{"lost", names(e.lost)}, {"in_sight", e.in_sight}}};
  }
  Record operator()(const StoneModelled& e) const {
    return {"modelled", {{"stone", name(e.stone)}, {e.in_sight ? "instead_of" : "may_be", names(e.lost)}}};
  }
  Record operator()(const StoneMoved& e) const {
    return {"moved", {{"stone", name(e.stone)}, {"shift_m", e.shift}}};
  }
  Record operator()(const UnknownObjectSeen& e) const {
    return {"unknown_object", {{"x_m", e.p_W.x()}, {"y_m", e.p_W.y()}, {"highest_m", e.highest}}};
  }
  Record operator()(const CameraRefined& e) const {
    return {"camera_mount",
            {{"shift_m", e.shift},
             {"turn_rad", e.turn},
             {"marks", e.marks},
             {"before_m", e.before},
             {"after_m", e.after},
             {"table_height_m", e.table_height},
             {"table_tilt_rad", e.table_tilt},
             {"accepted", e.accepted}}};
  }
  Record operator()(const PlaceBegun& e) const { return {"target", placement(e.placement)}; }
  Record operator()(const PushBegun& e) const {
    return {"push", {{"stone", name(e.stone)}, {"distance_m", e.distance}}};
  }
  Record operator()(const SetDownBegun& e) const {
    return {e.reorients ? "reorient" : "unstack", placement(e.placement)};
  }
  Record operator()(const FrictionMeasured& e) const {
    return {"friction", {{"stone", name(e.stone)}, {"on_table", e.friction}}};
  }
  Record operator()(const PlacementJudged& e) const {
    return {"outcome", {{"stone", e.record.stone}, {"outcome", to_text(e.record.outcome)}}};
  }
  Record operator()(const RunEnded& e) const {
    return {"end", {{"end", to_text(e.end)}, {"reason", e.reason}}};
  }
  Record operator()(const StepBegun& e) const { return {"step", {{"name", e.name}}}; }
  Record operator()(const HoldMeasured& e) const {
    return {"hold", {{"weight", e.weight}, {"expected", e.expected}, {"off", e.offset}}};
  }
  Record operator()(const CarriedMeasured& e) const {
    return {"carried",
            {{"weight", e.weight},
             {"expected", e.expected},
             {"off", e.offset},
             {"doubt", e.uncertainty},
             {"held", e.held}}};
  }
  Record operator()(const TouchMeasured& e) const {
    return {"touch", {{"touched", e.touched}, {"force", e.force}, {"above_end_m", e.above_end}}};
  }
  Record operator()(const ReleaseMeasured& e) const {
    return {"released", {{"left", e.weight}, {"most", e.max_weight}}};
  }
  Record operator()(const GripperRetried& e) const { return {"gripper_retried", {{"problem", e.problem}}}; }
};

}  // namespace

std::pair<std::string, std::string> to_record(const Event& event, const Catalogue& catalogue) {
  const auto [kind, data] = std::visit(Records{catalogue}, event);
  return {kind, kind.empty() ? "" : data.dump(-1, ' ', false, json::error_handler_t::replace)};
}

}  // namespace stonestack::stacking
