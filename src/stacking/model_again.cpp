#include "stacking/model_again.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/quantile.hpp"
#include "geometry/surface_tree.hpp"
#include "modelling/surface_known.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::stacking {
namespace {

using modelling::AlignedScene;
using modelling::LyingObject;
using modelling::ObjectModel;

constexpr double kBesideField = 0.06;    // m beyond it: stones roll
constexpr int kFewViews = 3;             // an object that no more than one in so many views shows is none
constexpr double kMinConfidence = 0.5;   // of an object, that it is one and whole
constexpr double kOtherAttitude = 0.35;  // rad between two attitudes on different sides
constexpr double kSameObject = 0.12;     // m between where an object is expected and seen

/// Upwards while it lay like that, in the frame of the model.
Eigen::Vector3d up_of(const LyingObject& lying) {
  return lying.T_W_O.linear().transpose() * Eigen::Vector3d::UnitZ();
}

bool same_attitude(const LyingObject& a, const LyingObject& b) {
  return up_of(a).dot(up_of(b)) > std::cos(kOtherAttitude);
}

/// Models a stone by what was seen of it as `made_of`; false, and the stone as before, where that is no
/// stone.
bool become(StoneCandidate& candidate, const std::vector<LyingObject>& made_of,
            const ModelFieldOptions& options) {
  std::optional<ObjectModel> model = modelling::model_object(made_of, options.modelling);
  if (!model) return false;
  std::vector<Eigen::Vector3d> up;
  for (const LyingObject& lying : made_of)
    if (std::none_of(&made_of.front(), &lying,
                     [&](const LyingObject& before) { return same_attitude(before, lying); }))
      up.push_back(up_of(lying));
  try {
    candidate.stone = stone_of_model(*model, candidate.made, options, up);
  } catch (const FileError& problem) {
    log_debug(concat(candidate.stone.name, ", of ", made_of.size(), " surveys: ", problem.what()));
    return false;
  }
  candidate.made.turned = up.size() > 1;
  candidate.model = std::move(*model);
  candidate.made_of = made_of;
  describe_model(candidate);
  return true;
}

/// Notes where a stone lies, as it was seen.
void lies(StoneCandidate& candidate, const Pose& T_W_model) {
  candidate.T_W_O = T_W_model * candidate.stone.T_O_file.inverse();
  candidate.moved = false;
  candidate.seen_W.clear();
  candidate.p_W_seen.reset();
}

/// Models a stone from the last survey alone where it shares too little with what was seen of it before: it
/// was turned upside down. Its other side is lost for now, but it can be found and picked as it lies.
void model_as_it_lies(const AlignedScene& last, const CellLayout& layout, const ModelFieldOptions& options,
                      StoneCandidate& candidate, std::vector<bool>& taken) {
  candidate.made.note = "not recognised after it was turned: modelled from one side";
  int object = -1;
  double nearest = kSameObject;
  for (int k = 0; k < static_cast<int>(taken.size()); ++k) {
    const double off = (middle_of_object(last, k).head<2>() - place_on_table(candidate)).norm();
    if (!taken[static_cast<std::size_t>(k)] && off < nearest && unfit_object(last, k, layout).empty())
      nearest = off, object = k;
  }
  if (object >= 0) {
    const std::vector<LyingObject> before = candidate.made_of;
    if (become(candidate, {{&last, object, Pose::Identity()}}, options)) {
      lies(candidate, Pose::Identity());
      candidate.apart.insert(candidate.apart.end(), before.begin(), before.end());
      candidate.up_tried.clear();
      candidate.T_model_T_failed.clear();
      taken[static_cast<std::size_t>(object)] = true;
      return;
    }
  }
  if (!candidate.made.mass) return;  // its shape is as before, its mass is known better
  const Pose T_W_model_before = candidate.T_W_O * candidate.stone.T_O_file;
  candidate.stone = stone_of_model(candidate.model, candidate.made, options);
  candidate.T_W_O = T_W_model_before * candidate.stone.T_O_file.inverse();
}

/// Models a stone from what was seen of it before and as that object of the last survey; false, and the stone
/// as before, where both together are no stone: they do not show the same one, or not in that pose.
bool join(const LyingObject& seen, const ModelFieldOptions& options, StoneCandidate& candidate) {
  const bool fell_back = candidate.let_go && same_attitude(candidate.made_of.back(), seen);
  std::vector<LyingObject> both = candidate.made_of;
  both.push_back(seen);
  if (!become(candidate, both, options)) return false;
  lies(candidate, seen.T_W_O);
  candidate.found_again = true;
  if (candidate.made.turned)
    candidate.made.note.clear();
  else if (fell_back)
    candidate.made.note = "fell back on the side on which it lay";
  return true;
}

/// Joins what was seen of a stone's other side before, now that more of it is known.
void join_apart(const ModelFieldOptions& options, StoneCandidate& candidate) {
  for (auto lying = candidate.apart.begin(); lying != candidate.apart.end();) {
    const auto found = modelling::find_turned(candidate.model, candidate.made_of, *lying);
    if (!found) {
      ++lying;
      continue;
    }
    const Pose T_W_model = candidate.T_W_O * candidate.stone.T_O_file;
    std::vector<LyingObject> all = candidate.made_of;
    all.insert(all.end() - 1, {lying->scene, lying->object, found->T_W_O});
    lying = candidate.apart.erase(lying);
    if (!become(candidate, all, options)) continue;
    candidate.T_W_O = T_W_model * candidate.stone.T_O_file.inverse();
    candidate.made.note.clear();
  }
}

/// A candidate that may be an object of the last survey.
struct Match {
  std::size_t candidate = 0;
  LyingObject seen;
  double confirmed = 0.0;
};

/// All objects near where a candidate should lie that may be it.
std::vector<Match> matches_of(const AlignedScene& last, const std::vector<StoneCandidate>& candidates,
                              const std::vector<bool>& taken) {
  std::vector<Match> matches;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const StoneCandidate& candidate = candidates[k];
    if (!is_looked_for(candidate)) continue;
    const Pose T_W_model = candidate.T_W_O * candidate.stone.T_O_file;
    for (int object = 0; object < static_cast<int>(taken.size()); ++object) {
      throw_if_interrupted();
      if (taken[static_cast<std::size_t>(object)] ||
          (middle_of_object(last, object).head<2>() - place_on_table(candidate)).norm() > kSameObject)
        continue;
      const auto found =
          modelling::find_turned(candidate.model, candidate.made_of, {&last, object, T_W_model});
      if (!found) continue;
      log_debug(concat(candidate.stone.name, ": may be object ", object + 1, ", agreement ", found->agreement,
                       ", apart ", found->apart * 1e3, " mm, ", found->confirmed, " places confirmed"));
      matches.push_back({k, {&last, object, found->T_W_O}, found->confirmed});
    }
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& a, const Match& b) { return a.confirmed > b.confirmed; });
  return matches;
}

