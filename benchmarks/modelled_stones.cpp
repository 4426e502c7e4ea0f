#include "modelled_stones.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/constants.hpp"
#include "core/quantile.hpp"
#include "geometry/surface_tree.hpp"
#include "stacking/model_again.hpp"
#include "stacking/turn_stone.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::bench {
namespace {

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

/// Angle between the upward directions of two attitudes [rad].
double tilt_between(const Eigen::Matrix3d& R_W_a, const Eigen::Matrix3d& R_W_b) {
  return std::acos(std::clamp(R_W_a.row(2).dot(R_W_b.row(2)), -1.0, 1.0));
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
  log_info(concat(scan.name, ": an attitude ",
                  std::lround(tilt_between(first.T_W_O.linear(), T_W_O.linear()) / kDegree),
                  " deg away is joined ", 1e3 * shift.norm(), " mm and ",
                  Eigen::AngleAxisd(off.linear()).angle() / kDegree, " deg off its place"));
}

/// Adds one more attitude; false where it shows no object that is the stone, or none that can be joined.
bool add_attitude(const BenchScene& drawn, const Stone& scan, double min_tilt, Growing& growing) {
  const Pose T_W_O = drawn.views.front().T_W_C * drawn.truth.front().T_C_O;
  if (!growing.made_of.empty() &&
      tilt_between(growing.made_of.front().T_W_O.linear(), T_W_O.linear()) < min_tilt)
    return false;
  auto scene = std::make_unique<modelling::AlignedScene>(modelling::align_scene(drawn.views));
  if (scene->segmentation.objects.size() != 1) return false;
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
  auto model = modelling::model_object(growing.made_of);
  if (!model) {
    growing.made_of.pop_back();
    return false;
  }
  growing.up_at_rest.emplace_back(lying.T_W_O.linear().transpose() * Eigen::Vector3d::UnitZ());
  growing.scenes.push_back(std::move(scene));
  growing.model = std::move(*model);
  return true;
}

/// Distances of a model's surface from the scan, as text.
std::string errors_of(const Stone& model, const Mesh& scan) {
  const SurfaceTree truth(scan);
  const Pose T_scan_O = model.T_O_file.inverse();
  std::vector<double> seen, all;
  for (std::size_t v = 0; v < model.scan.vertices.size(); ++v) {
    all.push_back(1e3 * std::abs(truth.nearest(T_scan_O * model.scan.vertices[v]).distance));
    if (model.surface && model.surface->seen[v] != 0) seen.push_back(all.back());
  }
  if (seen.empty()) return "none of it as it was seen";
  return concat("that is ", core::quantile(seen, 0.5), " mm off the scan in the median, all of it ",
                core::quantile(all, 0.95), " mm at 95 %");
}

}  // namespace

std::vector<StoneFromViews> stones_from_views(const SceneMaker& maker, const AttitudesSeen& seen,
                                              std::uint64_t seed) {
  require(!seen.attitudes.empty(), "stones are modelled from one attitude or more");
  std::vector<StoneFromViews> made;
  for (const StoneIndex stone : first_stones(maker.stones().size())) {
    throw_if_interrupted();
    const std::string& name = at(maker.stones(), stone).name;
    Growing growing;
    const int wanted = seen.attitudes[made.size() % seen.attitudes.size()];
    for (int k = 0, joined = 0; k < kAttitudesTried && joined < wanted; ++k)
      joined += add_attitude(maker.views_around(stone, seen.views, seed * 100 + static_cast<std::uint64_t>(k),
                                                {}, seen.camera_tilt),
                             at(maker.stones(), stone), seen.min_tilt, growing)
                    ? 1
                    : 0;
    require(!growing.made_of.empty(), "stone ", name, " is not parted from the table in ", kAttitudesTried,
            " attitudes");
    stacking::ModelledStone says;
    says.name = name;
    says.mass = at(maker.stones(), stone).mass.mass;
    const Stone from_views = stacking::stone_of_model(growing.model, says, {}, growing.up_at_rest);
    log_info(concat(name, ": modelled from ", growing.made_of.size(), " attitudes, ",
                    std::lround(100.0 * growing.model.seen_share), " % of its surface seen, ",
                    errors_of(from_views, at(maker.stones(), stone).scan)));
    made.push_back({from_views, from_views.T_O_file.inverse(), growing.made_of.front().T_W_O.linear()});
  }
  return made;
}

}  // namespace stonestack::bench
