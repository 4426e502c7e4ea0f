#include "stacking/journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::stacking {
namespace {

constexpr std::size_t kMaxJournal = std::size_t{1} << 28;

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
      step_(std::move(other.step_)) {}

Journal& Journal::operator=(Journal&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(next_, other.next_);
  std::swap(step_, other.step_);
  return *this;
}

void Journal::record(const std::string& kind, const std::string& data_json) {
  if (descriptor_ < 0) return;
  nlohmann::ordered_json entry;
  entry["seq"] = next_++;
  entry["kind"] = kind;
  entry["data"] = nlohmann::ordered_json::parse(data_json);
  const std::string line = entry.dump() + "\n";
  const ssize_t put = ::write(descriptor_, line.data(), line.size());
  if (put != static_cast<ssize_t>(line.size()) || ::fdatasync(descriptor_) != 0) fail(path_);
}

}  // namespace stonestack::stacking
