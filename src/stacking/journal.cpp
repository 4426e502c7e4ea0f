#include "stacking/journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "protocol/frame_stream.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::stacking {
namespace {

constexpr std::size_t kMaxJournal = std::size_t{1} << 28;
constexpr std::string_view kCrcBegin = ",\"crc\":\"";
constexpr std::size_t kCrcDigits = 8;

/// Of a line up to its checksum: CRC-32, eight hexadecimal digits.
std::string checksum(std::string_view content) {
  char text[16];
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(content.data());
  std::snprintf(text, sizeof text, "%08x", protocol::crc32(std::span(bytes, content.size())));
  return text;
}

/// "2025-01-01T14:30:00.123Z"
std::string now_text() {
  using namespace std::chrono;
  const auto now = system_clock::now().time_since_epoch();
  const std::time_t whole = duration_cast<seconds>(now).count();
  std::tm parts{};
  gmtime_r(&whole, &parts);
  char date[24], text[40];
  std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text, sizeof text, "%s.%03dZ", date,
                static_cast<int>(duration_cast<milliseconds>(now).count() % 1000));
  return text;
}

[[noreturn]] void fail(const std::string& path) {
  throw FileError(path, concat("cannot be written: ", std::strerror(errno)),
                  "check the disk; nothing was moved");
}

}  // namespace

Journal::Journal(const std::string& path) : path_(path) {
  const std::filesystem::path target(path);
  std::error_code ignored;
  if (target.has_parent_path()) std::filesystem::create_directories(target.parent_path(), ignored);
  std::size_t whole = 0;
  bool torn = false;
  if (std::filesystem::is_regular_file(target)) {
    const std::string content = read_file(path, kMaxJournal);
    whole = content.rfind('\n') == std::string::npos ? 0 : content.rfind('\n') + 1;
    torn = whole < content.size();
    next_ = std::count(content.begin(), content.begin() + static_cast<std::ptrdiff_t>(whole), '\n');
  }
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0640);
  if (descriptor_ < 0 || (torn && ::ftruncate(descriptor_, static_cast<off_t>(whole)) != 0)) fail(path);
}

Journal::~Journal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Journal::Journal(Journal&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      next_(other.next_),
      step_(std::move(other.step_)),
      arm_json_(std::move(other.arm_json_)) {}

Journal& Journal::operator=(Journal&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(next_, other.next_);
  std::swap(step_, other.step_);
  std::swap(arm_json_, other.arm_json_);
  return *this;
}

void Journal::record(const std::string& kind, const std::string& data_json, const std::string& arm_json) {
  if (descriptor_ < 0) return;
  nlohmann::ordered_json entry;
  entry["seq"] = next_++;
  entry["time"] = now_text();
  entry["kind"] = kind;
  entry["data"] = nlohmann::ordered_json::parse(data_json);
  if (!arm_json.empty()) entry["arm"] = nlohmann::ordered_json::parse(arm_json);
  std::string line = entry.dump();
  line.pop_back();  // the brace
  line += concat(kCrcBegin, checksum(line), "\"}\n");
  const ssize_t put = ::write(descriptor_, line.data(), line.size());
  if (put != static_cast<ssize_t>(line.size()) || ::fdatasync(descriptor_) != 0) fail(path_);
}

bool is_damaged(std::string_view line) {
  const std::size_t end = kCrcBegin.size() + kCrcDigits + 2;  // of the line, from the checksum on
  if (line.size() < end || line.substr(line.size() - end, kCrcBegin.size()) != kCrcBegin) return false;
  const std::string_view content = line.substr(0, line.size() - end);
  return line.substr(line.size() - kCrcDigits - 2, kCrcDigits) != checksum(content);
}

}  // namespace stonestack::stacking
