#include "report/run_record.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include "report/base64.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxRecordFile = std::size_t{1} << 28;
constexpr double kUnitQuaternion = 1e-3;  // by which its norm may be off: the page's numbers are rounded
constexpr std::size_t kSampleWidth = 11;  // t, six joints, opening, spacing, force, holds
constexpr const char* kRemedy = "name the folder of a run that ended, as `stonestack run` wrote it";

/// Why a record cannot be read; the file is added where it is known.
[[noreturn]] void wrong(const std::string& problem) {
  throw std::runtime_error(problem);
}

Pose pose_of(const Eigen::Vector3d& p, const Eigen::Quaterniond& q) {
  if (!p.allFinite() || !(std::abs(q.norm() - 1.0) < kUnitQuaternion)) wrong("a pose that is none");
  return make_pose(p, q);
}

Pose listed_pose(const json& numbers) {
  const auto v = numbers.get<std::vector<double>>();
  if (v.size() != 7) wrong(concat("a pose of ", v.size(), " numbers"));
  return pose_of({v[0], v[1], v[2]}, {v[6], v[3], v[4], v[5]});
}

Pose named_pose(const json& pose) {
  const auto number = [&](const char* key) { return pose.at(key).get<double>(); };
  return pose_of({number("x"), number("y"), number("z")},
                 {number("qw"), number("qx"), number("qy"), number("qz")});
}

template <class Number>
std::vector<Number> unpacked(const json& text) {
  const std::string bytes = base64_bytes(text.get<std::string>());
  if (bytes.size() % sizeof(Number) != 0) wrong("an array that is cut off");
  std::vector<Number> values(bytes.size() / sizeof(Number));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

RecordedStone stone_of(const json& entry) {
  RecordedStone stone;
  stone.name = entry.at("name").get<std::string>();
  const auto vertices = unpacked<float>(entry.at("vertices"));
  const auto faces = unpacked<std::uint16_t>(entry.at("faces"));
  if (vertices.size() % 3 != 0 || faces.size() % 3 != 0) wrong("a mesh that is cut off");
  for (std::size_t i = 0; i < vertices.size(); i += 3) {
    stone.mesh.vertices.emplace_back(vertices[i], vertices[i + 1], vertices[i + 2]);
    if (!stone.mesh.vertices.back().allFinite()) wrong("a vertex that is not finite");
  }
  for (std::size_t i = 0; i < faces.size(); i += 3) {
    for (std::size_t k = i; k < i + 3; ++k)
      if (faces[k] >= stone.mesh.vertices.size()) wrong("a face without its vertex");
    stone.mesh.faces.emplace_back(faces[i], faces[i + 1], faces[i + 2]);
  }
  return stone;
}

/// Arm of the page: joint frames at zero angle, and the tool.
struct PageArm {
  std::vector<Pose> T_parent_joint;
  Pose T_W_R, T_6_T;
  [[nodiscard]] Pose T_W_T(const Joints& q) const {
    Pose T = T_W_R;
    for (std::size_t i = 0; i < T_parent_joint.size(); ++i)
      T = T * T_parent_joint[i] *
          Pose(Eigen::AngleAxisd(q[static_cast<Eigen::Index>(i)], Eigen::Vector3d::UnitZ()));
    return T * T_6_T;
  }
};

PageArm arm_of(const json& model) {
  PageArm arm;
  for (const json& pose : model.at("T_parent_joint")) arm.T_parent_joint.push_back(listed_pose(pose));
  if (arm.T_parent_joint.size() != 6) wrong(concat("an arm of ", arm.T_parent_joint.size(), " joints"));
  arm.T_W_R = listed_pose(model.at("T_W_R"));
  arm.T_6_T = listed_pose(model.at("T_6_F")) * listed_pose(model.at("T_F_T"));
  return arm;
}

/// Time [s] in whole milliseconds, as the page has it: samples are stored with fewer digits than other times.
double page_time(double time) {
  if (!(std::abs(time) < 1e9)) wrong("a time that is not finite");
  return std::round(1000.0 * time) / 1000.0;
}

std::size_t stone_index(const json& number, const RunRecord& record) {
  const auto index = number.get<std::size_t>();
  if (index >= record.stones.size()) wrong(concat("stone ", index, " of ", record.stones.size()));
  return index;
}

void add_samples(RunRecord& record, const json& page) {
  const auto flat = unpacked<float>(page.at("samples"));
  if (flat.size() % kSampleWidth != 0) wrong("samples that are cut off");
  for (std::size_t i = 0; i < flat.size(); i += kSampleWidth) {
    RecordedSample s;
    s.time = page_time(flat[i]);
    for (std::size_t k = 0; k < 6; ++k) s.q[static_cast<Eigen::Index>(k)] = flat[i + 1 + k];
    s.opening = flat[i + 7];
    s.force = flat[i + 9];
    s.holds = flat[i + 10] != 0.0F;
    if (!s.q.allFinite() || !std::isfinite(s.opening) || !std::isfinite(s.force))
      wrong("a sample that is not finite");
    record.samples.push_back(s);
  }
}

/// Poses of the stones over time: where a view showed them, and in the gripper while it carried them.
void add_motion(RunRecord& record, const json& page) {
  const PageArm arm = arm_of(page.at("robot_model"));
  record.T_W_R = arm.T_W_R;
  for (const json& view : page.at("views")) {
    const auto time = page_time(view.at("t").get<double>());
    for (const json& seen : view.at("stones"))
      record.stones[stone_index(seen.at(0), record)].motion.push_back({time, listed_pose(seen.at(1))});
    record.last_view.clear();
    for (const json& seen : view.at("stones")) record.last_view.push_back(stone_index(seen.at(0), record));
  }
  for (const json& entry : page.at("carries")) {
    RecordedCarry carry;
    const std::size_t stone = stone_index(entry.at("stone"), record);
    carry.stone = static_cast<int>(stone);
    carry.begin = page_time(entry.at("begin").get<double>());
    carry.end = page_time(entry.at("end").get<double>());
    carry.T_T_O = listed_pose(entry.at("T_T_O"));
    for (const RecordedSample& s : record.samples)
      if (s.time >= carry.begin && s.time <= carry.end)
        record.stones[stone].motion.push_back({s.time, arm.T_W_T(s.q) * carry.T_T_O});
    record.carries.push_back(carry);
  }
  for (RecordedStone& stone : record.stones) {
    auto& motion = stone.motion;
    std::stable_sort(motion.begin(), motion.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    std::vector<Keyframe> rising;  // of two poses at one time the later one counts
    for (const Keyframe& frame : motion) {
      if (!rising.empty() && rising.back().time >= frame.time)
        rising.back().T_W_O = frame.T_W_O;
      else
        rising.push_back(frame);
    }
    motion = rising;
  }
}

void add_placements(RunRecord& record, const json& result) {
  for (const json& entry : result.at("placements")) {
    RecordedPlacement p;
    p.stone = entry.at("stone").get<std::string>();
    p.outcome = entry.at("outcome").get<std::string>();
    p.level = entry.at("level").get<int>();
    p.cost = entry.at("cost").get<double>();
    p.predicted_success = entry.at("predicted_success").get<double>();
    p.T_W_O_planned = named_pose(entry.at("T_W_O_planned"));
    if (!entry.at("T_W_O_measured").is_null()) p.T_W_O_measured = named_pose(entry.at("T_W_O_measured"));
    record.placements.push_back(p);
  }
}

/// Levels of the stones that the run reports stacked: the first ones of its last view.
void number_tower(RunRecord& record) {
  if (record.height < 0) wrong(concat("a height of ", record.height));
  const std::size_t height = std::min(static_cast<std::size_t>(record.height), record.last_view.size());
  for (std::size_t level = 1; level <= height; ++level)
    record.stones[record.last_view[level - 1]].level = static_cast<int>(level);
}

json parsed_page(const std::string& path) {
  const std::string text = read_file(path, kMaxRecordFile);
  constexpr std::string_view kBegin = "\nconst run = ", kEnd = ";\n</script>";
  const std::size_t begin = text.find(kBegin);
  const std::size_t end = begin == std::string::npos ? begin : text.find(kEnd, begin);
  if (end == std::string::npos) wrong("no data of a run");
  return json::parse(text.substr(begin + kBegin.size(), end - begin - kBegin.size()));
}

/// Calls `read` and returns its result; a problem in it is one of the file.
template <class Read>
auto from_file(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const FileError&) {
    throw;
  } catch (const std::exception& problem) {
    throw FileError(path, concat("is no record of a run: ", problem.what()), kRemedy);
  }
}

}  // namespace

