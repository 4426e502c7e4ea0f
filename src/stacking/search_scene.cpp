#include "stacking/search_scene.hpp"

#include <algorithm>
#include <cmath>

#include "detection/scene/preprocess.hpp"
#include "physics/shape.hpp"
#include "search/detect_missing.hpp"
#include "search/find_stack.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kTableHeight = 0.02;  // m by which the table of a cloud in W may lie off z = 0

std::string in_metres(const Eigen::Vector2d& p) {
  return concat('(', 1e-3 * std::round(1e3 * p.x()), ", ", 1e-3 * std::round(1e3 * p.y()), ") m");
}

std::string names(const Catalogue& catalogue, const std::vector<PlacedStone>& stones) {
  std::string list;
  for (const PlacedStone& placed : stones) list += (list.empty() ? "" : ", ") + catalogue[placed.stone].name;
  return list;
}

/// The problem's shapes: of these stones alone.
void set_shapes(const Catalogue& catalogue, std::vector<StoneIndex> indices, SearchStart& start) {
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  std::vector<Stone> stones;
  for (const StoneIndex i : indices) stones.push_back(catalogue[i]);
  const auto by_index = [&](const ShapeList& made) {
    ShapeList shapes(catalogue.stones.size());
    for (std::size_t i = 0; i < indices.size(); ++i) at(shapes, indices[i]) = made[i];
    return shapes;
  };
  start.shapes = std::make_shared<const ShapeList>(by_index(make_contact_shapes(stones)));
  start.problem.shapes = start.shapes.get();
  std::vector<ShapeList> possible;
  for (const ShapeList& made : make_possible_shapes(stones)) possible.push_back(by_index(made));
  start.possible_shapes = std::make_shared<const std::vector<ShapeList>>(std::move(possible));
  start.problem.possible_shapes = start.possible_shapes.get();
}

std::vector<StoneIndex> indices_of(const std::vector<PlacedStone>& stones) {
  std::vector<StoneIndex> indices;
  for (const PlacedStone& placed : stones) indices.push_back(placed.stone);
  return indices;
}

void add_shapes(const Catalogue& catalogue, SearchStart& start) {
  std::vector<StoneIndex> wanted = indices_of(start.problem.stack.stones);
  for (const StoneIndex i : indices_of(start.problem.available)) wanted.push_back(i);
  set_shapes(catalogue, std::move(wanted), start);
}

SearchStart start_from_names(const SceneSearchTask& input, const Catalogue& catalogue) {
  require(!input.stones.empty(), "no scene and no stones; give SCENE, --stones a,b,c or --stones all");
  SearchStart start;
  if (input.stones == "all")
    for (std::size_t i = 0; i < catalogue.stones.size(); ++i)
      start.problem.available.push_back({StoneIndex(i), Pose::Identity()});
  else
    for (const auto& name : split_list(input.stones))
      start.problem.available.push_back({catalogue.index(name), Pose::Identity()});
  start.frame = "cell", start.frame_text = "the cell's world: z up, table at z = 0";
  add_shapes(catalogue, start);
  return start;
}

/// Empty for a scene file without stones, whose view is to be searched.
std::optional<SearchStart> start_from_poses(const SceneSearchTask& input, const Catalogue& catalogue) {
  const SceneFile scene = read_scene_file(input.scene);
  SearchStart start;
  for (const auto& item : scene.stack)
    start.problem.stack.stones.push_back({catalogue.index(item.stone), item.T_W_O});
  for (const auto& item : scene.stones)
    start.problem.available.push_back({catalogue.index(item.stone), item.T_W_O});
  if (!scene.wall.empty())
    throw FileError(input.scene, "holds a wall, and a search goes on from a tower",
                    "check it: stonestack check");
  if (start.problem.stack.stones.empty() && start.problem.available.empty()) {
    if (scene.depth_file.empty() && scene.cloud_file.empty())
      throw FileError(input.scene, "has no stones, no depth and no cloud",
                      "add stones with their poses or a view of them");
    return std::nullopt;
  }
  start.frame = "scene_file", start.frame_text = "the scene file's world: z up, table at z = 0";
  add_shapes(catalogue, start);
  return start;
}

