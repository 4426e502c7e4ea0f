#include "hardware/camera/recording.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "geometry/bop_folder.hpp"
#include "hardware/camera/v4l2_recording.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::hardware {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxText = 16U << 20U;
constexpr std::size_t kMaxFrames = 1000000;

std::vector<std::string> files_in(const fs::path& folder, const std::vector<std::string>& extensions) {
  std::vector<std::string> names;
  std::error_code problem;
  for (fs::directory_iterator it(folder, problem), end; !problem && it != end; it.increment(problem)) {
    const std::string extension = it->path().extension().string();
    if (std::find(extensions.begin(), extensions.end(), extension) == extensions.end()) continue;
    names.push_back(it->path().string());
    if (names.size() > kMaxFrames) throw FileError(folder.string(), "more than a million frames", "split it");
  }
  if (problem) throw FileError(folder.string(), problem.message(), "give a folder that can be read");
  std::sort(names.begin(), names.end());
  return names;
}

bool is_cloud(const fs::path& path) {
  return path.extension() == ".pcd" || path.extension() == ".ply";
}

void read_open3d_intrinsics(const std::string& path, CameraSettings& camera) {
  try {
    const auto json = nlohmann::json::parse(read_file(path, kMaxText));
    const auto m = json.at("intrinsic_matrix").get<std::vector<double>>();  // by columns
    if (m.size() != 9)
      throw FileError(path, concat("intrinsic_matrix of ", m.size(), " numbers"), "it has 9");
    camera.width = json.at("width").get<int>();
    camera.height = json.at("height").get<int>();
    camera.fx = m[0];
    camera.fy = m[4];
    camera.cx = m[6];
    camera.cy = m[7];
  } catch (const nlohmann::json::exception& error) {
    throw FileError(path, error.what(), "write it with Open3D's recorder");
  }
}

/// Settings of the first image.
void read_bop_settings(const std::string& folder, CameraSettings& settings) {
  const DepthRecord first = read_depth_sequence(folder).records.front();
  settings.depth_scale = 1.0 / first.unit;
  set_intrinsics(settings, first.camera);
}

/// Images with their times where these rise, else at `rate`.
std::vector<RecordedFrame> list_bop(const std::string& folder, double rate) {
  const std::vector<DepthRecord> records = read_depth_sequence(folder).records;
  const bool timed = std::adjacent_find(records.begin(), records.end(), [](const auto& a, const auto& b) {
                       return a.time >= b.time;
                     }) == records.end();
  std::vector<RecordedFrame> frames;
  for (const DepthRecord& record : records)
    frames.push_back(
        {timed ? record.time : static_cast<double>(frames.size()) / rate, record.path, 0, 0, record});
  return frames;
}

std::vector<RecordedFrame> number_frames(const std::vector<std::string>& names, double rate) {
  std::vector<RecordedFrame> frames;
  for (const auto& name : names) frames.push_back({static_cast<double>(frames.size()) / rate, name});
  return frames;
}

std::vector<RecordedFrame> list_raw(const std::string& path, const CameraIntrinsics& camera, double rate) {
  const std::size_t bytes =
      2U * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  std::error_code problem;
  const auto size = fs::file_size(path, problem);
  if (problem) throw FileError(path, problem.message(), "give a file of raw frames");
  if (size == 0 || size % bytes != 0)
    throw FileError(path,
                    concat(size, " bytes are no whole number of ", camera.width, " x ", camera.height,
                           " frames (", bytes, " bytes each)"),
                    "check width and height");
  std::vector<RecordedFrame> frames;
  for (std::size_t i = 0; i < size / bytes; ++i)
    frames.push_back({static_cast<double>(i) / rate, path, i * bytes, 0});
  return frames;
}

}  // namespace

