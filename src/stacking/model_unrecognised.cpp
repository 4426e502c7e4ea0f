#include "stacking/model_unrecognised.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "modelling/no_model.hpp"
#include "modelling/rest_on_table.hpp"
#include "search/height_raster.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/model_again.hpp"
#include "stacking/survey.hpp"
#include "stacking/unknown_objects.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::stacking {
namespace {

constexpr int kViewsOfThing = 4;    // at most
constexpr double kWasThere = 0.05;  // m between the middles of a thing that nobody moved, in two observations
constexpr double kMinWidth = 0.025;  // m: what is seen narrower is no stone
constexpr double kBesideAim = 0.06;  // m between the middle of a thing, and of what closer views show of it
constexpr double kExplained = 0.5;   // share of what is seen that lies on a known stone

bool names(const ModelAnew& action, StoneIndex stone) {
  return std::find(action.lost.begin(), action.lost.end(), stone) != action.lost.end();
}

/// Stones that lie where they were seen, without those that an action models where they stand.
Arrangement known_stones(const WorldEstimate& world, const ModelAnew& action) {
  Arrangement known = at_rest(world);
  for (auto* list : {&known.stack, &known.loose})
    std::erase_if(*list, [&](const PlacedStone& placed) { return names(action, placed.stone); });
  return known;
}

/// Does a stone that an action models where it stands stand here?
bool is_of_one_in_sight(const Workcell& w, const WorldEstimate& world, const ModelAnew& action,
                        const UnknownThing& thing) {
  const Arrangement all = at_rest(world);
  return std::any_of(all.stack.begin(), all.stack.end(), [&](const PlacedStone& placed) {
    return names(action, placed.stone) &&
           (com_of(w.models.shapes, placed).head<2>() - thing.p_W).norm() < kBesideAim;
  });
}

/// Things that may be one of the lost stones.
std::vector<UnknownThing> things_to_model(const Workcell& w, const WorldEstimate& world,
                                          const RunMemory& memory, const ModelAnew& action) {
  if (!world.views) return {};
  const Arrangement known = known_stones(world, action);
  std::vector<PlacedStone> stones = known.stack;
  stones.insert(stones.end(), known.loose.begin(), known.loose.end());
  std::vector<UnknownThing> things = unknown_things(w, *world.views, stones);
  std::erase_if(things, [&](const UnknownThing& thing) {
    Eigen::AlignedBox2d ground;
    for (const Eigen::Vector3d& p_W : thing.surface_W) ground.extend(p_W.head<2>().eval());
    if (action.in_sight) return !is_of_one_in_sight(w, world, action, thing);
    return ground.diagonal().norm() < kMinWidth ||
           std::any_of(memory.p_W_objects.begin(), memory.p_W_objects.end(),
                       [&](const Eigen::Vector2d& p_W) { return (thing.p_W - p_W).norm() < kWasThere; });
  });
  return things;
}

/// The largest object near the middle of views that no known stone explains; -1: none.
int object_near(const modelling::AlignedScene& scene, const Eigen::Vector2d& p_W,
                const std::vector<Mesh>& known_W) {
  int best = -1;
  for (int k = 0; k < static_cast<int>(scene.segmentation.objects.size()); ++k) {
    const auto& seen = scene.segmentation.objects[static_cast<std::size_t>(k)];
    const auto explains = [&](const Mesh& stone_W) {
      return share_on(seen.cloud_C, scene.views.front().T_W_C, stone_W) > kExplained;
    };
    if ((middle_of_object(scene, k).head<2>() - p_W).norm() < kBesideAim &&
        (best < 0 || seen.pixels > scene.segmentation.objects[static_cast<std::size_t>(best)].pixels) &&
        std::none_of(known_W.begin(), known_W.end(), explains))
      best = k;
  }
  return best;
}

/// Names that another stone of the run must not get.
std::vector<std::string> names_taken(const Workcell& w, const ModelledField& field) {
  std::vector<std::string> taken;
  for (const Stone& stone : w.models.catalogue->stones) taken.push_back(stone.name);
  for (const Stone& stone : field.catalogue.stones) taken.push_back(stone.name);
  return taken;
}

/// Height of the upper side of a mesh.
modelling::HeightBelow height_of(const Mesh& mesh_W) {
  constexpr double kCell = 0.001;  // m
  const Eigen::AlignedBox3d box = bounds(mesh_W);
  const int half = static_cast<int>(std::ceil(0.5 * box.sizes().head<2>().maxCoeff() / kCell)) + 1;
  search::HeightRaster raster(box.center().head<2>(), kCell, half);
  search::raise_to(raster, mesh_W.vertices, mesh_W.faces);
  return [raster = std::move(raster)](const Eigen::Vector2d& p_W) -> std::optional<double> {
    const Eigen::Vector2d at = (p_W - raster.centre) / raster.cell;
    const auto i = static_cast<int>(std::lround(at.x())), j = static_cast<int>(std::lround(at.y()));
    if (std::abs(i) > raster.half || std::abs(j) > raster.half) return std::nullopt;
    const float z = raster.z[static_cast<std::size_t>(raster.index(i, j))];
    return z > search::kNoSurface ? std::optional(static_cast<double>(z)) : std::nullopt;
  };
}

/// The stone on top of others, with its unseen underside so that it rests where it is seen.
void model_on_stack(const Workcell& w, const WorldEstimate& world, ModelledField& field) {
  const StoneEstimate& top = world.stack.back();
  const StoneEstimate& below = world.stack[world.stack.size() - 2];
  const Stone& before = w.models.stone(top.stone);
  StoneCandidate candidate;
  candidate.model.mesh = transformed(before.scan, top.T_W_O_seen);
  candidate.model.seen = before.surface->seen;
  candidate.model.sigma = before.surface->sigma;
  double seen = 0.0;
  for (const char one : candidate.model.seen) seen += one;
  candidate.model.seen_share = seen / static_cast<double>(candidate.model.seen.size());
  modelling::rest_on(candidate.model,
                     height_of(transformed(w.models.stone(below.stone).scan, below.T_W_O_at_rest)));
  candidate.made.name = modelled_name(names_taken(w, field));
  candidate.made.mass = before.mass.mass;
  ModelFieldOptions options;
  options.stone.friction = w.options.search.friction;
  try {
    candidate.stone = stone_of_model(candidate.model, candidate.made, options, {Eigen::Vector3d::UnitZ()});
  } catch (const FileError& problem) {
    field.left_out.push_back(concat(before.name, ", as it rests: ", problem.what()));
    return;
  }
  describe_model(candidate);
  candidate.made.note = "its underside as it rests on the tower";
  candidate.made.T_W_O = candidate.stone.T_O_file.inverse();
  field.stones.push_back(std::move(candidate.made));
  field.catalogue.stones.push_back(std::move(candidate.stone));
}

/// One thing after the other.
class Modeller {
 public:
  Modeller(Workcell& w, const WorldEstimate& world, std::vector<UnknownThing> things, const ModelAnew& action,
           Journal* journal)
      : w_(w), things_(std::move(things)), in_sight_(action.in_sight), journal_(journal) {
    options_.motion = w.options.motion;
    options_.modelling.segment.seed = w.options.detection.seed;
    options_.stone.friction = w.options.search.friction;
    const Arrangement arrangement = known_stones(world, action);
    scene_ = make_planning_scene(w.cell.layout, *w.models.robot, *w.models.catalogue, arrangement);
    for (const UnknownThing& thing : things_) {
      Obstacle obstacle = obstacle_about(thing, concat("thing ", scene_.objects.size()));
      scene_.objects.push_back({obstacle.name, std::move(obstacle.pieces), Pose::Identity()});
    }
    for (const auto* list : {&arrangement.stack, &arrangement.loose})
      for (const PlacedStone& stone : *list)
        known_W_.push_back(transformed(w.models.stone(stone.stone).mesh, stone.T_W_O));
  }