/// Refuses a cloud in W whose table is not at z = 0.
void check_height(const SceneView& view, const Plane& table_C, const std::string& path) {
  const Eigen::Vector3d n_W = view.T_W_C->linear() * table_C.normal;
  const double z = (table_C.offset + n_W.dot(view.T_W_C->translation()) -
                    n_W.head<2>().dot(view.T_W_C->translation().head<2>())) /
                   n_W.z();
  if (std::abs(z) > kTableHeight)
    throw FileError(path,
                    concat("was taken as in the world frame, but its table lies at z = ",
                           1e-3 * std::round(1e3 * z), " m"),
                    "move it so that the table is at z = 0, or give it in the camera's optical frame");
}

/// Where W is for a view; the table is empty where none is seen.
SearchStart frame_of(const SceneView& view, const std::optional<Plane>& table_C,
                     const SceneSearchTask& input) {
  SearchStart start;
  start.seen = true;
  if (view.world) {
    check_level(view, table_C, input.scene);
    if (table_C) check_height(view, *table_C, input.scene);
    start.frame = "world_cloud", start.frame_text = "the cloud's own: z up, table at z = 0";
  } else if (view.T_W_C) {
    start.frame = "camera_pose", start.T_W_C = view.T_W_C;
    start.frame_text = "that of the camera's pose: z up, table at z = 0";
  } else {
    if (!table_C)
      throw FileError(input.scene, "shows no table and has no camera pose",
                      "record it with more of the table in view, or give --camera-pose");
    start.frame = "table", start.T_W_C = camera_over(*table_C);
    start.frame_text =
        "the table that is seen is z = 0, z up, origin below the camera, x along the image's x";
  }
  return start;
}

/// An arm needs W to be that of its cell.
void refuse_unknown_world(const SceneView& view, const SceneSearchTask& input) {
  if (input.robot.empty() || input.world || (view.T_W_C && !view.world)) return;
  throw InvalidArgument(
      view.world
          ? concat("--robot: ", input.scene,
                   " does not say where the arm stands in its frame; give --world if that is the cell's "
                   "(the arm's base is its origin)")
          : concat("--robot: ", input.scene,
                   " does not say where its camera stood; give --camera-pose x,y,z,qx,qy,qz,qw in the "
                   "cell's world (the arm's base is its origin)"));
}

/// Refuses a view in which not all that stands there was found: no proposal is made on it.
[[noreturn]] void refuse_incomplete(const SceneSearchTask& input, const std::string& note) {
  throw Error(concat(input.scene, ": ", note, "; take another view, rather from the side, or clear the table",
                     input.site.empty() ? ", or give --site x,y for a tower away from it" : ""),
              ExitCode::kNoStablePose);
}

/// Sorts the stones and sets the site: as asked, where a tower stands, or the best place in view.
void set_stack(const SceneSearchTask& input, const Catalogue& catalogue,
               const std::vector<PlacedStone>& placed, const TableView& table, SearchStart& start) {
  const bool in_cell = input.world || start.frame == "camera_pose";
  std::optional<Eigen::Vector2d> site;
  if (!input.site.empty())
    site = parse_point(input.site);
  else if (in_cell)
    site = CellLayout{}.site;
  SortedStones sorted = find_stack(*start.shapes, placed, site, table.above_W);
  if (!sorted.note.empty()) refuse_incomplete(input, sorted.note);
  if (sorted.stack.empty() && input.site.empty() && site) {
    SortedStones elsewhere = find_stack(*start.shapes, placed, std::nullopt, table.above_W);
    if (!elsewhere.note.empty()) refuse_incomplete(input, elsewhere.note);
    if (!elsewhere.stack.empty()) {
      log_info(
          concat("no stone stands at the cell's site ", in_metres(*site), "; building on the tower in view"));
      sorted = std::move(elsewhere);
      site.reset();
    }
  }
  if (!sorted.unsupported.empty())
    log_warning(concat("left where they are, for nothing that was found carries them: ",
                       names(catalogue, sorted.unsupported)));
  if (!sorted.carrying.empty())
    log_info(
        concat("left where they are, for other stones lie on them: ", names(catalogue, sorted.carrying)));
  for (const UnknownThing& thing : sorted.unknown)
    log_warning(concat("not recognised, and left alone: something at ", in_metres(thing.p_W), ", ",
                       std::round(1e3 * thing.highest), " mm high"));
  start.problem.stack.stones = sorted.stack;
  start.problem.available = sorted.available;
  if (!sorted.stack.empty()) {
    const PlacedStone& base = sorted.stack.front();
    const Eigen::Vector3d p_W_com = base.T_W_O * at(*start.shapes, base.stone)->mass.p_O_M;
    if (!site) site = p_W_com.head<2>();
    start.site_text = concat(names(catalogue, sorted.stack), " stand", sorted.stack.size() == 1 ? "s" : "",
                             " at ", in_metres(p_W_com.head<2>()), ", from the table up");
  } else if (!site) {
    site = choose_site(*start.shapes, placed, sorted.available, table.p_W, table.cell, table.p_W_middle);
    if (!site)
      throw Error(input.scene + ": no place on the table in view is free for a tower; give --site x,y",
                  ExitCode::kNoStablePose);
    start.site_text =
        concat("nothing stands yet; the free place in view nearest to its middle is ", in_metres(*site));
  } else {
    start.site_text = concat("nothing stands at ", in_metres(*site), " yet");
  }
  start.problem.site = *site;
}

