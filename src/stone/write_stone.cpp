#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "stone/stone_yaml.hpp"
#include "stone/surface_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::stone {
namespace {

namespace fs = std::filesystem;

/// A folder that is gone when its owner leaves without having renamed it.
struct TemporaryFolder {
  fs::path path;
  explicit TemporaryFolder(fs::path where) : path(std::move(where)) {
    std::error_code problem;
    fs::remove_all(path, problem);
    fs::create_directories(path, problem);
    if (problem)
      throw FileError(path.string(), concat("cannot be made: ", problem.message()),
                      "check folder and rights");
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

/// Puts `from` in the place of `to` in one step, whether `to` exists (then `from` becomes the old one) or
/// not.
void put_in_place(const fs::path& from, const fs::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
  if (errno == EEXIST && ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0)
    return;
  if (errno == EINVAL) {  // a file system that knows neither: two steps
    std::error_code ignored;
    fs::remove_all(to, ignored);
    if (::rename(from.c_str(), to.c_str()) == 0) return;
  }
  throw FileError(to.string(), concat("cannot be written: ", std::strerror(errno)),
                  "check folder and rights");
}

}  // namespace

void write_stone(const std::string& catalogue_path, const Stone& stone) {
  require(is_stone_name(stone.name),
          "a stone's name is 1 to 64 letters, digits, '_', '-' or '.', and does not"
          " start with '.', got '",
          stone.name, "'");
  const fs::path catalogue(catalogue_path);
  const TemporaryFolder part(catalogue / concat(".", stone.name, ".part-", ::getpid()));
  write_mesh((part.path / "mesh.ply").string(), stone.mesh);
  write_mesh((part.path / "scan.ply").string(), stone.scan);
  for (std::size_t n = 0; n < stone.pieces.size(); ++n)
    write_mesh((part.path / "pieces" / concat(n + 1, ".ply")).string(), stone.pieces[n]);
  if (stone.surface) write_file((part.path / kSurfaceFile).string(), surface_json(*stone.surface));
  write_file((part.path / "stone.yaml").string(), stone_to_yaml(stone, find_symmetries(stone.mesh)));
  put_in_place(part.path, catalogue / stone.name);
}

bool is_stone_name(const std::string& name) {
  if (name.empty() || name.size() > 64 || name.front() == '.') return false;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9') && c != '_' && c != '-' && c != '.') return false;
  }
  return true;
}

}  // namespace stonestack::stone
