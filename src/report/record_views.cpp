#include "report/record_views.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <memory>
#include <thread>

#include "geometry/bop_folder.hpp"
#include "hardware/cell_config.hpp"
#include "report/record_folder.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/report/results.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kStandingStill = 1e-3;  // rad of a joint: about 1 mm at the camera of a UR10
constexpr double kInterruptTurn = 0.02;  // s between questions for Ctrl-C in a pause

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

void remove_recorded(const fs::path& path) {
  std::error_code failed;
  fs::remove(path, failed);
  if (failed) throw FileError(path.string(), failed.message(), "name another folder with --out");
}

/// A folder with depth images of somebody else is refused in any case: their list would be lost.
void check_folder(const std::string& folder, bool replace) {
  std::error_code unreadable;
  if (fs::is_empty(folder, unreadable)) return;
  require(replace, folder, " is not empty; name another folder with --out, or add --force, which replaces ",
          "a recording in it");
  require(fs::exists(fs::path(folder) / "record.json") || !is_depth_sequence(folder), folder,
          " holds depth images that stonestack did not record; name another folder with --out");
}

/// Removes an earlier recording, the list of its images first.
void remove_recording(const std::string& folder) {
  const fs::path path(folder);
  if (!fs::exists(path / "record.json")) return;
  remove_recorded(path / "scene_camera.json");
  for (int number = 0; fs::exists(bop_depth_path(folder, number)); ++number)
    remove_recorded(bop_depth_path(folder, number));
  remove_recorded(path / "record.json");
}

/// Folder of a recording under way.
class ViewsFolder {
 public:
  explicit ViewsFolder(RecordedViews& record) : record_(record), images_(record.folder) {}
  /// Writes one frame; record.json is there before any image.
  void add(const DepthImage& image, const RecordedView& view) {
    if (record_.views.empty()) {
      remove_recording(record_.folder);  // not before there is something to take its place
      record_.intrinsics = image.camera;
      write();
    }
    images_.add(image, view.time, view.T_W_C);
    record_.views.push_back(view);
    write();
  }
  /// Notes how the recording ended, if anything was recorded.
  void end(const std::string& how) {
    record_.ended = how;
    if (!record_.views.empty()) write();
  }

 private:
  void write() { write_file(record_.folder + "/record.json", views_json(record_)); }

  RecordedViews& record_;
  BopFolder images_;
};

double share_with_depth(const DepthImage& image) {
  const auto with = std::count_if(image.z.begin(), image.z.end(), [](float z) { return z > 0.0F; });
  return static_cast<double>(with) / static_cast<double>(std::max<std::size_t>(1, image.z.size()));
}

/// Takes one frame between two readings of the joints.
void take_frame(const WatchedCell& cell, const CellLayout& layout, int image, ViewsFolder& folder) {
  RecordedView view;
  view.image = image;
  std::optional<JointReading> before;
  if (cell.joints) before = cell.joints();
  const DepthFrame frame = cell.camera.capture();
  if (before) {
    const JointReading after = cell.joints();
    view.q = after.q;
    view.arm_time = after.device_time;
    view.moved = (after.q - before->q).cwiseAbs().maxCoeff();
    if (view.moved <= kStandingStill)
      view.T_W_C = layout.T_W_R * forward(cell.robot, after.q) * layout.T_F_T * layout.T_T_C;
    else
      log_warning(concat("frame ", image, ": the arm moved by ", view.moved,
                         " rad meanwhile; it is recorded without the camera's pose"));
  }
  view.number = frame.number;
  view.time = frame.device_time;
  view.host_time = frame.host_time;
  view.depth_share = share_with_depth(frame.image);
  folder.add(frame.image, view);
}

/// Notes an error in the record; where that fails, too, the first error is the one to report.
void note_error(ViewsFolder& folder, const RecordedViews& record, const Error& problem) {
  try {
    folder.end(problem.what());
  } catch (const FileError&) {
    log_debug("record.json does not hold this error");
  }
  log_info(concat(record.views.size(), " of ", record.asked, " frames are in ", record.folder));
}

void wait_on_host(double seconds) {
  for (const Stopwatch watch; watch.seconds() < seconds;) {
    throw_if_interrupted();
    std::this_thread::sleep_for(
        std::chrono::duration<double>(std::min(kInterruptTurn, seconds - watch.seconds())));
  }
}

/// Reason why no arm is asked where the camera is; empty: one is.
std::string no_arm(const CellConfig& cell) {
  if (cell.camera == "recorded") return "camera.driver is recorded: the arm is not where it was then";
  if (cell.arm.address.empty()) return "arm.address is missing";
  return "";
}

std::unique_ptr<JointReader> connect_arm(const CellConfig& cell) {
  try {
    return std::make_unique<JointReader>(cell.arm);
  } catch (const DeviceError&) {
    log_info("--set arm.address= records the camera alone");
    throw;
  }
}

/// Reads devices on their wires.
RecordedViews record_devices(const ViewsOrder& order, const CellConfig& config, RecordedViews record) {
  const auto clock = make_steady_clock();
  const auto camera = make_camera(config);
  std::unique_ptr<JointReader> arm;
  if (const std::string why = no_arm(config); why.empty())
    arm = connect_arm(config);
  else
    log_warning(concat(record.cell, ": ", why, "; frames are recorded without the camera's pose"));
  WatchedCell watched{*camera, {}, *clock, wait_on_host, read_cell_robot(config)};
  if (arm) watched.joints = [&arm] { return arm->read(); };
  record.camera = config.camera;
  record.layout = to_layout(config);
  return record_cell(order, watched, std::move(record));
}