  [[nodiscard]] const std::vector<UnknownThing>& things() const { return things_; }

  /// Adds the stone that a thing is, or why it is none.
  void model(const UnknownThing& thing, std::optional<double> mass, ModelledField& field) {
    const Eigen::Vector3d p_W(thing.p_W.x(), thing.p_W.y(), 0.5 * thing.highest);
    scene_.opening = present_opening(w_.cell, scene_.gripper);
    const auto taken = survey_if_reached(w_.cell, scene_, dome_over(p_W), p_W, kViewsOfThing,
                                         options_.view_distance, options_.motion, journal_);
    field.views += static_cast<int>(taken.size());
    std::string why =
        taken.empty() ? "no view of it is reached" : "closer views show nothing but known stones";
    if (!taken.empty()) {
      std::vector<DepthView> views;
      for (const SurveyView& view : taken) views.push_back({view.view.image, view.view.T_W_C});
      const modelling::AlignedScene scene = modelling::align_scene(views, options_.modelling);
      const int object = object_near(scene, thing.p_W, known_W_);
      if (object >= 0) why = add(scene, object, mass, field);
    }
    if (!why.empty())
      field.left_out.push_back(concat("object at (", thing.p_W.x(), ", ", thing.p_W.y(), ") m: ", why));
  }

