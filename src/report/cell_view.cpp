#include <cmath>
#include <filesystem>
#include <set>

#include "core/yaml.hpp"
#include "report/base64.hpp"
#include "report/cell_page.hpp"
#include "report/run_page.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::report {
namespace {

using Verdict = CellCheck::Verdict;

constexpr double kCellDegrees = 180.0 / M_PI;
constexpr double kEndless = 9.99;  // m: no end of a range of limits

/// "0.7, 0.28"
template <class Vector>
std::string list_text(const Vector& values, const char* pattern = "%.4g") {
  std::string text;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    text += concat(i > 0 ? ", " : "", format(pattern, values[i] + 0.0));
  return text;
}

std::string pose_words(const Pose& pose) {
  const Eigen::AngleAxisd turn(pose.linear());
  std::string text = concat("(", list_text(pose.translation()), ") m");
  if (turn.angle() * kCellDegrees < 1e-3) return text + ", not turned";
  return concat(text, format(", turned %.2f deg about (", turn.angle() * kCellDegrees),
                list_text(turn.axis(), "%.3f"), ")");
}

std::string box_words(const Eigen::AlignedBox3d& box) {
  std::string text;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto end = [&](double value) {
      return std::abs(value) > kEndless ? std::string("no end") : format("%.4g", value);
    };
    text += concat(i > 0 ? ", " : "", "xyz"[i], " ", end(box.min()[i]), " to ", end(box.max()[i]));
  }
  return text + " m";
}

Eigen::AlignedBox3d bounds_in_world(const Obstacle& obstacle) {
  Eigen::AlignedBox3d box;
  for (const Mesh& piece : obstacle.pieces) box.extend(bounds(transformed(piece, obstacle.T_W_O)));
  return box;
}

/// Rows of the page's table: name, value, where the value is from.
class NumberRows {
 public:
  explicit NumberRows(const std::string& cell_file) {
    yaml::for_each_scalar(yaml::read_file(cell_file),
                          [&](const std::string& name, const std::string&) { given_.insert(name); });
  }
  /// `field`: name of the setting in a cell file, or of its group; empty: it follows from the others.
  void add(const std::string& what, const std::string& value, const std::string& field) {
    const bool given = std::any_of(given_.begin(), given_.end(), [&](const std::string& name) {
      return name == field || name.starts_with(field + ".") || name.starts_with(field + "[");
    });
    rows_.push_back({what, value, field.empty() ? "computed" : given ? field : "default"});
  }
  [[nodiscard]] const nlohmann::json& rows() const { return rows_; }

 private:
  std::set<std::string> given_;
  nlohmann::json rows_ = nlohmann::json::array();
};

std::string lens_words(const CellPreview& cell) {
  if (!cell.camera) return "none";
  const CameraIntrinsics& c = *cell.camera;
  return format("%d x %d, %.0f x %.0f deg", c.width, c.height,
                2 * std::atan(0.5 * c.width / c.fx) * kCellDegrees,
                2 * std::atan(0.5 * c.height / c.fy) * kCellDegrees) +
         (cell.camera_is_assumed ? ", assumed until the camera says it" : "");
}

nlohmann::json number_rows(const CellConfig& config, const CellPreview& cell) {
  const CellLayout& layout = cell.layout;
  const RobotModel& robot = cell.robot;
  NumberRows rows(config.file);
  rows.add("robot", config.robot, "robot");
  rows.add("gripper", layout.gripper, "hand");
  rows.add("controller", config.arm.address.empty() ? "none" : config.arm.address, "arm.address");
  rows.add("robot base, T_W_R", pose_words(layout.T_W_R), "layout.T_W_R");
  rows.add("tool tip, T_F_T", pose_words(layout.T_F_T), "layout.T_F_T");
  if (config.T_F_C) rows.add("camera, T_F_C", pose_words(*config.T_F_C), "layout.hand_eye");
  rows.add("camera, T_T_C", pose_words(layout.T_T_C), config.T_F_C ? "layout.hand_eye" : "layout.T_T_C");
  rows.add("lens", lens_words(cell), "camera");
  rows.add("site", concat("(", list_text(layout.site), ") m"), "layout.site");
  rows.add(
      "field",
      concat("(", list_text(layout.field_centre), ") m, ", list_text(layout.field_size), " m wide and deep"),
      "layout.field");
  for (const Obstacle& obstacle : layout.obstacles)
    rows.add("obstacle " + obstacle.name, box_words(bounds_in_world(obstacle)), "layout.obstacles");
  if (layout.obstacles.empty()) rows.add("obstacles", "none", "layout.obstacles");
  rows.add("workspace of the tool tip", robot.workspace ? box_words(robot.workspace->box) : "no limit",
           "limits.workspace");
  rows.add("fence of the whole arm", robot.fence ? box_words(robot.fence->box) : "no limit", "limits.fence");
  rows.add("tool speed", format("%.4g m/s at most", robot.tool_speed), "limits.tool_speed");
  rows.add("joint speed", list_text(Joints(robot.velocity * kCellDegrees), "%.0f") + " deg/s",
           "limits.joint_speed");
  rows.add("joints, lower", list_text(Joints(robot.lower * kCellDegrees), "%.1f") + " deg", "limits.joints");
  rows.add("joints, upper", list_text(Joints(robot.upper * kCellDegrees), "%.1f") + " deg", "limits.joints");
  for (const CellPose& pose : cell.poses)
    rows.add("joints, " + pose.name, list_text(Joints(pose.q * kCellDegrees), "%.1f") + " deg", "");
  return rows.rows();
}