/// The stones that were detected, in order; sets their shapes.
std::vector<PlacedStone> placed_stones(const Catalogue& catalogue, const DetectionResult& seen,
                                       const Pose& T_W_C, SearchStart& start) {
  std::vector<PlacedStone> placed;
  for (const auto& found : seen.detections) placed.push_back({found.stone, T_W_C * found.T_C_O});
  std::sort(placed.begin(), placed.end(),
            [](const PlacedStone& a, const PlacedStone& b) { return a.stone < b.stone; });
  set_shapes(catalogue, indices_of(placed), start);
  return placed;
}

SearchStart start_from_view(const SceneSearchTask& input, const Catalogue& catalogue,
                            const DetectionOptions& options) {
  const SceneView view = read_view(input.scene, input.camera_pose, input.world, input.depth);
  refuse_unknown_world(view, input);
  if (const std::string problem = out_of_range(view.image, options); !problem.empty())
    throw Error(input.scene + ": nothing detected: " + problem, ExitCode::kNothingDetected);
  const std::optional<Plane> table_C = find_table(view.image, options);
  SearchStart start = frame_of(view, table_C, input);
  log_info("frame: " + start.frame_text);
  const DetectionModels models(catalogue.stones, options);
  const DetectionResult seen = detect_stones(view.image, models, {}, options);
  if (seen.detections.empty())
    throw Error(input.scene + ": nothing detected: " + seen.note, ExitCode::kNothingDetected);
  const Pose T_W_C = start.T_W_C ? *start.T_W_C : *view.T_W_C;
  const TableView table = table_C ? view_of_table(view.image, *table_C, T_W_C, options) : TableView{};
  std::vector<PlacedStone> placed = placed_stones(catalogue, seen, T_W_C, start);
  if (!find_stack(*start.shapes, placed, std::nullopt, table.above_W).note.empty()) {
    log_info("what was found does not stand by itself; detecting what is missing");
    const DetectionResult all = detect_missing(view.image, models, seen, options);
    SearchStart again = start;
    const std::vector<PlacedStone> more = placed_stones(catalogue, all, T_W_C, again);
    if (find_stack(*again.shapes, more, std::nullopt, table.above_W).note.empty())
      placed = more, start = std::move(again);
  }
  set_stack(input, catalogue, placed, table, start);
  log_info(concat(start.site_text, "; ", start.problem.available.size(), " stones lie loose"));
  return start;
}

}  // namespace

SearchStart read_start(const SceneSearchTask& input, const Catalogue& catalogue) {
  SearchStart start;
  if (input.scene.empty()) {
    start = start_from_names(input, catalogue);
  } else {
    std::optional<SearchStart> given;
    if (is_scene_file(input.scene)) given = start_from_poses(input, catalogue);
    if (!given) return start_from_view(input, catalogue, input.detection);
    start = std::move(*given);
  }
  start.problem.site = input.site.empty() ? CellLayout{}.site : parse_point(input.site);
  return start;
}

}  // namespace stonestack::stacking