 private:
  /// Why it is none; empty: it is added.
  std::string add(const modelling::AlignedScene& scene, int object, std::optional<double> mass,
                  ModelledField& field) {
    if (std::string why = unfit_view(scene, object); !why.empty()) return why;
    StoneCandidate candidate;
    const modelling::LyingObject lying{&scene, object};
    candidate.made.name = modelled_name(names_taken(w_, field));
    candidate.made.mass = mass;
    std::optional<modelling::ObjectModel> model = modelling::model_object({&lying, 1}, options_.modelling);
    if (!model) return modelling::kNoModel;
    candidate.model = std::move(*model);
    try {
      if (in_sight_) modelling::rest_on_table(candidate.model);
      candidate.stone = stone_of_model(candidate.model, candidate.made, options_);
    } catch (const FileError& problem) {
      return problem.what();
    }
    if (std::string why = unfit_for_gripper(candidate.stone, scene_.gripper, *w_.models.robot);
        !why.empty() && !in_sight_)
      return why;
    describe_model(candidate);
    candidate.made.note = "modelled from one side while the run went on";
    candidate.made.T_W_O = candidate.stone.T_O_file.inverse();
    known_W_.push_back(transformed(candidate.stone.mesh, *candidate.made.T_W_O));
    field.stones.push_back(std::move(candidate.made));
    field.catalogue.stones.push_back(std::move(candidate.stone));
    return {};
  }

  Workcell& w_;
  std::vector<UnknownThing> things_;
  bool in_sight_;  ///< of a stone that stands where it is to stay
  Journal* journal_;
  ModelFieldOptions options_;
  PlanningScene scene_;
  std::vector<Mesh> known_W_;  ///< stones where they are
};

}  // namespace

ModelledField model_unrecognised(Workcell& w, const WorldEstimate& world, const RunMemory& memory,
                                 const ModelAnew& action, Journal* journal) {
  const std::vector<StoneIndex>& lost = action.lost;
  ModelledField field;
  const double start = w.cell.clock.now();
  if (action.in_sight && world.stack.size() > 1 && world.stack.back().stone == lost.front()) {
    model_on_stack(w, world, field);
    return field;
  }
  Modeller modeller(w, world, things_to_model(w, world, memory, action), action, journal);
  const bool same_stone = lost.size() == 1 && modeller.things().size() == 1;
  for (const UnknownThing& thing : modeller.things()) {
    throw_if_interrupted();
    if (field.stones.size() == lost.size()) break;
    modeller.model(thing, same_stone ? std::optional(w.models.stone(lost.front()).mass.mass) : std::nullopt,
                   field);
  }
  field.seconds = w.cell.clock.now() - start;
  w.seconds.motion += field.seconds;
  return field;
}

}  // namespace stonestack::stacking