nlohmann::json obstacle_entry(const Obstacle& obstacle) {
  nlohmann::json vertices = nlohmann::json::array(), faces = nlohmann::json::array();
  int first = 0;
  for (const Mesh& piece : obstacle.pieces) {
    for (const Eigen::Vector3d& v : piece.vertices)
      for (const auto& x : numbers(Eigen::Vector3d(obstacle.T_W_O * v))) vertices.push_back(x);
    for (const Eigen::Vector3i& face : piece.faces)
      for (const int corner : face) faces.push_back(first + corner);
    first += static_cast<int>(piece.vertices.size());
  }
  const Eigen::AlignedBox3d box = bounds_in_world(obstacle);
  const Eigen::Vector3d top(box.center().x(), box.center().y(), box.max().z() + 0.05);
  return {{"name", obstacle.name}, {"vertices", vertices}, {"faces", faces}, {"top", numbers(top)}};
}

nlohmann::json flat_numbers(const std::vector<Eigen::Vector2d>& points) {
  nlohmann::json list = nlohmann::json::array();
  for (const Eigen::Vector2d& p : points) {
    const nlohmann::json v = numbers(Eigen::Vector3d(p.x(), p.y(), 0.0));
    list.push_back({v[0], v[1]});
  }
  return list;
}

nlohmann::json box_entry(const Eigen::AlignedBox3d& limits, const CellPreview& cell) {
  const Eigen::AlignedBox3d box = within_sight(limits, cell);
  return {{"min", numbers(Eigen::Vector3d(box.min()))}, {"max", numbers(Eigen::Vector3d(box.max()))}};
}

nlohmann::json pose_entry(const CellPose& pose) {
  nlohmann::json seen = nlohmann::json::array();
  for (const Eigen::Vector3d& corner : pose.p_W_seen) seen.push_back(numbers(corner));
  return {{"name", pose.name},
          {"q", std::vector<double>(pose.q.begin(), pose.q.end())},
          {"T_W_C", numbers(pose.T_W_C)},
          {"seen", seen}};
}

nlohmann::json facts_of(const CellPreview& cell) {
  const auto& checks = cell.report.checks;
  const auto notes = std::count_if(checks.begin(), checks.end(),
                                   [](const CellCheck& check) { return check.verdict == Verdict::kNote; });
  double reach = 0.0;
  for (const Eigen::Vector2d& p : cell.p_W_reach)
    reach = std::max(reach, (p - cell.layout.T_W_R.translation().head<2>()).norm());
  return {{std::to_string(cell.report.failed()), "of " + std::to_string(checks.size()) + " checks failed",
           cell.report.failed() > 0 ? "bad" : "good"},
          {std::to_string(notes), "notes", ""},
          {format("%.2f m", reach), "reach on the table, gripper down", ""},
          {std::to_string(cell.layout.obstacles.size()), "obstacles", ""}};
}

/// File name without folder and ending.
std::string stem_of(const std::string& path) {
  return std::filesystem::path(path).stem().string();
}

/// Where page and picture go; empty: it is not written.
struct Outputs {
  std::string page, picture;
  Outputs(const std::string& out, const std::string& cell) {
    const bool is_page = out.ends_with(".html"), is_picture = out.ends_with(".png");
    if (out.empty()) page = stem_of(cell) + "_view.html";
    if (is_page) page = out;
    if (is_picture) picture = out;
    if (out.empty() || is_page || is_picture) return;
    page = (std::filesystem::path(out) / "cell.html").string();
    picture = (std::filesystem::path(out) / "cell.png").string();
  }
};

}  // namespace