/// Objects that show a stone which is not looked for.
std::vector<bool> taken_objects(const AlignedScene& last, const std::vector<StoneCandidate>& candidates) {
  constexpr double kShows = 0.5;  // of what is seen
  std::vector<bool> taken(last.segmentation.objects.size(), false);
  for (const StoneCandidate& candidate : candidates) {
    if (is_looked_for(candidate)) continue;
    const Mesh lies_W = transformed(candidate.stone.mesh, candidate.T_W_O);
    for (std::size_t object = 0; object < taken.size(); ++object)
      if (share_on(last.segmentation.objects[object].cloud_C, last.views.front().T_W_C, lies_W) > kShows)
        taken[object] = true;
  }
  return taken;
}

}  // namespace

bool is_looked_for(const StoneCandidate& candidate) {
  return !candidate.made.known && (candidate.moved || candidate.made_of.size() == 1);
}

Eigen::Vector2d place_on_table(const StoneCandidate& candidate) {
  return candidate.p_W_seen.value_or(candidate.T_W_O.translation().head<2>());
}

Eigen::Vector3d middle_of_object(const AlignedScene& scene, int object) {
  const auto& seen = scene.segmentation.objects[static_cast<std::size_t>(object)];
  return scene.views.front().T_W_C * seen.p_C_middle;
}