RecordingFormat find_recording_format(const RecordedCameraOptions& options) {
  const fs::path path(options.path);
  std::error_code ignored;
  if (options.format == "bop") return RecordingFormat::kBop;
  if (options.format == "tum") return RecordingFormat::kTum;
  if (options.format == "open3d") return RecordingFormat::kOpen3d;
  if (options.format == "clouds") return RecordingFormat::kClouds;
  if (options.format == "z16") return RecordingFormat::kZ16;
  if (options.format == "v4l2") return RecordingFormat::kV4l2;
  require(options.format == "auto",
          "a recording's format is auto, bop, tum, open3d, clouds, z16 or v4l2, not '", options.format, "'");
  if (fs::is_regular_file(path, ignored))
    return is_cloud(path) ? RecordingFormat::kClouds : RecordingFormat::kZ16;
  if (fs::exists(path / "v4l2.txt", ignored)) return RecordingFormat::kV4l2;
  if (fs::exists(path / "scene_camera.json", ignored)) return RecordingFormat::kBop;
  if (fs::exists(path / "depth.txt", ignored)) return RecordingFormat::kTum;
  if (fs::exists(path / "camera_intrinsic.json", ignored)) return RecordingFormat::kOpen3d;
  if (fs::is_directory(path, ignored) && !files_in(path, {".pcd", ".ply"}).empty())
    return RecordingFormat::kClouds;
  throw FileError(
      options.path,
      "no recording (scene_camera.json, depth.txt, camera_intrinsic.json, v4l2.txt, PCD or PLY files)",
      "give a BOP, TUM or Open3D folder, clouds, or a file of raw Z16 frames");
}

CameraSettings read_camera_settings(RecordingFormat format, const RecordedCameraOptions& options) {
  CameraSettings camera = options.camera;
  std::error_code ignored;
  const fs::path path(options.path);
  const fs::path folder = fs::is_directory(path, ignored) ? path : path.parent_path();
  if (fs::exists(folder / "camera.yaml", ignored))
    read_fields(fields(camera), (folder / "camera.yaml").string());
  if (format == RecordingFormat::kBop) read_bop_settings(options.path, camera);
  if (format == RecordingFormat::kOpen3d)
    read_open3d_intrinsics((path / "camera_intrinsic.json").string(), camera);
  return camera;
}

std::vector<RecordedFrame> parse_tum_list(const std::string& text, const std::string& folder,
                                          const std::string& path) {
  std::vector<RecordedFrame> frames;
  std::size_t number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line(text.data() + at, end - at);
    at = end + 1;
    ++number;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    if (line.empty() || line.front() == '#') continue;
    const auto fail = [&](const std::string& problem) {
      throw FileError(path, concat("line ", number, ": ", problem), "a line reads `time depth/name.png`");
    };
    const auto space = line.find(' ');
    if (space == std::string_view::npos) fail("no space between time and file");
    double time = 0.0;
    const auto [stop, error] = std::from_chars(line.data(), line.data() + space, time);
    if (error != std::errc() || stop != line.data() + space || !std::isfinite(time)) fail("not a time");
    if (!frames.empty() && time <= frames.back().time) fail("a time that does not rise");
    const fs::path name(std::string(line.substr(line.find_first_not_of(' ', space))));
    const bool outside = name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end();
    if (outside) fail("a file outside the folder: " + name.string());
    if (frames.size() == kMaxFrames) fail("more than a million frames");
    frames.push_back({time, (fs::path(folder) / name).string()});
  }
  return frames;
}

std::vector<RecordedFrame> list_frames(RecordingFormat format, const RecordedCameraOptions& options,
                                       const CameraIntrinsics& camera) {
  const fs::path path(options.path);
  std::error_code ignored;
  std::vector<RecordedFrame> frames;
  if (format == RecordingFormat::kBop) {
    frames = list_bop(options.path, options.rate);
  } else if (format == RecordingFormat::kTum) {
    const std::string list = (path / "depth.txt").string();
    frames = parse_tum_list(read_file(list, kMaxText), options.path, list);
  } else if (format == RecordingFormat::kOpen3d) {
    frames = number_frames(files_in(path / "depth", {".png"}), options.rate);
  } else if (format == RecordingFormat::kV4l2) {
    const auto bytes = fs::file_size(path / "v4l2.raw", ignored);
    if (ignored) throw FileError((path / "v4l2.raw").string(), ignored.message(), "record it again");
    frames = parse_v4l2_list(read_file((path / "v4l2.txt").string(), kMaxText), options.path, camera, bytes);
  } else if (format == RecordingFormat::kZ16) {
    frames = list_raw(options.path, camera, options.rate);
  } else if (fs::is_directory(path, ignored)) {
    frames = number_frames(files_in(path, {".pcd", ".ply"}), options.rate);
  } else {
    frames = number_frames({options.path}, options.rate);
  }
  if (frames.empty()) throw FileError(options.path, "no depth frames", "record some");
  return frames;
}

}  // namespace stonestack::hardware
