#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/physics/equilibrium.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/scene_file.hpp"

#pragma GCC visibility push(default)

/// Single steps of the loop for scenes that come from files: no device, no run.
namespace stonestack::stacking {

/// A search in a scene, as a user asks for it.
struct SceneSearchTask {
  std::string catalogue;       ///< folder of the stones
  std::string scene;           ///< scene file or view; empty: `stones` on the empty table
  std::string camera_pose;     ///< of a view, as `parse_pose` reads it; may be empty
  std::string stones;          ///< by name, comma-separated
  std::string site;            ///< x,y; may be empty
  bool world = false;          ///< the view is a cloud in the world frame
  DepthInput depth;            ///< how a depth image or cloud is read
  std::string robot;           ///< only poses to which this arm brings the stones, in one go; empty: any pose
  int levels = 1;              ///< to plan, as if each placement succeeded
  std::string wall;            ///< a wall instead of a tower, as `read_wall_target` reads it; may be empty
  SearchOptions search;        ///< options of the search
  DetectionOptions detection;  ///< options of detection
  MotionOptions motion;        ///< options of motion planning, with a robot
  std::string gripper;         ///< gripper of the robot, by its name or a YAML; empty: robotiq-3f
};
/// A search problem with the frame that it is stated in.
struct SearchStart {
  std::shared_ptr<const ShapeList> shapes;  ///< of the stones that occur, by catalogue index; others are null
  std::shared_ptr<const std::vector<ShapeList>> possible_shapes;  ///< SearchProblem::possible_shapes
  SearchProblem problem;                                          ///< stack, loose stones and site
  /// Definition of W: cell (nothing was seen), scene_file, camera_pose, world_cloud, or table (found in a
  /// view); unknown before the input was read.
  std::string frame = "unknown";
  std::string frame_text;     ///< the same for a person
  std::optional<Pose> T_W_C;  ///< of a view that a camera took
  std::string site_text;      ///< where the tower stands or will stand, for a person; empty: as was asked
  bool seen = false;          ///< stones were found in a view
};
/// Result of a search in a scene.
struct SceneSearch {
  Catalogue catalogue;                  ///< stones of the task
  SearchStart start;                    ///< empty, or as far as it came, where the time was over before
  std::vector<Placement> placements;    ///< the next one, one a level, or those of a wall; empty: `reason`
  std::optional<WallPlan> wall;         ///< with SceneSearchTask::wall
  std::vector<PlacedStone> supports;    ///< blocks of the wall's target; the last stones of the catalogue
  std::vector<Placement> alternatives;  ///< other poses for the first, should the arm refuse it
  std::string reason;                   ///< reason why no more was found; empty: nothing stood in the way
  bool repeatable = true;               ///< not ended by the clock or the user: the same seed gives the same
  /// Every candidate of a search of one level that was made, with SearchOptions::trace.
  std::optional<std::vector<CandidateTrace>> trace;
};
/// Reads the catalogue and the scene, finds the stones if the scene is a view (which tower stands there and
/// which stones lie loose: `find_stack`), lets the tower come to rest, and searches. A view whose camera pose
/// is unknown defines W by the table that it shows; its tower is the one that stands there, else the site is
/// the best place in view. A `TimeLimit` that is over ends it with the best so far. `report` hears of the
/// progress.
/// @throws FileError; InvalidArgument; Error when nothing is detected, when what is seen is no tower to build
/// on, or when the arm can carry none of the stones; Interrupted.
[[nodiscard]] SceneSearch search_in_scene(const SceneSearchTask& task,
                                          const std::function<void(const std::string&)>& report = {});

/// A motion to plan.
struct ScenePlanTask {
  std::string scene;                ///< scene file with the stones' poses and, if there are any, obstacles
  std::vector<NamedPose> targets;   ///< in order of preference: which stone, and where to
  RobotModel robot;                 ///< arm
  CellLayout layout;                ///< obstacles and paddings of the scene are added
  Joints q_start = Joints::Zero();  ///< joint angles at the start [rad]
  MotionOptions options;            ///< options of motion planning
};
/// A plan with its scene; the task points into the catalogue.
struct ScenePlan {
  PlanningScene scene;    ///< scene in which the motion was planned
  PickAndPlaceTask task;  ///< stone, its target, and the start of the arm
  PickAndPlacePlan plan;  ///< plan, or why there is none
};
/// Plans for the first target that can be carried out.
/// @return the last plan that failed, with what stands in the way of each target as its reason, where none
/// can.
/// @throws FileError, InvalidArgument for an unknown stone, Interrupted.
[[nodiscard]] ScenePlan plan_in_scene(const ScenePlanTask& task, const Catalogue& catalogue);

/// Verdict of coupled rigid-block analysis (Kao et al., Computer-Aided Design 146, 2022): contact forces that
/// balance the load and that small motions of the blocks produce. Forces that only balance each other, as
/// between a block and two walls that do not press on it, do not count.
struct BlockBalance {
  bool stands = false;      ///< forces and motions were found that agree
  double unbalanced = 0.0;  ///< largest force left over on a body, as a share of its weight
  int moving = -1;          ///< body on which it is left over; -1 if it stands
  double margin = 0.0;      ///< [g] horizontal acceleration borne in the weakest of 16 directions
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< W, unit: where that push goes
  double min_friction = 0.0;       ///< smallest friction coefficient that stands; infinity: none up to 2
  int weakest_contact = -1;        ///< index of the contact that gives way next in that direction; -1: none
  std::vector<StaticBody> bodies;  ///< that are no supports; masses in the unit of the input
  std::vector<Contact> contacts;   ///< of the bodies; kTable: a support
  std::vector<Eigen::Vector3d>
      forces_W;  ///< of each contact at rest on `above`, in shares of the total weight
};

/// An assembly of rigid blocks in a file to check.
struct AssemblyTask {
  std::string path;        ///< JSON of COMPAS (compas_assembly, compas_cra)
  std::string supports;    ///< blocks that do not move, comma-separated; empty: those that the file marks
  std::string densities;   ///< "11=3.51,12=3.51"; 1 for all others
  double friction = 0.84;  ///< friction coefficient of all contacts; the default is that of compas_cra
  double tilt = 0.0;       ///< [rad] turn of the assembly about y against gravity
};
/// A block of an assembly.
struct CheckedBlock {
  std::string name;      ///< its key in the file
  Mesh mesh;             ///< W, in the unit of the file
  bool support = false;  ///< does not move
};
/// An assembly, and whether and how firmly it stands.
struct AssemblyCheck {
  std::vector<CheckedBlock> blocks;  ///< in the order of their names
  std::vector<int> block_of_body;    ///< index into `blocks` of each body of `balance`
  bool interfaces_given = false;     ///< the file names the interfaces; else they were found
  int interfaces = 0;                ///< number of plane polygons of contact
  double friction = 0.0;             ///< friction coefficient that was assumed
  double tilt = 0.0;                 ///< [rad] as in the task
  BlockBalance balance;              ///< the verdict
};
/// True if a file is JSON that holds an assembly of COMPAS and no scene.
/// @throws FileError if it cannot be read.
[[nodiscard]] bool is_assembly(const std::string& path);
/// Finds where the blocks touch, unless the file says it, and solves the coupled problem.
/// @throws FileError for a file that holds no possible assembly; InvalidArgument for an unknown block.
[[nodiscard]] AssemblyCheck check_assembly(const AssemblyTask& task);

/// A tower or a wall of a scene file, and whether and how firmly it stands.
struct TowerCheck {
  Stack stack;              ///< stack that was checked
  bool wall = false;        ///< a wall, whose stones may touch any others; `verdict.clean` says nothing
  double friction = 0.0;    ///< friction coefficient that was assumed
  double seconds = 0.0;     ///< simulated
  StandVerdict verdict;     ///< verdict by simulation
  Equilibrium equilibrium;  ///< equilibrium and margin by forces alone: an upper bound
  BlockBalance balance;     ///< equilibrium and margin by coupled rigid-block analysis
  StackStatics statics;     ///< bodies and contacts of the equilibrium
};
/// Simulates the stack or the wall of a scene file for `seconds`, and solves its equilibrium, by forces and
/// coupled.
/// @throws FileError for a file without a stack or a wall, for stones that cannot be, and for stones that
/// overlap by more than 2 mm.
[[nodiscard]] TowerCheck check_tower(const std::string& scene_path, const Catalogue& catalogue,
                                     double friction, double seconds);

/// A decision of the loop to make from a state in a file (`run.save_states`).
struct DecisionTask {
  std::string state;                     ///< path
  std::string catalogue;                 ///< path; empty: as the state says
  std::string robot;                     ///< name or path; empty: as the state says
  std::vector<std::string> assignments;  ///< "NAME=VALUE", instead of the state's options
};
/// The next action of a run.
struct DecisionReport {
  std::string json;  ///< "stonestack.decision/1": action, alternatives, why
  std::string text;  ///< for a person: the action with its alternatives, a line each, then why
};
/// Decides what a run would do next in a saved state; nothing moves.
/// @throws FileError that names what is missing or unknown; InvalidArgument for an assignment.
[[nodiscard]] DecisionReport decide(const DecisionTask& task);

/// Events of a run, by its journal.
struct RunInspection {
  std::string text;    ///< for a person: a line for each of the journal, then what is odd about it
  std::string json;    ///< "stonestack.inspect/1"
  bool whole = false;  ///< the run ended, and each line is as it was written
};
/// Reads the journal of a run that ended, that was killed, or that is under way.
/// @throws FileError for a folder without one.
[[nodiscard]] RunInspection inspect_run(const std::string& folder);

/// A run to replay (`run.save_states`).
struct ReplayTask {
  std::string run;        ///< folder of the run
  std::string catalogue;  ///< path; empty: as the run says
  std::string cell;       ///< cell that the run was performed in; empty: in none with a file
};
/// A run whose decisions were made again.
struct Replay {
  long recorded = 0;       ///< lines of the journal that were to come again
  long same = 0;           ///< of these, lines that came again, to the last digit, before the first other one
  bool complete = true;    ///< false: the record of the devices ends before the run, which was killed perhaps
  std::string difference;  ///< first line that differs, recorded and now; empty: none
  std::string journal;     ///< path of the journal that the replay wrote
};
/// Performs a recorded run again with the recorded answers of its devices, and compares the journals: every
/// observation, decision, motion and outcome. Nothing moves. `report` receives what a run tells a person.
/// @throws FileError for a run without such a record, or without its stones; Interrupted
[[nodiscard]] Replay replay_run(const ReplayTask& task,
                                const std::function<void(const std::string&)>& report = {});
/// "stonestack.replay/1".
[[nodiscard]] std::string replay_json(const Replay& replay);
/// Two lines for a person, and what differs.
[[nodiscard]] std::string replay_text(const Replay& replay);

}  // namespace stonestack::stacking

#pragma GCC visibility pop