double share_on(const Cloud& cloud_C, const Pose& T_W_C, const Mesh& surface_W) {
  constexpr double kNear = 0.01;  // m
  constexpr std::size_t kAsked = 200;
  const SurfaceTree surface(surface_W);
  const std::size_t stride = std::max<std::size_t>(1, cloud_C.points.size() / kAsked);
  double asked = 0, near = 0;
  for (std::size_t i = 0; i < cloud_C.points.size(); i += stride, ++asked)
    if (surface.nearest(T_W_C * cloud_C.points[i].cast<double>()).distance < kNear) ++near;
  return asked > 0 ? near / asked : 0.0;
}

bool is_of_known(const AlignedScene& scene, int object, std::span<const StoneCandidate> candidates) {
  constexpr double kExplained = 0.5;  // of what is seen
  const auto& seen = scene.segmentation.objects[static_cast<std::size_t>(object)];
  return std::any_of(candidates.begin(), candidates.end(), [&](const StoneCandidate& candidate) {
    return candidate.made.known &&
           share_on(seen.cloud_C, scene.views.front().T_W_C, candidate.model.mesh) > kExplained;
  });
}

std::string unfit_object(const AlignedScene& scene, int object, const CellLayout& layout) {
  const Eigen::Vector2d off =
      (middle_of_object(scene, object).head<2>() - layout.field_centre).cwiseAbs() - 0.5 * layout.field_size;
  if (off.maxCoeff() > kBesideField) return "lies beside the field";
  return unfit_view(scene, object);
}

std::string unfit_view(const AlignedScene& scene, int object) {
  const auto& seen = scene.segmentation.objects[static_cast<std::size_t>(object)];
  if (seen.cut_off && seen.views < 2) return "is seen in part only";
  if (const auto views = static_cast<int>(scene.views.size()); kFewViews * seen.views <= views)
    return concat("is seen as an object in ", seen.views, " of ", views,
                  " views only: a part of another, or an edge");
  if (seen.confidence < kMinConfidence)
    return concat("may be several or a part of one: confidence ", seen.confidence);
  return {};
}

Stone stone_of_model(const ObjectModel& model, const ModelledStone& made, const ModelFieldOptions& options,
                     const std::vector<Eigen::Vector3d>& up_at_rest) {
  ModelOptions stone;
  stone.density = options.stone.density;
  stone.friction = options.stone.friction;
  stone.mass = made.mass.value_or(0.0);
  Stone made_of = model_stone(model.mesh, made.name, "modelled by the arm's camera", stone).stone;
  made_of.surface = modelling::surface_known(made_of, model, up_at_rest);
  return made_of;
}

void describe_model(StoneCandidate& candidate) {
  candidate.made.seen_share = candidate.model.seen_share;
  candidate.made.views = candidate.model.views;
  candidate.made.sigma = quantile(candidate.model.sigma, 0.5);
}

void model_again(const AlignedScene& last, const CellLayout& layout, const ModelFieldOptions& options,
                 std::vector<StoneCandidate>& candidates) {
  std::vector<bool> taken = taken_objects(last, candidates);
  for (StoneCandidate& candidate : candidates) candidate.found_again = false;
  for (const Match& match : matches_of(last, candidates, taken)) {
    StoneCandidate& candidate = candidates[match.candidate];
    const auto object = static_cast<std::size_t>(match.seen.object);
    if (!candidate.found_again && !taken[object] && join(match.seen, options, candidate))
      taken[object] = true;
  }
  for (StoneCandidate& candidate : candidates) {
    throw_if_interrupted();
    const bool lost = candidate.moved && !candidate.found_again;
    if (lost) model_as_it_lies(last, layout, options, candidate, taken);
    if (!candidate.moved && (lost || candidate.found_again)) join_apart(options, candidate);
  }
}

}  // namespace stonestack::stacking