/// Simulated cell with stones in its field.
std::unique_ptr<SimulatedCell> make_simulated(const ViewsOrder& order, const Catalogue& catalogue,
                                              const RobotModel& robot, const CellLayout& layout) {
  const auto present =
      draw_stones(catalogue, order.per_run, order.simulation.seed, gripper_of(layout), robot);
  return std::make_unique<SimulatedCell>(catalogue.stones, present, robot, layout, order.simulation);
}

RecordedViews record_in_process(const ViewsOrder& order, const Catalogue& catalogue, RecordedViews record) {
  const auto world = make_simulated(order, catalogue, order.robot, record.layout);
  const Cell cell = world->cell();
  record.cell = order.simulation.cell;
  record.camera = "simulated " + order.simulation.sensor;
  const auto joints = [&cell] {
    const ArmState state = cell.arm.state();
    return JointReading{state.q, state.device_time};
  };
  const auto wait = [&world](double seconds) { world->wait(seconds); };
  return record_cell(order, {cell.camera, joints, cell.clock, wait, order.robot}, std::move(record));
}

RecordedViews record_over_sockets(const ViewsOrder& order, const Catalogue& catalogue, RecordedViews record) {
  CellFile file = *order.cell;
  const RobotModel robot = read_robot(file.robot());
  const auto world =
      make_simulated(order, catalogue, robot, true_layout(to_layout(file.cell()), file.servers()));
  const SimulatedServers servers(*world, robot, file.servers());
  connect_to(servers, file.cell());
  return record_devices(order, file.cell(), std::move(record));
}

json camera_json(const RecordedViews& record) {
  const CameraIntrinsics& camera = record.intrinsics;
  return {{"name", record.camera},
          {"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"distortion", distortion_name(camera.distortion)},
          {"k", camera.k}};
}

json view_json(const RecordedView& view) {
  json frame = {{"image", view.image},
                {"number", view.number},
                {"time", view.time},
                {"host_time", view.host_time},
                {"depth_share", view.depth_share}};
  if (!view.q) return frame;
  frame["q"] = std::vector<double>(view.q->begin(), view.q->end());
  frame["arm_time"] = view.arm_time;
  frame["moved_rad"] = view.moved;
  if (view.T_W_C) frame["T_W_C"] = pose_json(*view.T_W_C);
  return frame;
}

}  // namespace

RecordedViews record_cell(const ViewsOrder& order, const WatchedCell& cell, RecordedViews record) {
  record.version = order.version;
  record.started = utc_now();
  record.robot = cell.robot.name;
  record.asked = order.frames;
  ViewsFolder folder(record);
  const Stopwatch watch;
  const double start = cell.clock.now();
  try {
    for (int image = 0; image < order.frames; ++image) {
      throw_if_interrupted();
      cell.wait(start + image * order.every - cell.clock.now());
      take_frame(cell, record.layout, image, folder);
      show_progress(
          {"record", image + 1.0, static_cast<double>(order.frames), "frames", "", watch.seconds()});
    }
    folder.end("done");
  } catch (const Interrupted&) {
    if (record.views.empty()) throw;
    folder.end("interrupted");
  } catch (const Error& problem) {
    if (!record.views.empty()) note_error(folder, record, problem);
    throw;
  }
  return record;
}

RecordedViews record_views(const ViewsOrder& order, const Catalogue& catalogue) {
  require(order.frames >= 1, "a recording has a frame or more, not ", order.frames);
  const RecordFolder folder(order.out);
  check_folder(folder.path(), order.replace);
  RecordedViews record;
  record.folder = folder.path();
  record.seed = order.simulation.seed;
  record.simulated = true;
  if (!order.cell) return record_in_process(order, catalogue, std::move(record));
  record.cell = order.cell->path;
  if (order.cell->simulate && !is_served_elsewhere(*order.cell))
    return record_over_sockets(order, catalogue, std::move(record));
  record.simulated = order.cell->simulate;
  return record_devices(order, order.cell->cell(), std::move(record));
}

std::string views_json(const RecordedViews& record) {
  json cell = {{"name", record.cell},
               {"simulated", record.simulated},
               {"robot", record.robot},
               {"T_W_R", pose_json(record.layout.T_W_R)},
               {"T_F_T", pose_json(record.layout.T_F_T)},
               {"T_T_C", pose_json(record.layout.T_T_C)}};
  if (record.simulated) cell["seed"] = record.seed;
  json frames = json::array();
  for (const RecordedView& view : record.views) frames.push_back(view_json(view));
  return document({{"schema", "stonestack.record/1"},
                   {"version", record.version},
                   {"started", record.started},
                   {"cell", cell},
                   {"camera", camera_json(record)},
                   {"asked", record.asked},
                   {"ended", record.ended},
                   {"frames", frames}});
}

std::string views_table(const RecordedViews& record) {
  std::string text = "image      time s  depth %  camera at x, y, z in W, m\n";
  for (const RecordedView& view : record.views) {
    text += format("%5d  %10.3f  %7.1f  ", view.image, view.time, 100.0 * view.depth_share);
    if (view.T_W_C) {
      const Eigen::Vector3d& p = view.T_W_C->translation();
      text += format("%.4f, %.4f, %.4f\n", p.x(), p.y(), p.z());
    } else {
      text += view.q ? "unknown: the arm moved\n" : "unknown: no arm\n";
    }
  }
  const CameraIntrinsics& camera = record.intrinsics;
  return text + concat(record.views.size(), " of ", record.asked, " frames of ", camera.width, " x ",
                       camera.height, " in ", record.folder, "\n");
}

}  // namespace stonestack::report
