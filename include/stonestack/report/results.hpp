#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/detection/segment.hpp"
#include "stonestack/experiment/experiment.hpp"
#include "stonestack/modelling/model_objects.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/check_cell.hpp"
#include "stonestack/stacking/scene_tasks.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/model_stone.hpp"
#include "stonestack/stone/scene_file.hpp"

#pragma GCC visibility push(default)

/// Results of single steps as JSON for programs (docs/formats.md) and as text for a person, a line a stone;
/// progress; and texts about the command itself. Runs and experiments have reports of their own.
namespace stonestack::report {

/// State of long work.
struct Progress {
  std::string what;      ///< name of the work: "search"
  double done = 0.0;     ///< amount that is done
  double total = 0.0;    ///< whole amount; 0: unknown
  std::string unit;      ///< "stones", "runs", "s"
  std::string best;      ///< best result so far; empty: none
  double seconds = 0.0;  ///< time since the work began [s]
};
/// One line: what, how far, best so far, and the time left if the rest is as fast as what is done.
[[nodiscard]] std::string progress_text(const Progress& progress);
/// Shows the line in place on a terminal; elsewhere logs it when `what` or `done` has changed.
void show_progress(const Progress& progress);

/// Option or argument of a command, for completion and manual pages.
struct CommandOption {
  std::vector<std::string> names;    ///< "-q", "--quiet"; of an argument one name without dashes
  std::string value;                 ///< kind of its value: FILE, DIR, TEXT; empty: a switch
  std::vector<std::string> choices;  ///< values that it takes; empty: others too
  std::string description;           ///< effect, with range and default
};
/// Command of a program as a user can type it.
struct CommandDescription {
  std::vector<std::string> words;            ///< "stonestack", "config", "show"
  std::string description;                   ///< purpose in one line
  std::string footer;                        ///< further text, with examples
  std::vector<CommandOption> options;        ///< options by name
  std::vector<CommandOption> arguments;      ///< arguments by place
  std::vector<CommandDescription> commands;  ///< subcommands
};
/// Script that completes the command in `shell`: bash, zsh or fish. Option --set completes the names
/// `settings`.
/// @throws InvalidArgument for another shell.
[[nodiscard]] std::string completion_script(const CommandDescription& program, const std::string& shell,
                                            const std::vector<std::string>& settings);
/// Manual page (section 1, man macros) of one command; `version` and `date` (2026-11-21) stand in its foot.
[[nodiscard]] std::string manual_page(const CommandDescription& command, const std::string& version,
                                      const std::string& date);
/// Writes manual pages and completions below `folder` where a system looks for them below its share/.
/// @throws FileError
void write_command_pages(const CommandDescription& program, const std::string& version,
                         const std::string& date, const std::vector<std::string>& settings,
                         const std::string& folder);

/// "stonestack.detect/1"; with the camera's pose each detection has T_W_O as well.
[[nodiscard]] std::string detection_json(const DetectionResult& result, const Catalogue& catalogue,
                                         const std::optional<Pose>& T_W_C,
                                         const std::vector<Explanation>& explanations = {});
/// Positions in C, or in W for a cloud that no camera took.
[[nodiscard]] std::string detection_table(const DetectionResult& result, const Catalogue& catalogue,
                                          const SceneView& view);
/// Warnings: stones whose shape leaves open which stone it is or how it lies, and poses that the paper's
/// inlier ratio takes though the visibility-aware score would refuse them.
[[nodiscard]] std::vector<std::string> detection_warnings(const DetectionResult& result,
                                                          const Catalogue& catalogue,
                                                          const DetectionOptions& options);

/// Why stones were found or not, a line each, and what the colours of `draw_explanation` say.
[[nodiscard]] std::string explanation_text(const std::vector<Explanation>& explanations,
                                           const Catalogue& catalogue);
/// Draws the image as a PNG file, depth in grey, with the best pose of the stone coloured by what each pixel
/// says of it.
/// @throws FileError.
void draw_explanation(const std::string& path, const DepthImage& image, const Explanation& explanation);

/// "stonestack.segment/1"; with the camera's pose each object has p_W_middle as well.
[[nodiscard]] std::string segmentation_json(const Segmentation& result, const std::optional<Pose>& T_W_C);
/// Positions in C, or in W for a cloud that no camera took.
[[nodiscard]] std::string segmentation_table(const Segmentation& result, const SceneView& view);
/// Warnings: objects that may be parts of one, or several.
[[nodiscard]] std::vector<std::string> segmentation_warnings(const Segmentation& result);
/// Writes into the folder object_1.ply and so on (cloud with normals, in C) and labels_1.png and so on, a
/// view each: 16-bit greyscale, the object's number or 0.
/// @throws FileError.
void write_segmentation(const std::string& folder, const Segmentation& result,
                        const std::vector<SceneView>& views);
/// Draws the views side by side as a PNG file: depth in grey, each object in a colour of its own with its
/// number.
/// @throws FileError.
void draw_segmentation(const std::string& path, const Segmentation& result,
                       const std::vector<SceneView>& views);

/// "stonestack.track/1".
[[nodiscard]] std::string tracking_json(const TrackResult& result, const Catalogue& catalogue,
                                        const Pose& T_W_C);
/// Text table of tracked stones.
[[nodiscard]] std::string tracking_table(const TrackResult& result, const Catalogue& catalogue);
/// Poses that `detection_json` or `tracking_json` wrote into a file, or those of a scene file.
/// @throws FileError, also for detections whose camera pose was not known.
[[nodiscard]] std::vector<NamedPose> read_seen_poses(const std::string& path);

/// "stonestack.search/1"; `next` is the command to type next.
[[nodiscard]] std::string search_json(const SceneSearch& found, int seed, const std::string& next);
/// Frame and stack of a view, and the placements.
[[nodiscard]] std::string search_text(const SceneSearch& found, const std::string& next);
/// "stonestack.trace/1": every candidate with its path to contact (poses T_W_O), support polygon, cost, terms
/// and outcome.
[[nodiscard]] std::string search_trace_json(const SceneSearch& found);
/// Command line that goes on from what was found in a view; empty for other results. `catalogue` and `out`
/// are paths that the user gave, or empty.
[[nodiscard]] std::string next_command(const SceneSearch& found, const SceneSearchTask& task,
                                       const std::string& catalogue, const std::string& out);
/// The stack with the placements on it.
[[nodiscard]] std::vector<PlacedStone> planned_tower(const SceneSearch& found);
/// A scene file with the tower as its stack, or with the wall.
[[nodiscard]] SceneFile scene_of(const SceneSearch& found);

/// "stonestack.assembly/1".
[[nodiscard]] std::string assembly_json(const AssemblyCheck& check);
/// Text of a check, for a terminal.
[[nodiscard]] std::string assembly_text(const AssemblyCheck& check);
/// Draws the blocks with contacts and contact forces: a PNG file, where the blocks are a little shrunk so
/// that one sees between them and supports are dark, or, for a path in .html, one 3-D page. @throws
/// FileError.
void draw_assembly(const std::string& path, const AssemblyCheck& check);

/// "stonestack.check/1".
[[nodiscard]] std::string tower_json(const TowerCheck& check, const Catalogue& catalogue);
/// Text of a check, for a terminal.
[[nodiscard]] std::string tower_text(const TowerCheck& check, const Catalogue& catalogue);
/// Draws the stones on a table, with the tower at `site` in the middle, as a PNG file. The view is as high as
/// the highest stone within `radius` of the site. @throws FileError.
void draw_tower(const std::string& path, const Catalogue& catalogue, const std::vector<PlacedStone>& stones,
                const Eigen::Vector2d& site, double radius = 1e3);

/// Placement that a search proposed, as its JSON has it, and then its alternatives: targets of a plan.
/// @throws FileError.
[[nodiscard]] std::vector<NamedPose> read_search_targets(const std::string& path);
/// "stonestack.plan/1".
[[nodiscard]] std::string plan_json(const ScenePlan& planned);
/// Text table of a plan, step by step.
[[nodiscard]] std::string plan_table(const ScenePlan& planned);
/// All motions one after the other, sampled every 8 ms.
[[nodiscard]] std::string plan_csv(const ScenePlan& planned);
/// Joints, tool speed and clearance over time as an SVG file. @throws FileError.
void plot_plan(const std::string& path, const ScenePlan& planned);
/// One PNG for the start and for the end of each motion: FOLDER/00_start.png, 01_transit.png, ...; `width` in
/// pixels. @throws FileError.
void draw_plan(const std::string& folder, const ScenePlan& planned, int width);

/// "stonestack.render/1".
[[nodiscard]] std::string scene_json(const SimulatedScene& scene, const Catalogue& catalogue,
                                     const std::string& folder, int seed);
/// Text table of a rendered scene.
[[nodiscard]] std::string scene_table(const SimulatedScene& scene, const Catalogue& catalogue);

/// Order to show a cell before anything moves.
struct CellViewOrder {
  std::string cell;  ///< path of a cell file, or name of a cell that comes with stonestack
  /// FILE.html: a page in 3-D with the picture in it; FILE.png: the picture alone; else a folder for both.
  /// Empty: NAME_view.html, NAME that of the cell file.
  std::string out;
  std::optional<Joints> q_start;  ///< where the arm stands [rad]; empty: over the middle of the field
};
/// A cell that was shown.
struct ShownCell {
  std::string cell;                ///< path of its file
  CellPreview preview;             ///< what is shown, with the findings
  std::vector<std::string> files;  ///< files that were written
};
/// Draws a cell by its file alone; connects to nothing. The page is one file without a network: arm, gripper,
/// obstacles, limits, reach and the camera's view as layers, findings, and the numbers of the file.
/// @throws FileError; InvalidArgument for joint angles that the robot does not have
[[nodiscard]] ShownCell show_cell(const CellViewOrder& order);
/// "stonestack.view/1".
[[nodiscard]] std::string cell_view_json(const ShownCell& view);
/// A line a finding, and the files.
[[nodiscard]] std::string cell_view_text(const ShownCell& view);

/// Measures of a stone that was made of a scan.
struct StoneSummary {
  Stone stone;                                        ///< without its meshes
  Eigen::Vector3d extents = Eigen::Vector3d::Zero();  ///< [m]
  double volume = 0.0;                                ///< [m^3]
  double volume_over_hull = 0.0;                      ///< volume of the stone over that of its convex hull
  std::size_t scan_faces = 0;                         ///< faces of the scan
  std::size_t faces = 0;                              ///< faces of the reduced mesh
  std::size_t pieces = 0;                             ///< convex pieces
  std::vector<std::string> warnings;                  ///< warnings of `model_stone`
};
/// Figures of a stone that was made; the meshes are dropped.
[[nodiscard]] StoneSummary summary_of(ModelResult result);
/// A scan that could not be made a stone.
struct FailedScan {
  std::string file;   ///< file of the scan
  std::string error;  ///< reason why it gave no stone
};
/// Stones to make of scanned meshes, or to generate.
struct ScanOrder {
  std::vector<std::string> files;  ///< scanned meshes
  std::string catalogue;           ///< folder that the stones are stored in; made if missing
  std::string name;                ///< of a single stone; empty: the file's
  int generate = 0;                ///< limestones, limestone_1 and so on
  std::uint64_t seed = 1;          ///< of these
  bool force = false;              ///< stones that are there already are replaced
  ModelOptions options;            ///< how a scan becomes a stone
};
/// Stones that were made and stored, and what could not be made one.
struct ScannedStones {
  std::vector<StoneSummary> stones;  ///< stones that were stored
  std::vector<FailedScan> failed;    ///< files that gave none
};
/// Makes and stores the stones, one after the other, with progress.
/// @throws InvalidArgument, before any work is done, for names that cannot be or are there already; FileError
/// for a single file that gives no stone
[[nodiscard]] ScannedStones scan_stones(const ScanOrder& order);

/// Stones that a run modelled, read back from where it kept them; what it left out counts as failed.
/// @throws FileError
[[nodiscard]] ScannedStones modelled_stones(const RunReport& report);

/// Stones to make of depth images of objects on a table.
struct ModelOrder {
  std::vector<DepthView> views;  ///< of one scene, from all around
  std::string catalogue;         ///< folder that the stones are stored in; made if missing
  std::string prefix = "stone";  ///< of their names: stone_1 and so on
  bool force = false;            ///< stones that are there already are replaced
  ModelOptions stone;            ///< density, mass, friction
  ModellingOptions modelling;    ///< how views become models
};
/// Stones that were made of what the views show, and how well they are known.
struct ModelledViews {
  AlignedScene scene;                ///< the views as they agree, with the objects in them
  std::vector<ObjectModel> models;   ///< an object each
  std::vector<StoneSummary> stones;  ///< stones that were stored
  std::vector<FailedScan> failed;    ///< objects that gave none, with the reason
};
/// Models every object and stores it as a stone, with `uncertainty.ply` beside its meshes: the surface in O
/// with each vertex' standard deviation [m] and whether a view showed it, coloured from blue (known) to red.
/// @throws InvalidArgument for no view, or names that are there already
[[nodiscard]] ModelledViews model_views(const ModelOrder& order);
/// "stonestack.model/1" of what was stored in the folder `catalogue`.
[[nodiscard]] std::string modelled_json(const ModelledViews& modelled, const std::string& catalogue);
/// A line a stone, lengths in mm, for a person.
[[nodiscard]] std::string modelled_table(const ModelledViews& modelled);

/// "stonestack.scan/1" of stones that were stored in the folder `catalogue`.
[[nodiscard]] std::string stones_json(const std::vector<StoneSummary>& stones, const std::string& catalogue,
                                      const std::vector<FailedScan>& failed);
/// Lengths in cm, deviations in mm.
[[nodiscard]] std::string stones_table(const std::vector<StoneSummary>& stones);

/// Exit code of a program that made the run and does nothing else.
[[nodiscard]] ExitCode exit_code(const RunResult& result);

}  // namespace stonestack::report

#pragma GCC visibility pop
