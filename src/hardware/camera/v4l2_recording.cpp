#include "hardware/camera/v4l2_recording.hpp"

#include <filesystem>
#include <sstream>

#include "protocol/z16.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::hardware {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = "stonestack v4l2 1";
constexpr std::size_t kV4l2MaxFrames = 1000000;

}  // namespace

V4l2Recorder::V4l2Recorder(const std::string& folder, CameraSettings camera, const V4l2Format& format)
    : folder_(folder) {
  const fs::path path(folder);
  if (fs::exists(path / "v4l2.txt"))
    throw FileError(folder, "holds a recording already", "give another folder, or remove it");
  write_file((path / "camera.yaml").string(), write_fields(fields(camera)));
  raw_.open(path / "v4l2.raw", std::ios::binary | std::ios::trunc);
  list_.open(path / "v4l2.txt", std::ios::trunc);
  list_ << kMark << "\nZ16 " << format.width << ' ' << format.height << ' ' << format.bytes_per_line << '\n'
        << std::flush;
  if (!raw_ || !list_) throw FileError(folder, "cannot be written", "give a folder that can");
}

void V4l2Recorder::add(const V4l2Note& note, std::span<const std::uint8_t> bytes) {
  raw_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  list_ << note.sequence << ' ' << note.seconds << ' ' << note.microseconds << ' ' << (note.error ? 1 : 0)
        << ' ' << bytes.size() << '\n';
  if (!raw_.flush() || !list_.flush())
    throw FileError(folder_, "cannot be written to", "free space on the disk");
}

std::vector<RecordedFrame> parse_v4l2_list(const std::string& text, const std::string& folder,
                                           const CameraIntrinsics& camera, std::size_t raw_bytes) {
  const std::string list = (fs::path(folder) / "v4l2.txt").string();
  const auto fail = [&](const std::string& problem) {
    throw FileError(list, problem, "record it again, or repair the line");
  };
  std::istringstream in(text);
  std::string line, word;
  if (!std::getline(in, line) || line != kMark) fail(concat("does not begin with `", kMark, "`"));
  V4l2Format format;
  std::getline(in, line);
  std::istringstream second(line);
  if (!(second >> word >> format.width >> format.height >> format.bytes_per_line) || word != "Z16")
    fail("line 2 is not `Z16 WIDTH HEIGHT BYTES_PER_LINE`");
  if (format.width != camera.width || format.height != camera.height)
    fail(concat("frames of ", format.width, " x ", format.height, ", and a camera of ", camera.width, " x ",
                camera.height));
  const std::size_t needed = z16_bytes(camera, format.bytes_per_line);
  if (needed == 0) fail(concat("lines of ", format.bytes_per_line, " bytes"));
  std::vector<RecordedFrame> frames;
  std::size_t offset = 0;
  for (std::size_t number = 3; std::getline(in, line); ++number) {
    V4l2Note note;
    std::istringstream fields(line);
    if (!(fields >> note.sequence >> note.seconds >> note.microseconds >> note.error >> note.bytes))
      fail(concat("line ", number, " is not `SEQUENCE SECONDS MICROSECONDS ERROR BYTES`"));
    if (note.bytes > raw_bytes - offset)
      fail(concat("line ", number, ": ", note.bytes, " bytes, and v4l2.raw has no more than ",
                  raw_bytes - offset));
    if (!note.error && note.bytes >= needed) {
      if (!frames.empty() && note.time() <= frames.back().time)
        fail(concat("line ", number, ": a time that does not rise"));
      if (frames.size() == kV4l2MaxFrames) fail("more than a million frames");
      frames.push_back(
          {note.time(), (fs::path(folder) / "v4l2.raw").string(), offset, format.bytes_per_line});
    }
    offset += note.bytes;
  }
  return frames;
}

}  // namespace stonestack::hardware
