#include "report/record_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "stonestack/core/error.hpp"

namespace stonestack::report {
namespace {

namespace fs = std::filesystem;

constexpr int kAttempts = 100;  // others may make and remove the same folders at the same time

[[noreturn]] void refuse(const std::string& path, const std::string& problem) {
  throw FileError(path, problem, "name another folder with --out");
}

std::string without_slash(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

/// Makes the folders above `path` and appends those that were not there.
void make_above(const std::string& path, std::vector<std::string>& made) {
  const fs::path parent = fs::path(path).parent_path();
  if (parent.empty() || ::access(parent.c_str(), F_OK) == 0) return;
  make_above(parent.string(), made);
  if (::mkdir(parent.c_str(), 0777) == 0)
    made.push_back(parent.string());
  else if (errno != EEXIST && errno != ENOENT)
    refuse(path, concat("the folder ", parent.string(), " cannot be made: ", std::strerror(errno)));
}

/// The folder that is open is still the one of that name.
bool is_still(int descriptor, const std::string& path) {
  struct stat open {
  }, named{};
  return ::fstat(descriptor, &open) == 0 && ::stat(path.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

}  // namespace

bool RecordFolder::take(bool only_new) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    make_above(path_, made_above_);
    made_ = ::mkdir(path_.c_str(), 0777) == 0;
    if (!made_ && errno == ENOENT) continue;  // who made the folder above it has removed it
    if (!made_ && errno != EEXIST) refuse(path_, concat("cannot be made: ", std::strerror(errno)));
    if (!made_ && only_new) return false;
    lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ < 0 && errno == ENOENT) continue;
    if (lock_ < 0) refuse(path_, concat("cannot be used: ", std::strerror(errno)));
    const int refused = ::flock(lock_, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    if (refused == EWOULDBLOCK) {  // even if it was made here: somebody else was quicker to lock it
      made_ = false;
      made_above_.clear();
      refuse(path_, "another program is writing its record there");
    }
    if (refused != 0 && !made_)  // some file systems lock no folder: there mkdir alone decides
      refuse(path_, concat("is there already and cannot be locked: ", std::strerror(refused)));
    if (is_still(lock_, path_)) {
      if (::access(path_.c_str(), W_OK | X_OK) != 0)
        refuse(path_, concat("takes no files: ", std::strerror(errno)));
      return true;
    }
    ::close(std::exchange(lock_, -1));
  }
  refuse(path_, "cannot be made: its file system takes no folders, or another program removes it each time");
}

RecordFolder::RecordFolder(const std::string& path) : RecordFolder() {
  path_ = without_slash(path);
  take(false);
}

RecordFolder RecordFolder::make_new(const std::string& path) {
  RecordFolder folder;
  folder.path_ = without_slash(path);
  const std::string first = folder.path_;
  for (int n = 2; !folder.take(true); ++n) folder.path_ = concat(first, '-', n);
  return folder;
}

RecordFolder::~RecordFolder() {
  if (made_) ::rmdir(path_.c_str());  // fails where something stands in it
  for (auto above = made_above_.rbegin(); above != made_above_.rend(); ++above) ::rmdir(above->c_str());
  if (lock_ >= 0) ::close(lock_);
}

RecordFolder::RecordFolder(RecordFolder&& other) noexcept
    : path_(std::move(other.path_)),
      made_above_(std::exchange(other.made_above_, {})),
      lock_(std::exchange(other.lock_, -1)),
      made_(std::exchange(other.made_, false)) {}

RecordFolder& RecordFolder::operator=(RecordFolder&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(made_above_, other.made_above_);
  std::swap(lock_, other.lock_);
  std::swap(made_, other.made_);
  return *this;
}

std::string RecordFolder::put_aside() {
  std::string aside = report::put_aside(path_);
  const int before = std::exchange(lock_, -1);
  try {
    take(false);
  } catch (...) {
    ::close(before);
    throw;
  }
  ::close(before);
  return aside;
}

std::string put_aside(const std::string& path) {
  const std::string aside = without_slash(path) + "-interrupted";
  for (int n = 1;; ++n) {
    const std::string name = n == 1 ? aside : concat(aside, '-', n);
    if (::renameat2(AT_FDCWD, path.c_str(), AT_FDCWD, name.c_str(), RENAME_NOREPLACE) == 0) return name;
    if (errno == EINVAL && !fs::exists(name) && ::rename(path.c_str(), name.c_str()) == 0)
      return name;  // a file system without RENAME_NOREPLACE
    if (errno != EEXIST) refuse(path, concat("cannot be put aside as ", name, ": ", std::strerror(errno)));
  }
}

}  // namespace stonestack::report