std::string cell_page_data(const std::string& name, const CellConfig& config, const CellPreview& cell,
                           const View& view, const std::string& picture) {
  const CellLayout& layout = cell.layout;
  nlohmann::json findings = nlohmann::json::array(), obstacles = nlohmann::json::array(),
                 poses = nlohmann::json::array();
  for (const CellCheck& check : cell.report.checks)
    findings.push_back({{"device", check.device},
                        {"step", check.step},
                        {"text", check.text},
                        {"mood", check.verdict == Verdict::kFailed ? "bad"
                                 : check.verdict == Verdict::kNote ? "note"
                                                                   : "good"}});
  for (const Obstacle& obstacle : layout.obstacles) obstacles.push_back(obstacle_entry(obstacle));
  for (const CellPose& pose : cell.poses) poses.push_back(pose_entry(pose));
  const RobotModel& robot = cell.robot;
  return one_line(
      {{"title", "Cell " + name},
       {"subtitle", config.robot + ", " + layout.gripper + ", " + config.file},
       {"facts", facts_of(cell)},
       {"findings", findings},
       {"numbers", number_rows(config, cell)},
       {"robot_model", robot_entry(robot, layout)},
       {"opening", gripper_of(layout).max_opening},
       {"stones", nlohmann::json::array()},
       {"site", {layout.site.x(), layout.site.y()}},
       {"field",
        {{"centre", {layout.field_centre.x(), layout.field_centre.y()}},
         {"size", {layout.field_size.x(), layout.field_size.y()}}}},
       {"base", numbers(Eigen::Vector3d(layout.T_W_R * Eigen::Vector3d(-0.16, 0.0, 0.04)))},
       {"obstacles", obstacles},
       {"workspace", robot.workspace ? box_entry(robot.workspace->box, cell) : nlohmann::json(nullptr)},
       {"fence", robot.fence ? box_entry(robot.fence->box, cell) : nlohmann::json(nullptr)},
       {"reach", flat_numbers(cell.p_W_reach)},
       {"too_near", flat_numbers(cell.p_W_too_near)},
       {"poses", poses},
       {"has_camera", cell.camera.has_value()},
       {"view", {{"eye", numbers(view.p_W_eye)}, {"target", numbers(view.p_W_target)}}},
       {"picture", picture}});
}

ShownCell show_cell(const CellViewOrder& order) {
  const CellFile file = read_cell(order.cell);
  ShownCell view{file.path, {}, {}};
  const Outputs outputs(order.out, file.path);
  for (const std::string& path : {outputs.page, outputs.picture})
    if (!path.empty()) require_writable(path);
  view.preview = preview_cell(file.cell(), {order.q_start, file.simulate});
  const std::vector<DrawnMesh> meshes = drawn_cell(view.preview);
  const View camera = view_of_cell(meshes);
  const std::string picture = png_bytes(draw(meshes, camera));
  if (!outputs.page.empty()) {
    const std::string name = stem_of(file.path), uri = "data:image/png;base64," + base64(picture);
    write_file(outputs.page, cell_page("Cell " + name, cell_view_text(view),
                                       cell_page_data(name, file.cell(), view.preview, camera, uri)));
    view.files.push_back(outputs.page);
  }
  if (!outputs.picture.empty()) {
    write_file(outputs.picture, picture);
    view.files.push_back(outputs.picture);
  }
  return view;
}

std::string cell_view_json(const ShownCell& view) {
  nlohmann::json out = nlohmann::json::parse(cell_report_json(view.preview.report));
  out["schema"] = "stonestack.view/1";
  out["cell"] = view.cell;
  out["files"] = view.files;
  out["poses"] = nlohmann::json::array();
  for (const CellPose& pose : view.preview.poses) {
    nlohmann::json entry = {{"name", pose.name},
                            {"q", std::vector<double>(pose.q.begin(), pose.q.end())},
                            {"T_W_C", pose_json(pose.T_W_C)},
                            {"p_W_seen", nlohmann::json::array()}};
    for (const Eigen::Vector3d& corner : pose.p_W_seen) entry["p_W_seen"].push_back(corner);
    out["poses"].push_back(entry);
  }
  return out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string cell_view_text(const ShownCell& view) {
  std::string text;
  for (const CellCheck& check : view.preview.report.checks) text += to_text(check) + "\n";
  for (const std::string& file : view.files) text += file + " shows the cell\n";
  return text;
}

}  // namespace stonestack::report
