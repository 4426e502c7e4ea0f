/// The Python module `stonestack`: what the command does, with numpy arrays. stonestack-stubs documents it.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "calls.hpp"
#include "inputs.hpp"
#include "segmentation.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/report/results.hpp"
#include "stonestack/stacking/observe.hpp"
#include "stonestack/stacking/scene_tasks.hpp"
#include "version.hpp"

namespace stonestack::python {
namespace {

namespace py = pybind11;
using namespace core;
using namespace geometry;
using namespace stone;
using namespace kinematics;
using namespace detection;
using namespace motion;
using namespace hardware;
using namespace search;
using namespace stacking;
using namespace simulation;
using namespace experiment;
using namespace report;

/// A text or a path; None: empty.
std::string path_or_text(const py::object& given) {
  return given.is_none() ? "" : py::str(given).cast<std::string>();
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ",") + name;
  return text;
}

// Scenes

struct Scene {
  CataloguePtr catalogue;
  SimulatedScene scene;
};

Scene render(const std::string& out, const py::object& stones, std::optional<int> seed,
             const py::object& given, const py::dict& options) {
  SceneOptions scene;
  set_options(join({nest("scene", fields(scene)), nest("simulation", fields(scene.simulation))}), seed,
              options);
  Scene made{catalogue_of(given), {}};
  const Catalogue& catalogue = *made.catalogue;
  std::vector<StoneIndex> present;
  for (const auto& name : names_of(stones)) present.push_back(catalogue.index(name));
  if (present.empty()) present = first_stones(catalogue.stones.size());
  made.scene = call([&] {
    SimulatedScene rendered = render_scene(catalogue.stones, present, CellLayout{}, scene);
    if (!out.empty()) write_scene(out, rendered, catalogue.stones);
    return rendered;
  });
  return made;
}

// Detection

struct Found {
  CataloguePtr catalogue;
  DetectionResult result;
  SceneView first;  ///< view whose camera frame C is
};

struct FoundStone {
  std::string stone;
  Detection detection;
  std::optional<Pose> T_W_C;
};

Found detect(const py::object& scene, const py::object& camera_pose, bool world, const py::object& stones,
             std::optional<int> seed, const py::object& given, const py::dict& options,
             const DepthInput& input) {
  DetectionOptions detection;
  set_options(nest("detection", fields(detection)), seed, options);
  Found found{catalogue_of(given), {}, {}};
  const Catalogue& catalogue = *found.catalogue;
  std::vector<SceneView> seen = views_of(scene, camera_pose, world, input);
  const std::vector<DepthView> views = depth_views_of(seen);
  found.first = std::move(seen.front());
  std::vector<StoneIndex> wanted;
  for (const auto& name : names_of(stones)) wanted.push_back(catalogue.index(name));
  found.result = call([&] {
    if (found.first.world) check_level(found.first, find_table(found.first.image, detection), "the cloud");
    const DetectionModels models(catalogue.stones, detection);
    return detect_stones(views, models, wanted, detection);
  });
  return found;
}

// Search

using SearchPtr = std::shared_ptr<SceneSearch>;

struct FoundPlacement {
  std::string stone;
  Placement placement;
  std::optional<int> course;  ///< of a wall, from 0
  std::vector<int> supports;  ///< of a wall: indices of placements
};

std::vector<FoundPlacement> named(const Catalogue& catalogue, const std::vector<Placement>& placements) {
  std::vector<FoundPlacement> list;
  for (const Placement& p : placements) list.push_back({catalogue[p.stone].name, p, {}, {}});
  return list;
}

/// The next placement, one a level, or those of a wall in the order in which they are built.
std::vector<FoundPlacement> placements_of(const SceneSearch& found) {
  std::vector<FoundPlacement> list = named(found.catalogue, found.placements);
  if (!found.wall) return list;
  for (std::size_t i = 0; i < list.size(); ++i) {
    list[i].course = found.wall->placements[i].course;
    list[i].supports = found.wall->placements[i].supports;
  }
  return list;
}

struct Searched {
  SearchPtr found;
  SceneSearchTask task;
};

Searched search(const py::object& scene, const py::object& stones, const py::object& site,
                const std::string& robot, int levels, const py::object& wall, const py::object& camera_pose,
                bool world, std::optional<int> seed, const py::object& given, const py::dict& options,
                const DepthInput& input) {
  Searched done;
  SceneSearchTask& task = done.task;
  if (given.is_none())
    task.catalogue = data_path("stones");
  else
    task.catalogue = py::isinstance<Catalogue>(given) ? given.cast<CataloguePtr>()->path
                                                      : py::str(given).cast<std::string>();
  if (!scene.is_none()) task.scene = py::str(scene).cast<std::string>();
  task.camera_pose = to_pose_text(camera_pose);
  task.stones = joined(names_of(stones));
  if (py::isinstance<py::str>(site)) {
    task.site = site.cast<std::string>();
  } else if (!site.is_none()) {
    const auto p = site.cast<std::vector<double>>();
    require(p.size() == 2, "site is x, y; got ", p.size(), " numbers");
    char text[64];
    std::snprintf(text, sizeof text, "%.17g,%.17g", p[0], p[1]);
    task.site = text;
  }
  require(levels >= 1 && levels <= 50, "levels must be 1 to 50, got ", levels);
  task.world = world;
  task.depth = input;
  task.robot = robot;
  task.levels = levels;
  task.wall = path_or_text(wall);
  if (robot.empty()) task.search.max_tilt = std::numbers::pi;  // no grasp limits how a stone is turned
  set_options(join({nest("search", fields(task.search)), nest("detection", fields(task.detection)),
                    nest("motion", fields(task.motion)), nest("gripper", {gripper_field(task.gripper)})}),
              seed, options);
  if (!task.wall.empty()) {
    (void)read_wall_target(task.wall);
    require(task.search.method == "default" && levels == 1,
            "wall goes with neither levels nor search.method=paper");
  }
  done.found = call([&] { return std::make_shared<SceneSearch>(search_in_scene(task)); }, task.search.budget);
  return done;
}

std::vector<py::tuple> placed_in(const Catalogue& catalogue, const std::vector<PlacedStone>& stones) {
  std::vector<py::tuple> list;
  for (const PlacedStone& s : stones)
    list.push_back(py::make_tuple(catalogue[s.stone].name, to_array(s.T_W_O)));
  return list;
}

// Check

struct Checked {
  CataloguePtr catalogue;
  TowerCheck check;
};

Checked check(const std::string& tower, double friction, double seconds, const py::object& given) {
  require(std::isfinite(friction) && friction > 0.0, "friction must be positive, got ", friction);
  require(std::isfinite(seconds) && seconds > 0.0, "seconds must be positive, got ", seconds);
  Checked done{catalogue_of(given), {}};
  done.check = call([&] { return check_tower(tower, *done.catalogue, friction, seconds); });
  return done;
}

// Plan

struct Planned {
  CataloguePtr catalogue;  ///< the plan points into it
  std::shared_ptr<ScenePlan> plan;
};

std::vector<NamedPose> targets_of(const py::object& stone, const py::object& target,
                                  const py::object& search_result) {
  if (search_result.is_none()) {
    require(!stone.is_none() && !target.is_none(), "give stone and target, or search");
    return {{stone.cast<std::string>(), to_pose(target)}};
  }
  require(stone.is_none() && target.is_none(),
          "search brings stone and target: they cannot be given with it");
  if (!py::isinstance<Searched>(search_result))
    return read_search_targets(py::str(search_result).cast<std::string>());
  std::vector<NamedPose> targets;
  const SceneSearch& found = *search_result.cast<const Searched&>().found;
  require(!found.placements.empty(), "the search found no placement: ", found.reason);
  targets.push_back({found.catalogue[found.placements.front().stone].name, found.placements.front().T_W_O});
  for (const Placement& p : found.alternatives) targets.push_back({found.catalogue[p.stone].name, p.T_W_O});
  return targets;
}

Planned plan(const std::string& scene, const py::object& stone, const py::object& target,
             const py::object& search_result, const std::string& robot, const std::string& cell,
             const std::optional<std::vector<double>>& start, std::optional<int> seed,
             const py::object& given, const py::dict& options) {
  ScenePlanTask task;
  task.scene = scene;
  std::string gripper;
  set_options(join({nest("motion", fields(task.options)), nest("gripper", {gripper_field(gripper)})}), seed,
              options);
  task.targets = targets_of(stone, target, search_result);
  if (cell.empty()) {
    task.robot = read_robot(robot.empty() ? "ur10" : robot);
  } else {
    const CellFile file = read_cell(cell);
    require(robot.empty() || robot == file.robot(), "robot ", robot, " is not the robot of ", cell, ", ",
            file.robot());
    task.layout = to_layout(file.cell());
    task.robot = read_cell_robot(file.cell());
  }
  task.layout = with_option_gripper(task.layout, gripper, !cell.empty());
  task.q_start = home_joints();
  if (start) {
    require(start->size() == 6, "start is six joint angles in rad, got ", start->size(), " numbers");
    for (Eigen::Index i = 0; i < 6; ++i) {
      task.q_start[i] = (*start)[static_cast<std::size_t>(i)];
      require(task.q_start[i] >= task.robot.lower[i] && task.q_start[i] <= task.robot.upper[i],
              "start: joint ", i + 1, " at ", task.q_start[i], " rad is outside the limits of ",
              task.robot.name, ", ", task.robot.lower[i], " to ", task.robot.upper[i], " rad");
    }
  }
  Planned done{catalogue_of(given), nullptr};
  done.plan = call([&] { return std::make_shared<ScenePlan>(plan_in_scene(task, *done.catalogue)); });
  return done;
}

// Run

using RunPtr = std::shared_ptr<RecordedRun>;

RunPtr run(const std::string& robot, std::optional<int> seed, int per_run, const py::object& wall,
           const std::string& out, const py::object& given, const py::dict& options) {
  RunOrder order;
  order.run.seed = seed.value_or(1);
  spread_seed(order.run);
  std::vector<FlagValue> flags;
  if (!wall.is_none()) flags.push_back({"wall", "run.wall", path_or_text(wall)});
  set_options(fields(order.run), seed, options, flags);
  if (!order.run.build.wall.empty()) (void)read_wall_target(order.run.build.wall);  // before a folder is made
  order.robot = read_robot(robot);
  order.per_run = per_run;
  order.out = out;
  order.version = apps::program_version();
  const CataloguePtr catalogue = catalogue_of(given);
  require(per_run >= 1 && per_run <= static_cast<int>(catalogue->stones.size()), "per_run ", per_run, ": ",
          catalogue->path, " has ", catalogue->stones.size(), " stones");
  return call([&] { return std::make_shared<RecordedRun>(record_run(order, *catalogue)); });
}

/// One column of a timeline.
template <class Get>
py::array_t<double> column(const RunPtr& run, const Get& get) {
  std::vector<double> values;
  for (const MotionSample& sample : run->report.result.timeline.samples) values.push_back(get(sample));
  return to_array(values);
}

// What Python sees of it

void add_stones(py::module_& m) {
  py::class_<Mesh>(m, "Mesh")
      .def_property_readonly("vertices", [](const Mesh& mesh) { return to_array(mesh.vertices); })
      .def_property_readonly("faces", [](const Mesh& mesh) { return to_array(mesh.faces); });
  py::class_<Stone>(m, "Stone")
      .def_readonly("name", &Stone::name)
      .def_readonly("mesh", &Stone::mesh)
      .def_readonly("scan", &Stone::scan)
      .def_readonly("pieces", &Stone::pieces)
      .def_readonly("friction", &Stone::friction)
      .def_readonly("density", &Stone::density)
      .def_readonly("source", &Stone::source)
      .def_property_readonly("mass", [](const Stone& s) { return s.mass.mass; })
      .def_property_readonly("p_O_M", [](const Stone& s) { return to_array(s.mass.p_O_M); })
      .def_property_readonly("I_M", [](const Stone& s) { return matrix_to_array(s.mass.I_M); })
      .def_property_readonly("T_O_file", [](const Stone& s) { return to_array(s.T_O_file); });
  py::class_<Catalogue, CataloguePtr>(m, "Catalogue")
      .def_readonly("path", &Catalogue::path)
      .def_property_readonly("names",
                             [](const Catalogue& c) {
                               std::vector<std::string> names;
                               for (const Stone& s : c.stones) names.push_back(s.name);
                               return names;
                             })
      .def("__len__", [](const Catalogue& c) { return c.stones.size(); })
      .def(
          "__getitem__",
          [](const Catalogue& c, const std::string& name) -> const Stone& { return c[c.index(name)]; },
          py::return_value_policy::reference_internal)
      .def(
          "__getitem__",
          [](const Catalogue& c, int index) -> const Stone& {
            const int count = static_cast<int>(c.stones.size());
            if (index < -count || index >= count) throw py::index_error("no such stone");
            return c.stones[static_cast<std::size_t>(index < 0 ? index + count : index)];
          },
          py::return_value_policy::reference_internal);
  m.def(
      "read_catalogue", [](const py::object& path) { return catalogue_of(path); },
      py::arg("path") = py::none());
}

void add_scenes(py::module_& m) {
  py::class_<DepthImage>(m, "DepthImage")
      .def(py::init([](const py::array_t<float, py::array::c_style | py::array::forcecast>& z, double fx,
                       double fy, double cx, double cy) {
             require(z.ndim() == 2 && z.size() > 0, "a depth image has rows and columns; got ", z.ndim(),
                     " dimensions");
             DepthImage image;
             image.camera.height = static_cast<int>(z.shape(0));
             image.camera.width = static_cast<int>(z.shape(1));
             image.camera.fx = fx;
             image.camera.fy = fy;
             image.camera.cx = cx;
             image.camera.cy = cy;
             image.z.assign(z.data(), z.data() + z.size());
             return image;
           }),
           py::arg("z"), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"))
      .def_property_readonly("z", [](const DepthImage& image) { return to_array(image); })
      .def_property_readonly("fx", [](const DepthImage& image) { return image.camera.fx; })
      .def_property_readonly("fy", [](const DepthImage& image) { return image.camera.fy; })
      .def_property_readonly("cx", [](const DepthImage& image) { return image.camera.cx; })
      .def_property_readonly("cy", [](const DepthImage& image) { return image.camera.cy; })
      .def("cloud", [](const DepthImage& image) { return to_array(to_cloud(image)); });
  m.def(
      "read_cloud", [](const std::string& path) { return to_array(read_cloud(path)); }, py::arg("path"));
  m.def(
      "read_depth",
      [](const std::string& path, const py::object& camera_pose, bool world, const DepthInput& input) {
        const SceneView view = read_view(path, to_pose_text(camera_pose), world, input);
        return py::make_tuple(view.image, optional_pose(view.T_W_C));
      },
      py::arg("path"), py::arg("camera_pose") = py::none(), py::arg("world") = false,
      py::arg("depth") = DepthInput{});
  py::class_<Scene>(m, "Scene")
      .def_property_readonly("depth", [](const Scene& s) { return s.scene.depth; })
      .def_property_readonly("depth_unit", [](const Scene& s) { return s.scene.depth_unit; })
      .def_property_readonly("T_W_C", [](const Scene& s) { return to_array(s.scene.T_W_C); })
      .def_property_readonly("stones",
                             [](const Scene& s) { return placed_in(*s.catalogue, s.scene.stones); });
  m.def("render", &render, py::arg("out") = "", py::kw_only(), py::arg("stones") = py::none(),
        py::arg("seed") = py::none(), py::arg("catalogue") = py::none(), py::arg("options") = py::dict());
}

void add_detection(py::module_& m) {
  py::class_<FoundStone>(m, "Detection")
      .def_readonly("stone", &FoundStone::stone)
      .def_property_readonly("T_C_O", [](const FoundStone& f) { return to_array(f.detection.T_C_O); })
      .def_property_readonly("T_W_O",
                             [](const FoundStone& f) {
                               std::optional<Pose> T_W_O;
                               if (f.T_W_C) T_W_O = *f.T_W_C * f.detection.T_C_O;
                               return optional_pose(T_W_O);
                             })
      .def_property_readonly("score", [](const FoundStone& f) { return f.detection.score; })
      .def_property_readonly("inlier_ratio", [](const FoundStone& f) { return f.detection.inlier_ratio; })
      .def_property_readonly("visible", [](const FoundStone& f) { return f.detection.visible; })
      .def_property_readonly("certainty", [](const FoundStone& f) { return f.detection.certainty; })
      .def_property_readonly("covariance_C",
                             [](const FoundStone& f) { return matrix_to_array(f.detection.covariance); });
  py::class_<Found>(m, "Detections")
      .def_property_readonly("detections",
                             [](const Found& f) {
                               std::vector<FoundStone> list;
                               for (const Detection& d : f.result.detections)
                                 list.push_back({(*f.catalogue)[d.stone].name, d, f.first.T_W_C});
                               return list;
                             })
      .def_property_readonly("T_W_C", [](const Found& f) { return optional_pose(f.first.T_W_C); })
      .def_property_readonly("note", [](const Found& f) { return f.result.note; })
      .def_property_readonly("depth_scale", [](const Found& f) { return f.result.depth_scale; })
      .def_property_readonly("depth_scale_sigma", [](const Found& f) { return f.result.depth_scale_sigma; })
      .def("__len__", [](const Found& f) { return f.result.detections.size(); })
      .def("json", [](const Found& f) { return detection_json(f.result, *f.catalogue, f.first.T_W_C); });
  m.def("detect", &detect, py::arg("scene"), py::kw_only(), py::arg("camera_pose") = py::none(),
        py::arg("world") = false, py::arg("stones") = py::none(), py::arg("seed") = py::none(),
        py::arg("catalogue") = py::none(), py::arg("options") = py::dict(), py::arg("depth") = DepthInput{});
}

void add_walls(py::module_& m) {
  py::class_<WallMetrics>(m, "WallMetrics")
      .def_readonly("placed", &WallMetrics::placed)
      .def_readonly("asked", &WallMetrics::asked)
      .def_readonly("length", &WallMetrics::length)
      .def_readonly("height", &WallMetrics::height)
      .def_readonly("width", &WallMetrics::width)
      .def_readonly("fill", &WallMetrics::fill)
      .def_readonly("face", &WallMetrics::face)
      .def_readonly("joints", &WallMetrics::joints)
      .def_readonly("open_joints", &WallMetrics::open_joints)
      .def_readonly("flatness", &WallMetrics::flatness)
      .def_readonly("margin", &WallMetrics::margin);
}

void add_search(py::module_& m) {
  py::class_<FoundPlacement>(m, "Placement")
      .def_readonly("stone", &FoundPlacement::stone)
      .def_property_readonly("T_W_O", [](const FoundPlacement& f) { return to_array(f.placement.T_W_O); })
      .def_property_readonly("cost", [](const FoundPlacement& f) { return f.placement.cost; })
      .def_property_readonly("terms", [](const FoundPlacement& f) { return f.placement.terms; })
      .def_property_readonly("predicted_success",
                             [](const FoundPlacement& f) { return f.placement.predicted_success; })
      .def_property_readonly("expected_height",
                             [](const FoundPlacement& f) { return f.placement.expected_height; })
      .def_property_readonly("support_W",
                             [](const FoundPlacement& f) { return to_array(f.placement.support.corners_W); })
      .def_readonly("course", &FoundPlacement::course)
      .def_readonly("supports", &FoundPlacement::supports);
  py::class_<Searched>(m, "SearchResult")
      .def_property_readonly("placements", [](const Searched& s) { return placements_of(*s.found); })
      .def_property_readonly(
          "alternatives", [](const Searched& s) { return named(s.found->catalogue, s.found->alternatives); })
      .def_property_readonly("stack",
                             [](const Searched& s) {
                               return placed_in(s.found->catalogue, s.found->start.problem.stack.stones);
                             })
      .def_property_readonly("wall",
                             [](const Searched& s) {
                               const auto& wall = s.found->wall;
                               return wall ? std::optional<WallMetrics>(wall->metrics) : std::nullopt;
                             })
      .def_property_readonly("T_W_V",
                             [](const Searched& s) {
                               const auto& wall = s.found->wall;
                               return optional_pose(wall ? std::optional<Pose>(wall->T_W_V) : std::nullopt);
                             })
      .def_property_readonly("site",
                             [](const Searched& s) {
                               const Eigen::Vector2d& p = s.found->start.problem.site;
                               return to_array(std::vector<double>{p.x(), p.y()});
                             })
      .def_property_readonly("frame", [](const Searched& s) { return s.found->start.frame; })
      .def_property_readonly("T_W_C", [](const Searched& s) { return optional_pose(s.found->start.T_W_C); })
      .def_property_readonly("reason", [](const Searched& s) { return s.found->reason; })
      .def_property_readonly("repeatable", [](const Searched& s) { return s.found->repeatable; })
      .def("json",
           [](const Searched& s) {
             return search_json(*s.found, s.task.search.seed, next_command(*s.found, s.task, "", ""));
           })
      .def(
          "write_scene",
          [](const Searched& s, const std::string& path) { write_scene_file(path, scene_of(*s.found)); },
          py::arg("path"))
      .def(
          "draw",
          [](const Searched& s, const std::string& path) {
            draw_tower(path, s.found->catalogue, planned_tower(*s.found), s.found->start.problem.site);
          },
          py::arg("path"));
  m.def("search", &search, py::arg("scene") = py::none(), py::kw_only(), py::arg("stones") = py::none(),
        py::arg("site") = py::none(), py::arg("robot") = "", py::arg("levels") = 1,
        py::arg("wall") = py::none(), py::arg("camera_pose") = py::none(), py::arg("world") = false,
        py::arg("seed") = py::none(), py::arg("catalogue") = py::none(), py::arg("options") = py::dict(),
        py::arg("depth") = DepthInput{});
}

void add_check(py::module_& m) {
  py::class_<Checked>(m, "TowerCheck")
      .def_property_readonly("stands", [](const Checked& c) { return c.check.verdict.stands; })
      .def_property_readonly("clean", [](const Checked& c) { return c.check.verdict.clean; })
      .def_property_readonly("standing", [](const Checked& c) { return c.check.verdict.standing; })
      .def_property_readonly("shift", [](const Checked& c) { return c.check.verdict.shift; })
      .def_property_readonly("turn", [](const Checked& c) { return c.check.verdict.turn; })
      .def_property_readonly("reason", [](const Checked& c) { return c.check.verdict.reason; })
      .def_property_readonly("T_W_O", [](const Checked& c) { return to_array(c.check.verdict.T_W_O); })
      .def_property_readonly("in_equilibrium", [](const Checked& c) { return c.check.equilibrium.stands; })
      .def_property_readonly("margin", [](const Checked& c) { return c.check.equilibrium.margin; })
      .def_property_readonly("direction",
                             [](const Checked& c) {
                               const Eigen::Vector2d& d = c.check.equilibrium.direction;
                               return to_array(std::vector<double>{d.x(), d.y()});
                             })
      .def_property_readonly("min_friction",
                             [](const Checked& c) { return c.check.equilibrium.min_friction; })
      .def_property_readonly("contacts_W",
                             [](const Checked& c) {
                               std::vector<Eigen::Vector3d> points;
                               for (const auto& contact : c.check.statics.contacts)
                                 points.push_back(contact.p_W);
                               return to_array(points);
                             })
      .def("json", [](const Checked& c) { return tower_json(c.check, *c.catalogue); });
  m.def("check", &check, py::arg("tower"), py::kw_only(), py::arg("friction") = 0.1,
        py::arg("seconds") = 10.0, py::arg("catalogue") = py::none());
}

void add_plan(py::module_& m) {
  py::class_<PlanStep>(m, "PlanStep")
      .def_readonly("name", &PlanStep::name)
      .def_readonly("opening", &PlanStep::opening)
      .def_property_readonly("time", [](const PlanStep& s) { return to_array(s.trajectory.time); })
      .def_property_readonly("q", [](const PlanStep& s) { return to_array(s.trajectory.q); })
      .def_property_readonly("qd", [](const PlanStep& s) { return to_array(s.trajectory.qd); });
  py::class_<Planned>(m, "Plan")
      .def_property_readonly(
          "planned",
          [](const Planned& p) { return p.plan->plan.status == PickAndPlacePlan::Status::kPlanned; })
      .def_property_readonly("reason", [](const Planned& p) { return p.plan->plan.reason; })
      .def_property_readonly("stone", [](const Planned& p) { return p.plan->task.stone->name; })
      .def_property_readonly("T_W_O", [](const Planned& p) { return to_array(p.plan->task.T_W_O_place); })
      .def_property_readonly("T_O_T", [](const Planned& p) { return to_array(p.plan->plan.T_O_T); })
      .def_property_readonly("seconds", [](const Planned& p) { return p.plan->plan.seconds; })
      .def_property_readonly("steps", [](const Planned& p) { return p.plan->plan.steps; })
      .def("json", [](const Planned& p) { return plan_json(*p.plan); })
      .def("csv", [](const Planned& p) { return plan_csv(*p.plan); });
  m.def("plan", &plan, py::arg("scene"), py::kw_only(), py::arg("stone") = py::none(),
        py::arg("target") = py::none(), py::arg("search") = py::none(), py::arg("robot") = "",
        py::arg("cell") = "", py::arg("start") = py::none(), py::arg("seed") = py::none(),
        py::arg("catalogue") = py::none(), py::arg("options") = py::dict());
}

void add_run(py::module_& m) {
  py::class_<PlacementRecord>(m, "PlacementRecord")
      .def_readonly("stone", &PlacementRecord::stone)
      .def_readonly("level", &PlacementRecord::level)
      .def_readonly("note", &PlacementRecord::note)
      .def_property_readonly("outcome", [](const PlacementRecord& r) { return to_text(r.outcome); })
      .def_property_readonly("cost", [](const PlacementRecord& r) { return r.planned.cost; })
      .def_property_readonly("predicted_success",
                             [](const PlacementRecord& r) { return r.planned.predicted_success; })
      .def_property_readonly("T_W_O_planned",
                             [](const PlacementRecord& r) { return to_array(r.planned.T_W_O); })
      .def_property_readonly("T_W_O_measured",
                             [](const PlacementRecord& r) { return optional_pose(r.T_W_O_measured); });
  py::class_<RecordedRun, RunPtr>(m, "Run")
      .def_readonly("folder", &RecordedRun::folder)
      .def_readonly("unwritten", &RecordedRun::unwritten)
      .def_property_readonly("height", [](const RecordedRun& r) { return r.report.result.height; })
      .def_property_readonly("ended", [](const RecordedRun& r) { return to_text(r.report.result.end); })
      .def_property_readonly("reason", [](const RecordedRun& r) { return r.report.result.ended; })
      .def_property_readonly("placements", [](const RecordedRun& r) { return r.report.result.placements; })
      .def_property_readonly("wall", [](const RecordedRun& r) { return r.report.result.wall; })
      .def_property_readonly("true_height",
                             [](const RecordedRun& r) {
                               return r.report.truth ? std::optional<int>(r.report.truth->height)
                                                     : std::nullopt;
                             })
      .def_property_readonly("time",
                             [](const RunPtr& r) { return column(r, [](const auto& s) { return s.time; }); })
      .def_property_readonly("q",
                             [](const RecordedRun& r) {
                               std::vector<Joints> q;
                               for (const auto& s : r.report.result.timeline.samples) q.push_back(s.q);
                               return to_array(q);
                             })
      .def_property_readonly(
          "opening", [](const RunPtr& r) { return column(r, [](const auto& s) { return s.opening; }); })
      .def_property_readonly("force",
                             [](const RunPtr& r) { return column(r, [](const auto& s) { return s.force; }); })
      .def("json", [](const RecordedRun& r) { return run_json(r.report); });
  m.def("run", &run, py::arg("robot") = "ur10", py::kw_only(), py::arg("seed") = py::none(),
        py::arg("per_run") = 4, py::arg("wall") = py::none(), py::arg("out") = "",
        py::arg("catalogue") = py::none(), py::arg("options") = py::dict());
}

void set_level(const std::string& name) {
  const std::vector<std::pair<std::string, LogLevel>> levels{{"debug", LogLevel::kDebug},
                                                             {"info", LogLevel::kInfo},
                                                             {"warning", LogLevel::kWarning},
                                                             {"error", LogLevel::kError},
                                                             {"off", LogLevel::kOff}};
  for (const auto& [known, level] : levels)
    if (known == name) return set_log_level(level);
  throw InvalidArgument("a log level is debug, info, warning, error or off, got " + name);
}

}  // namespace

PYBIND11_MODULE(stonestack, m) {
  m.doc() = "Finds scanned stones, plans stable towers and walls and builds them with a robot arm.";
  m.attr("__version__") = apps::program_version();
  add_errors(m);
  py::class_<DepthInput>(m, "DepthInput")
      .def(py::init([](double unit, const std::string& camera, const std::string& distortion, int frame,
                       const std::string& units, const std::string& sensor) {
             return DepthInput{unit, camera, distortion, frame, units, sensor};
           }),
           py::kw_only(), py::arg("unit") = 0.0, py::arg("camera") = "", py::arg("distortion") = "",
           py::arg("frame") = 0, py::arg("units") = "m", py::arg("sensor") = "");
  add_stones(m);
  add_scenes(m);
  add_detection(m);
  add_segmentation(m);
  add_walls(m);
  add_search(m);
  add_check(m);
  add_plan(m);
  add_run(m);
  m.def("set_log_level", &set_level, py::arg("level"));
  set_log_level(LogLevel::kWarning);
}

}  // namespace stonestack::python
