#include "geometry/mesh_import.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <thread>

#include "core/prefix.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::array<std::string_view, 6> kFormats = {"glb", "gltf", "dae", "3ds", "off", "fbx"};
constexpr const char* kRemedy = "convert it to PLY, OBJ or STL";
constexpr std::size_t kImportMaxResult = 256U << 20U;
constexpr std::size_t kLongestReason = 300;
constexpr auto kPause = std::chrono::milliseconds(2);

/// A file in memory, handed to the process as one of its standard files.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& path) : fd_(::memfd_create("stonestack", MFD_CLOEXEC)) {
    if (fd_ < 0) throw FileError(path, "could not be handed to the importer", kRemedy);
  }
  ~MemoryFile() { ::close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] bool put(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t put = ::write(fd_, bytes.data(), bytes.size());
      if (put <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(put));
    }
    return ::lseek(fd_, 0, SEEK_SET) == 0;
  }
  [[nodiscard]] std::string get(std::size_t max) const {
    struct stat now {};
    if (::fstat(fd_, &now) != 0 || now.st_size <= 0) return {};
    std::string bytes(std::min(max, static_cast<std::size_t>(now.st_size)), '\0');
    std::size_t have = 0;
    while (have < bytes.size()) {
      const ssize_t got = ::pread(fd_, &bytes[have], bytes.size() - have, static_cast<off_t>(have));
      if (got <= 0) break;
      have += static_cast<std::size_t>(got);
    }
    bytes.resize(have);
    return bytes;
  }

 private:
  int fd_;
};

std::string importer_program() {
  for (const std::filesystem::path& prefix : core::install_prefixes()) {
    const std::string program = prefix / "bin" / "stonestack-import";
    if (::access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

/// Ends the process in any state, and reports how it ended.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  ~Child() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    (void)::waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Status of the process as waitpid gives it; empty when it has not ended after `seconds`.
  [[nodiscard]] std::optional<int> wait(double seconds) {
    int status = 0;
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (::waitpid(pid_, &status, WNOHANG) != pid_) {
      throw_if_interrupted();
      if (std::chrono::steady_clock::now() > until) return std::nullopt;
      std::this_thread::sleep_for(kPause);
    }
    pid_ = 0;
    return status;
  }

 private:
  pid_t pid_;
};

pid_t start(const std::string& program, const std::string& extension, const std::array<int, 3>& files) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (int k = 0; k < 3; ++k)
    posix_spawn_file_actions_adddup2(&actions, files[static_cast<std::size_t>(k)], k);
  std::string name = "stonestack-import", argument = extension;
  std::array<char*, 3> arguments = {name.data(), argument.data(), nullptr};
  std::array<char*, 1> environment = {nullptr};
  pid_t pid = 0;
  const int problem =
      ::posix_spawn(&pid, program.c_str(), &actions, nullptr, arguments.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  return problem == 0 ? pid : -1;
}

std::string first_line(const std::string& text) {
  std::string line = text.substr(0, text.find('\n'));
  for (char& c : line)
    if (std::isprint(static_cast<unsigned char>(c)) == 0) c = '?';
  return line;
}

std::string why_it_ended(int signal) {
  if (signal == SIGXCPU || signal == SIGKILL) return "takes more than 10 s or 1 GiB to be read";
  if (signal == SIGXFSZ) return "becomes a mesh of more than 256 MiB";
  return concat("makes assimp crash (signal ", signal, ")");
}

}  // namespace

bool is_imported(std::string_view extension) {
  return std::find(kFormats.begin(), kFormats.end(), extension) != kFormats.end();
}

std::string import_as_ply(const std::string& path, const std::string& extension, std::string_view content,
                          const MeshImport& how) {
  const std::string program = how.program.empty() ? importer_program() : how.program;
  if (program.empty())
    throw FileError(
        path, concat("is a .", extension, " file, and stonestack-import, which reads these, is missing"),
        concat("install it beside stonestack, or ", kRemedy));
  const MemoryFile in(path), out(path), words(path);
  if (!in.put(content)) throw FileError(path, "could not be handed to the importer", kRemedy);
  const pid_t pid = start(program, extension, {in.fd(), out.fd(), words.fd()});
  if (pid < 0) throw FileError(path, "cannot be read: " + program + " does not start", kRemedy);
  Child child(pid);
  const std::optional<int> status = child.wait(how.seconds);
  if (!status) throw FileError(path, concat("is not read after ", how.seconds, " s"), kRemedy);
  if (WIFSIGNALED(*status)) throw FileError(path, why_it_ended(WTERMSIG(*status)), kRemedy);
  if (WEXITSTATUS(*status) != 0) {
    const std::string why = first_line(words.get(kLongestReason));
    throw FileError(path, why.empty() ? concat("cannot be read (", program, " failed)") : why, kRemedy);
  }
  if (const std::string warning = first_line(words.get(kLongestReason)); !warning.empty())
    log_warning(concat(path, ": assimp reports: ", warning));
  return out.get(kImportMaxResult);
}

}  // namespace stonestack::geometry