RunRecord read_run_record(const std::string& folder) {
  namespace fs = std::filesystem;
  const std::string result_path = folder + "/result.json", page_path = folder + "/report.html";
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) throw FileError(folder, "is no folder", kRemedy);
  for (const auto& path : {result_path, page_path})
    if (!fs::exists(path, ignored))
      throw FileError(path,
                      fs::exists(folder + "/journal.jsonl", ignored)
                          ? "is missing: the run was killed, or its disk was full"
                          : "is missing",
                      kRemedy);
  RunRecord record;
  record.folder = folder;
  from_file(page_path, [&] {
    const json page = parsed_page(page_path);
    for (const json& entry : page.at("stones")) record.stones.push_back(stone_of(entry));
    add_samples(record, page);
    add_motion(record, page);
    for (const json& event : page.at("events"))
      record.events.push_back({page_time(event.at("t").get<double>()), event.at("text").get<std::string>()});
    return 0;
  });
  from_file(result_path, [&] {
    const json result = json::parse(read_file(result_path, kMaxRecordFile));
    record.robot = result.at("robot").get<std::string>();
    record.ended = result.at("ended").get<std::string>();
    record.seed = result.at("seed").get<int>();
    record.height = result.at("height").get<int>();
    add_placements(record, result);
    number_tower(record);
    return 0;
  });
  std::erase_if(record.carries, [&](const auto& c) {
    return record.stones[static_cast<std::size_t>(c.stone)].motion.empty();
  });
  return record;
}

std::vector<std::size_t> tower_of(const RunRecord& record) {
  std::vector<std::size_t> tower;
  for (std::size_t i = 0; i < record.stones.size(); ++i)
    if (record.stones[i].level > 0 && !record.stones[i].motion.empty()) tower.push_back(i);
  std::sort(tower.begin(), tower.end(),
            [&](std::size_t a, std::size_t b) { return record.stones[a].level < record.stones[b].level; });
  return tower;
}

}  // namespace stonestack::report
