#include "stonestack/core/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

/// A file descriptor that closes itself.
struct Descriptor {
  int fd;
  explicit Descriptor(int opened) : fd(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

std::string read_file(const std::string& path, std::size_t largest) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.fd < 0) throw FileError(path, std::strerror(errno), "check the path");
  struct stat about {};
  if (::fstat(file.fd, &about) != 0) throw FileError(path, std::strerror(errno), "check the path");
  if (!S_ISREG(about.st_mode)) throw FileError(path, "is not a regular file", "give a file");
  const auto size = static_cast<std::size_t>(about.st_size);
  if (size > largest)
    throw FileError(path, concat("has ", size, " bytes"), concat("at most ", largest, " are read"));
  std::string content(size, '\0');
  for (std::size_t done = 0; done < size;) {
    const ssize_t got = ::read(file.fd, content.data() + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw FileError(path, "could not be read to its end", "check the disk");
    done += static_cast<std::size_t>(got);
  }
  return content;
}

void write_file(const std::string& path, std::string_view content) {
  const std::filesystem::path target(path);
  std::error_code ignored;
  if (target.has_parent_path()) std::filesystem::create_directories(target.parent_path(), ignored);
  const std::string part = concat(path, ".part-", ::getpid());
  {
    const Descriptor file(::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (file.fd < 0)
      throw FileError(path, concat("cannot be written: ", std::strerror(errno)), "check folder and rights");
    for (std::size_t done = 0; done < content.size();) {
      const ssize_t put = ::write(file.fd, content.data() + done, content.size() - done);
      if (put < 0 && errno == EINTR) continue;
      if (put <= 0) {
        const std::string problem = std::strerror(errno);
        ::unlink(part.c_str());
        throw FileError(path, concat("cannot be written: ", problem), "check the disk");
      }
      done += static_cast<std::size_t>(put);
    }
  }
  if (::rename(part.c_str(), path.c_str()) != 0) {
    const std::string problem = std::strerror(errno);
    ::unlink(part.c_str());
    throw FileError(path, concat("cannot be written: ", problem), "check folder and rights");
  }
}

}  // namespace stonestack::core
