#include "modelled_stones.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/constants.hpp"
#include "stacking/model_again.hpp"
#include "stacking/turn_stone.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::bench {
namespace {

constexpr int kViewsOfAttitude = 4;  // as `run --unseen` takes
constexpr int kAttitudesTried = 10;  // until one is parted from the table as one object

/// Attitudes of one stone so far, and the model made of them.
struct Growing {
  std::vector<std::unique_ptr<modelling::AlignedScene>> scenes;
  std::vector<modelling::LyingObject>
      made_of;  ///< of which O is the frame of the scan, as well as the views agree
  modelling::ObjectModel model;
  std::vector<Eigen::Vector3d> up_at_rest;
};

/// Pose of the scan where the views show the stone; empty where they show too little of it.
std::optional<Pose> place_of_scan(const Stone& scan, modelling::LyingObject lying, const Pose& T_W_O) {
  modelling::ObjectModel all_seen;
  all_seen.mesh = scan.scan;
  all_seen.seen.assign(scan.scan.vertices.size(), 1);
  lying.T_W_O = T_W_O;
  all_seen.sigma.assign(scan.scan.vertices.size(), 0.0);
  const auto found = modelling::find_turned(all_seen, {}, lying);
  return found ? std::optional(found->T_W_O) : std::nullopt;
}

/// Logs how far from its place an attitude was joined, by where the scan lies in its views and in the first
/// ones.
void log_joint(const Stone& scan, const modelling::LyingObject& first, const modelling::LyingObject& joined,
               const Pose& T_W_O) {
  const auto in_first = place_of_scan(scan, first, first.T_W_O),
             in_joined = place_of_scan(scan, joined, T_W_O);
  if (!in_first || !in_joined) return;
  const Pose off = in_joined->inverse() * joined.T_W_O * first.T_W_O.inverse() * *in_first;
  const Eigen::Vector3d shift = off * scan.mass.p_O_M - scan.mass.p_O_M;
  const auto up = [](const Pose& T) -> Eigen::Vector3d {
    return T.linear().transpose() * Eigen::Vector3d::UnitZ();
  };
  const double tilt = std::acos(std::clamp(up(first.T_W_O).dot(up(T_W_O)), -1.0, 1.0));
  log_info(concat(scan.name, ": an attitude ", std::lround(tilt / kDegree), " deg away is joined ",
                  1e3 * shift.norm(), " mm and ", Eigen::AngleAxisd(off.linear()).angle() / kDegree,
                  " deg off its place"));
}

/// Adds one more attitude; false where it shows no object that is the stone, or none that can be joined.
bool add_attitude(const BenchScene& drawn, const Stone& scan, Growing& growing) {
  auto scene = std::make_unique<modelling::AlignedScene>(modelling::align_scene(drawn.views));
  if (scene->segmentation.objects.size() != 1) return false;
  const Pose T_W_O = drawn.views.front().T_W_C * drawn.truth.front().T_C_O;
  modelling::LyingObject lying{scene.get(), 0, T_W_O};
  if (!growing.made_of.empty()) {
    const auto found = modelling::find_turned(growing.model, growing.made_of, lying);
    log_info(concat(scan.name, ": an attitude that shares ",
                    std::lround(100.0 * stacking::shown_by(growing.model, T_W_O.linear()).shared),
                    " % of what a camera sees with what was seen before is ", found ? "" : "not ", "joined"));
    if (!found) return false;
    lying.T_W_O = found->T_W_O;
    log_joint(scan, growing.made_of.front(), lying, T_W_O);
  }
  growing.made_of.push_back(lying);
  growing.up_at_rest.emplace_back(lying.T_W_O.linear().transpose() * Eigen::Vector3d::UnitZ());
  growing.scenes.push_back(std::move(scene));
  growing.model = modelling::model_object(growing.made_of);
  return true;
}

}  // namespace

std::vector<StoneFromViews> stones_from_views(const SceneMaker& maker, int attitudes, std::uint64_t seed) {
  std::vector<StoneFromViews> made;
  for (const StoneIndex stone : first_stones(maker.stones().size())) {
    throw_if_interrupted();
    const std::string& name = at(maker.stones(), stone).name;
    Growing growing;
    for (int k = 0, joined = 0; k < kAttitudesTried && joined < attitudes; ++k)
      joined += add_attitude(
                    maker.views_around(stone, kViewsOfAttitude, seed * 100 + static_cast<std::uint64_t>(k)),
                    at(maker.stones(), stone), growing)
                    ? 1
                    : 0;
    require(!growing.made_of.empty(), "stone ", name, " is not parted from the table in ", kAttitudesTried,
            " attitudes");
    stacking::ModelledStone says;
    says.name = name;
    const Stone from_views = stacking::stone_of_model(growing.model, says, {}, growing.up_at_rest);
    log_info(concat(name, ": modelled from ", growing.made_of.size(), " attitudes, ",
                    100.0 * growing.model.seen_share, " % of its surface seen"));
    made.push_back({from_views, from_views.T_O_file.inverse()});
  }
  return made;
}

}  // namespace stonestack::bench
