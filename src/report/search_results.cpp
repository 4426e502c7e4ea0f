#include <algorithm>
#include <cctype>

#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

json placement_json(const Catalogue& catalogue, const Placement& p) {
  json entry = placed_json(catalogue, p.stone, p.T_W_O);
  entry["cost"] = p.cost;
  entry["terms"] = p.terms;
  entry["predicted_success"] = p.predicted_success;
  entry["support"] = {{"area_m2", p.support.area}, {"margin_m", p.support.margin}};
  return entry;
}

json list_of(const Catalogue& catalogue, const std::vector<Placement>& placements) {
  json list = json::array();
  for (const Placement& p : placements) list.push_back(placement_json(catalogue, p));
  return list;
}

json list_of(const Catalogue& catalogue, const std::vector<PlacedStone>& stones) {
  json list = json::array();
  for (const PlacedStone& placed : stones) list.push_back(placed_json(catalogue, placed.stone, placed.T_W_O));
  return list;
}

/// Figures of a wall, and of each stone its course and what it rests on (indices into "placements").
json wall_json(const WallPlan& plan) {
  json stones = json::array();
  for (const WallPlacement& next : plan.placements)
    stones.push_back({{"course", next.course}, {"supports", next.supports}});
  json figures = wall_figures(plan.metrics);
  figures["stones"] = stones;
  figures["candidates"] = plan.candidates;
  figures["seconds"] = plan.seconds;
  return figures;
}

/// Blocks of the target that were there before anything was built.
json supports_json(const SceneSearch& found) {
  json list = json::array();
  for (const PlacedStone& block : found.supports) {
    const Eigen::Vector3d size = bounds(found.catalogue[block.stone].mesh).sizes();
    json entry = placed_json(found.catalogue, block.stone, block.T_W_O);
    entry["size"] = {size.x(), size.y(), size.z()};
    list.push_back(entry);
  }
  return list;
}

/// The stones in the order in which they are built, with what each rests on.
std::string wall_table(const Catalogue& catalogue, const WallPlan& plan, const char* bottom) {
  std::string text = format("%-20s %6s %6s   %-24s position (m)\n", "stone", "course", "p(ok)", "rests on");
  for (const WallPlacement& next : plan.placements) {
    std::string below;
    for (const int k : next.supports)
      below += (below.empty() ? "" : ", ") +
               name_of(catalogue, plan.placements[static_cast<std::size_t>(k)].placement.stone);
    const Eigen::Vector3d p = next.placement.T_W_O.translation();
    text +=
        format("%-20s %6d %6.2f   %-24s %7.4f %7.4f %7.4f\n",
               name_of(catalogue, next.placement.stone).c_str(), next.course + 1,
               next.placement.predicted_success, below.empty() ? bottom : below.c_str(), p.x(), p.y(), p.z());
  }
  return text;
}

std::string wall_text(const WallPlan& plan) {
  return wall_figures_text(plan.metrics) +
         format("; planned in %.1f s a stone\n", plan.seconds / std::max(1, plan.metrics.placed));
}

json frame_json(const SearchStart& start) {
  json frame = {{"defined_by", start.frame}, {"text", start.frame_text}, {"T_W_C", nullptr}};
  if (start.T_W_C) frame["T_W_C"] = pose_json(*start.T_W_C);
  return frame;
}

json point_json(const Eigen::Vector3d& p) {
  return {p.x(), p.y(), p.z()};
}

/// Path to contact, support polygon, cost, terms and outcome.
json candidate_json(const Catalogue& catalogue, const CandidateTrace& candidate) {
  json path = json::array(), corners = json::array();
  for (const Pose& T_W_O : candidate.path_W_O) path.push_back(pose_json(T_W_O));
  for (const Eigen::Vector3d& corner : candidate.support.corners_W) corners.push_back(point_json(corner));
  return {{"stone", name_of(catalogue, candidate.stone)},
          {"outcome", candidate.outcome},
          {"cost", candidate.cost},
          {"terms", candidate.terms},
          {"path_W_O", path},
          {"polygon_W",
           {{"corners", corners},
            {"centroid", point_json(candidate.support.p_W_centroid)},
            {"normal", point_json(candidate.support.n_W)},
            {"area_m2", candidate.support.area},
            {"margin_m", candidate.support.margin},
            {"contacts", candidate.support.contacts}}}};
}

