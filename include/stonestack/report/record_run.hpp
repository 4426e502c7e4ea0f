#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/experiment/experiment.hpp"
#include "stonestack/experiment/simulated_run.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

/// Runs, experiments and recordings that write a record, and reports of them for people and for other
/// programs. The folder of a record belongs to the process that writes into it, until it ends.
namespace stonestack::report {

/// Page of the work under way for browsers on this machine, or at the other end of an SSH tunnel.
struct LiveView {
  bool wanted = false;  ///< serve it
  int port = 0;         ///< on 127.0.0.1; 0: any that is free
  /// Receives the address and the token that the page's stop button needs; a stop counts as Ctrl-C.
  std::function<void(const std::string& address, const std::string& stop_token)> announce;
};

/// Speed of the tool in a run: kByDefault is slow where a real cell has not completed a run yet.
enum class RunSpeed { kByDefault, kSlow, kFull };
/// Speed [m/s] of the tool's tip at most in a slow run; of reduced speed in ISO 10218-1.
inline constexpr double kSlowToolSpeed = 0.25;

/// A run to perform.
struct RunOrder {
  SimulatedRun run;  ///< options; those of the simulation are for simulated cells
  RobotModel robot;  ///< of a cell that is simulated in this process
  /// In place of that: real devices, which then move, or simulated ones that are served on sockets.
  std::optional<CellFile> cell;
  int per_run = 4;                        ///< stones of the catalogue that are drawn into a simulated field
  std::string out;                        ///< folder; empty: runs/TIME-SEED
  std::string version;                    ///< of the program
  LiveView view;                          ///< live view of the run
  RunSpeed speed = RunSpeed::kByDefault;  ///< speed of the tool
  bool dry = false;            ///< one view and the first plan; commands no device (`plan_first_step`)
  BeforeMotion before_motion;  ///< asked before each motion; empty: nobody is
  /// Where stones that nobody scanned are kept once they are modelled (`run.unseen`); empty: the folder
  /// `stones` of the record.
  std::string save_catalogue;
  std::string known;  ///< with `run.unseen`: catalogue of stones of which some may lie there; empty: none
  bool replace_stones = false;  ///< stones of that name that are there already are replaced
  bool only_model = false;      ///< with `run.unseen`: ends when the stones are modelled
  std::string resume;           ///< folder of a run that goes on (`read_resumable_run`); empty: a new run
};
/// A run that can go on: what `record_run` needs for it.
struct ResumableRun {
  RunOrder order;       ///< as the run was started
  Catalogue catalogue;  ///< its stones
};
/// Reads from its folder how a run was started that was killed, interrupted or stopped.
/// @throws FileError, with what to do, for a folder without such a run, a run that ended or is under way, a
/// record that is damaged, and a cell file whose layout is not the one that the run began with.
[[nodiscard]] ResumableRun read_resumable_run(const std::string& folder);

/// A run and its record.
struct RecordedRun {
  RunReport report;        ///< report of the run
  Survival survival;       ///< how the tower fares when it is tried further; empty: not tried
  std::string unwritten;   ///< the first file of the record that could not be written, and why; empty: none
  std::string folder;      ///< folder of the record
  bool resumable = false;  ///< interrupted or stopped, and `RunOrder::resume` may go on with it
};
/// Builds a tower and writes options, journal, result.json, report.html and picture into the folder, in this
/// order. A run that was killed leaves a folder without a result: `order.resume` goes on with it, and what is
/// in it is put aside where a new run is to be written there. In a real cell there is no truth to judge by,
/// and the picture shows the stones where they were seen last. The caller has asked for the permission to
/// move. A run that is not stopped and places a stone in a real cell is remembered with the cell file's path
/// and checksum, in $XDG_STATE_HOME/stonestack/cells.json (~/.local/state): only the next ones are at full
/// speed by default.
/// @throws InvalidArgument where a run that ended is in the folder, or modelled stones would replace others;
/// FileError; DeviceError.
[[nodiscard]] RecordedRun record_run(const RunOrder& order, const Catalogue& catalogue);

/// Shows a question on stderr and waits for a line on stdin.
/// @return the line; empty at the end of the input
/// @throws Interrupted
[[nodiscard]] std::optional<std::string> ask_person(const std::string& question);

/// A recording of what the camera of a cell sees while the arm stands.
struct ViewsOrder {
  /// Devices that are read, or simulated ones that are served on sockets. Empty: a cell that is simulated in
  /// this process.
  std::optional<CellFile> cell;
  RobotModel robot;              ///< of a cell that is simulated in this process
  SimulationOptions simulation;  ///< options of a simulated cell
  int per_run = 4;               ///< stones of the catalogue that are drawn into a simulated field
  int frames = 5;                ///< depth frames to take
  double every = 0.0;            ///< from the start of one frame to the next, at least [s]; 0: no pause
  std::string out;               ///< folder
  bool replace = false;          ///< write into a folder that is not empty; a recording in it is replaced
  std::string version;           ///< of the program
};
/// One frame of a recording.
struct RecordedView {
  int image = 0;              ///< number of the image in the folder, from 0
  long number = 0;            ///< number of the frame, as the camera counts
  double time = 0.0;          ///< clock of the camera [s]
  double host_time = 0.0;     ///< time by `host_seconds` [s]; in a simulated cell of its clock
  double depth_share = 0.0;   ///< share of the pixels that have a depth
  std::optional<Joints> q;    ///< joint angles after the exposure [rad]; empty: no arm was asked
  double arm_time = 0.0;      ///< clock of the arm's controller, likewise [s]
  double moved = 0.0;         ///< change of a joint during the exposure, maximum [rad]
  std::optional<Pose> T_W_C;  ///< by the arm and the cell's mounts; empty: no arm was asked, or it moved
};
/// A recording, as record.json holds it.
struct RecordedViews {
  std::string folder;               ///< folder of the recording
  std::string version;              ///< of the program
  std::string started;              ///< date and time in UTC, "2026-11-21T14:30:00Z"
  std::string cell;                 ///< path of the cell file, or the name of the simulated cell
  bool simulated = false;           ///< true: this program simulated the devices
  int seed = 0;                     ///< of the simulated cell
  std::string robot;                ///< name of the robot
  std::string camera;               ///< driver of the camera, or the simulated sensor
  CellLayout layout;                ///< mounts of the cell
  CameraIntrinsics intrinsics;      ///< of the first frame
  int asked = 0;                    ///< frames that were asked for
  std::vector<RecordedView> views;  ///< frames in order
  std::string ended;                ///< "done", "interrupted" or the error that ended it; empty: not yet
};
/// Takes depth frames without moving anything, in BOP's layout (docs/formats.md): depth/NNNNNN.png and
/// scene_camera.json, beside them record.json. The folder can be read after each frame, however the program
/// ends. The arm is asked where it is; a cell without `arm.address` and a recorded camera give no poses.
/// @return with `ended` "interrupted" after Ctrl-C, if there is a frame
/// @throws InvalidArgument for a folder that is not empty; FileError; DeviceError; Interrupted
[[nodiscard]] RecordedViews record_views(const ViewsOrder& order, const Catalogue& catalogue);
/// "stonestack.record/1": content of record.json.
[[nodiscard]] std::string views_json(const RecordedViews& record);
/// For a person: a line a frame.
[[nodiscard]] std::string views_table(const RecordedViews& record);

/// Adds runs of an experiment to its record, as `perform_experiment_run` gave them, and returns lines about
/// them for a person. The record on the disk has them then. Throws FileError.
using TakeRuns = std::function<std::string(const std::vector<std::string>& runs)>;
/// Performs runs of an experiment in other processes, in any order: the runs `numbers`, whose record is in
/// `folder`. What has ended is given to `take`, by one thread at a time; the others count as missing.
using PerformRuns =
    std::function<void(const std::string& folder, const std::vector<int>& numbers, const TakeRuns& take)>;

/// Consecutive runs of stones that are drawn anew each time: from the catalogue, or with `new_stones` ones
/// that no other run of the experiment has.
struct ExperimentOrder {
  SimulatedRun run;               ///< options of all runs
  RobotModel robot;               ///< arm of every run
  int seed = 1;                   ///< run k has the seed 1000 seed + k
  int runs = 11;                  ///< number of runs, of all shards
  Shard shard;                    ///< runs that are performed here; they are the same as without the others
  int stones = 6;                 ///< of the catalogue, to draw from
  int new_stones = 0;             ///< stones that each run has for itself; 0: those of the catalogue for all
  std::string new_stones_from;    ///< catalogue folder that they are drawn from; empty: generated limestones
  std::string protocol = "full";  ///< when a run ends: full or paper (`apply_protocol`)
  int per_run = 4;                ///< in the field of each run
  bool survival = true;           ///< try each tower further
  bool continues = false;         ///< with what the folder `out` holds
  std::vector<Variant> variants;  ///< rows of a comparison; empty: the runs as they are
  std::string out;                ///< folder; empty: experiments/TIME-SEED
  std::string version;            ///< of the program
  LiveView view;                  ///< live view of heights and costs
  PerformRuns perform_elsewhere;  ///< empty: the runs are performed here, one after the other
};
/// An experiment and its record.
struct RecordedExperiment {
  /// Runs that are done; of a comparison, those of the last variant. Events and timeline of each are in its
  /// folder only, so that memory does not grow with the runs.
  Experiment experiment;
  std::string comparison;    ///< a table with a row for each variant that has runs
  std::string folder;        ///< folder of the record
  bool interrupted = false;  ///< by the user: the run under way is not counted
  std::string unwritten;     ///< what of the last run's record could not be written; empty: nothing
  /// Runs that no folder of a merge holds, or that no other process performed: "2, 4 to 7"; empty: none.
  std::string missing;
};
/// Performs the runs. What is done is on the disk after each of them. `listener` hears each line of a
/// comparison's table once it is known.
/// @throws InvalidArgument and FileError before the first run, also for a folder that other options made.
[[nodiscard]] RecordedExperiment record_experiment(
    const ExperimentOrder& order, const Catalogue& catalogue,
    const std::function<void(const std::string& line)>& listener = {});
/// Performs run `number` of an experiment whose record another process keeps in `folder`, and writes the
/// folder of this run there.
/// @return the run for `TakeRuns` ("stonestack.experiment/1", of this run alone)
/// @throws InvalidArgument for a comparison; Interrupted; FileError, and Error where its record is not whole
[[nodiscard]] std::string perform_experiment_run(const ExperimentOrder& order, const Catalogue& catalogue,
                                                 const std::string& folder, int number);
/// Joins the records of the shards of one experiment, finished or not, into the record that the experiment
/// has without shards; the folders of the runs are copied into it. Nothing is written into the shards. What
/// is missing can be done by `record_experiment` with `continues`.
/// @param out folder to make; empty: experiments/TIME-SEED
/// @throws InvalidArgument where `out` is there already or in a shard; FileError, which names folder and
/// value, where a shard is of another experiment or a run is in two folders; Interrupted
[[nodiscard]] RecordedExperiment merge_experiments(const std::vector<std::string>& shards,
                                                   const std::string& out);

/// "stonestack.run/1" (README, "Output formats"): one JSON object, times included.
[[nodiscard]] std::string run_json(const RunReport& report);
/// The table that a person reads at the end of a run: stone, cost and its terms, planned and measured pose,
/// outcome, times.
[[nodiscard]] std::string run_table(const RunReport& report);
/// One self-contained HTML file: the cell in 3-D over the whole time of the run, decisions with the
/// placements that were compared, tables, times, the paper's figure 5, options. Without WebGL it shows the
/// picture `report.picture`. Throws FileError if that cannot be read.
[[nodiscard]] std::string run_html(const RunReport& report, const Catalogue& catalogue,
                                   const RobotModel& robot);
/// For a person: histogram beside the paper's, times beside the paper's, survival, predictions, a line a run.
[[nodiscard]] std::string experiment_table(const Experiment& experiment);
/// "stonestack.experiment/1".
[[nodiscard]] std::string experiment_json(const Experiment& experiment);
/// Reads a file that experiment_json wrote. It omits catalogue, options and estimates of the runs. Throws
/// FileError.
[[nodiscard]] Experiment read_experiment(const std::string& path);
/// A line a run: run, seed, stones, height, end, times.
[[nodiscard]] std::string runs_csv(const Experiment& experiment);
/// The paper's figure 5: cost of each selected pose by level, a colour a run, a ring where the placement held
/// and a cross where it failed; as CSV and as SVG.
[[nodiscard]] std::string figure5_csv(const Experiment& experiment);
/// Costs of all placements by level, held or fallen, as the paper's figure 5, in SVG.
[[nodiscard]] std::string figure5_svg(const Experiment& experiment);

/// Formats of `export_run`: glb, ply, urdf, csv, mcap, png, compas.
[[nodiscard]] std::vector<std::string> export_formats();
/// Writes a recorded run into the folder `out` (empty: RUN/export) in one of these formats. Stones are where
/// they were measured last.
/// @return paths of the files.
/// @throws InvalidArgument for another format; FileError for a folder without the record of a run that ended.
std::vector<std::string> export_run(const std::string& run, const std::string& format,
                                    const std::string& out = {});
/// JSON of what `export_run` has written, schema "stonestack.export/1".
[[nodiscard]] std::string export_json(const std::string& format, const std::vector<std::string>& files);

}  // namespace stonestack::report

#pragma GCC visibility pop
