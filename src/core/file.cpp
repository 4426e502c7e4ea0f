#include "stonestack/core/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/byte_stream.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

[[noreturn]] void cannot_write(const std::string& path, const std::string& problem) {
  throw FileError(path, "cannot be written: " + problem, "check the folder, its rights and the disk");
}

bool is_device(const std::string& path) {
  struct stat about {};
  return ::stat(path.c_str(), &about) == 0 && !S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode);
}

/// False, with errno, where the disk refuses.
bool put_all(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t put = ::write(fd, content.data(), content.size());
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return false;
    content.remove_prefix(static_cast<std::size_t>(put));
  }
  return true;
}

}  // namespace

std::string read_file(const std::string& path, std::size_t max_bytes) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) throw FileError(path, std::strerror(errno), "check the path");
  struct stat about {};
  if (::fstat(file.number(), &about) != 0) throw FileError(path, std::strerror(errno), "check the path");
  if (!S_ISREG(about.st_mode)) throw FileError(path, "is not a regular file", "give a file");
  const auto size = static_cast<std::size_t>(about.st_size);
  if (size > max_bytes)
    throw FileError(path, concat("has ", size, " bytes"), concat("at most ", max_bytes, " are read"));
  std::string content(size, '\0');
  for (std::size_t done = 0; done < size;) {
    const ssize_t got = ::read(file.number(), content.data() + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw FileError(path, "could not be read to its end", "check the disk");
    done += static_cast<std::size_t>(got);
  }
  return content;
}

void write_file(const std::string& path, std::string_view content) {
  const std::filesystem::path target(path);
  std::error_code failed;
  if (target.has_parent_path()) std::filesystem::create_directories(target.parent_path(), failed);
  if (failed) cannot_write(path, concat("its folder cannot be made: ", failed.message()));
  if (is_device(path)) {  // a device or a pipe takes bytes; a rename would put a file in its place
    const Descriptor device(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (device.number() < 0 || !put_all(device.number(), content)) cannot_write(path, std::strerror(errno));
    return;
  }
  const std::string part = concat(path, ".part-", ::getpid());
  const Descriptor file(::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (file.number() < 0) cannot_write(path, std::strerror(errno));
  // Before the rename: after a power cut the name must not stand for an empty file.
  if (!put_all(file.number(), content) || ::fsync(file.number()) != 0 ||
      ::rename(part.c_str(), path.c_str()) != 0) {
    const std::string problem = std::strerror(errno);
    ::unlink(part.c_str());
    cannot_write(path, problem);
  }
}

void require_writable(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (is_device(path)) return;
  if (fs::is_directory(path, ignored)) cannot_write(path, "it is a folder");
  fs::path folder = fs::absolute(path, ignored).lexically_normal().parent_path();
  while (folder.has_relative_path() && !fs::exists(folder, ignored)) folder = folder.parent_path();
  if (!fs::is_directory(folder, ignored)) cannot_write(path, concat(folder.string(), " is not a folder"));
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    cannot_write(path, concat("the folder ", folder.string(), " takes no files: ", std::strerror(errno)));
}

}  // namespace stonestack::core