/// A word as a shell takes it.
std::string quoted(const std::string& word) {
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string("_-./,:=+@%").find(c) < 12;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
  std::string result = "'";
  for (const char c : word) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

/// An option of a command line; nothing for one without a value.
std::string with(const char* name, const std::string& value) {
  return value.empty() ? std::string() : concat(' ', name, ' ', quoted(value));
}

}  // namespace

std::string next_command(const SceneSearch& found, const SceneSearchTask& task, const std::string& catalogue,
                         const std::string& out) {
  if (!found.start.seen || found.placements.empty()) return {};
  const std::string stones = with("--catalogue", catalogue);
  if (!out.empty()) return concat("stonestack check ", quoted(out), stones);
  const DepthInput& depth = task.depth;
  const std::string view = concat(with("--units", depth.units == "m" ? "" : depth.units),
                                  with("--depth-unit", depth.unit == 0.0 ? "" : concat(depth.unit)),
                                  with("--camera", depth.camera), with("--distortion", depth.distortion),
                                  with("--frame", depth.frame == 0 ? "" : concat(depth.frame)));
  const std::string again =
      concat("stonestack search ", quoted(task.scene), view, stones, with("--camera-pose", task.camera_pose),
             task.world ? " --world" : "", with("--site", task.site));
  if ((found.start.frame == "camera_pose" || task.world) && task.robot.empty())
    return again + " --robot ur10 --json > next.json";
  return concat(again, with("--robot", task.robot), " --out tower.yaml --picture tower.png");
}

std::string search_json(const SceneSearch& found, int seed, const std::string& next) {
  const SearchProblem& problem = found.start.problem;
  const Catalogue& catalogue = found.catalogue;
  json result = {{"schema", "stonestack.search/1"},
                 {"frame", frame_json(found.start)},
                 {"site", {{"x", problem.site.x()}, {"y", problem.site.y()}}},
                 {"placements", list_of(catalogue, found.placements)},
                 {"alternatives", list_of(catalogue, found.alternatives)},
                 {"stack", list_of(catalogue, problem.stack.stones)},
                 {"loose", list_of(catalogue, problem.available)},
                 {"next", next},
                 {"reason", found.reason},
                 {"repeatable", found.repeatable},
                 {"seed", seed}};
  if (found.wall) result["wall"] = wall_json(*found.wall);
  if (!found.supports.empty()) result["supports"] = supports_json(found);
  return document(result);
}

std::string search_text(const SceneSearch& found, const std::string& next) {
  const SearchStart& start = found.start;
  std::string text;
  if (start.seen) {
    text += "frame  " + start.frame_text;
    if (start.T_W_C) {
      const Eigen::Vector3d p = start.T_W_C->translation();
      text += format("; camera at %.3f %.3f %.3f m", p.x(), p.y(), p.z());
    }
    text += "\nstack  " + start.site_text + "\n";
  }
  if (found.wall) {
    text += wall_table(found.catalogue, *found.wall, found.supports.empty() ? "the table" : "a support") +
            wall_text(*found.wall);
    return next.empty() ? text : text + "next   " + next + "\n";
  }
  text += format("%-20s %8s %6s %10s   position (m)\n", "stone", "cost", "p(ok)", "area (cm2)");
  for (const auto& p : found.placements) {
    const auto& t = p.T_W_O.translation();
    text +=
        format("%-20s %8.3f %6.2f %10.2f   %7.4f %7.4f %7.4f\n", name_of(found.catalogue, p.stone).c_str(),
               p.cost, p.predicted_success, 1e4 * p.support.area, t.x(), t.y(), t.z());
  }
  return next.empty() ? text : text + "next   " + next + "\n";
}

std::string search_trace_json(const SceneSearch& found) {
  json list = json::array();
  if (found.trace)
    for (const CandidateTrace& candidate : *found.trace)
      list.push_back(candidate_json(found.catalogue, candidate));
  return document({{"schema", "stonestack.trace/1"}, {"candidates", list}}, 1);
}

std::vector<PlacedStone> planned_tower(const SceneSearch& found) {
  std::vector<PlacedStone> tower = found.start.problem.stack.stones;
  for (const Placement& p : found.placements) tower.push_back({p.stone, p.T_W_O});
  return tower;
}

SceneFile scene_of(const SceneSearch& found) {
  SceneFile scene;
  for (const PlacedStone& placed : planned_tower(found))
    (found.wall ? scene.wall : scene.stack).push_back({name_of(found.catalogue, placed.stone), placed.T_W_O});
  return scene;
}

}  // namespace stonestack::report
