#include "stonestack/stone/catalogue.hpp"

#include <algorithm>
#include <filesystem>

#include "stone/stone_check.hpp"
#include "stone/stone_yaml.hpp"
#include "stone/surface_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::stone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMakeOne = "make stones with `stonestack scan FILE --catalogue DIR`";

/// Edits (insertions, deletions, changes) between two names (Levenshtein 1966).
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
    }
  }
  return row[b.size()];
}

Stone read_stone(const fs::path& folder) {
  const StoneFile file = read_stone_yaml((folder / "stone.yaml").string());
  Stone stone = file.stone;
  if (stone.name != folder.filename().string())
    throw FileError((folder / "stone.yaml").string(),
                    concat("name is '", stone.name, "' in the folder '", folder.filename().string(), "'"),
                    "give both the same name");
  stone.mesh = read_mesh((folder / "mesh.ply").string());
  stone.scan = read_mesh((folder / "scan.ply").string());
  for (int n = 1; n <= file.pieces; ++n)
    stone.pieces.push_back(read_mesh((folder / "pieces" / concat(n, ".ply")).string()));
  std::error_code ignored;
  if (fs::symlink_status(folder / kSurfaceFile, ignored).type() != fs::file_type::not_found)
    stone.surface = read_surface((folder / kSurfaceFile).string(), stone.scan.vertices.size());
  check_stone(stone, folder.string());
  return stone;
}

/// Folders of stones, by name. What starts with a dot is not a stone: so a half-written one is named.
std::vector<fs::path> stone_folders(const std::string& path) {
  std::error_code problem;
  std::vector<fs::path> folders;
  for (fs::directory_iterator entry(path, problem), end; !problem && entry != end; entry.increment(problem)) {
    std::error_code ignored;
    if (entry->is_directory(ignored) && entry->path().filename().string().front() != '.')
      folders.push_back(entry->path());
  }
  if (problem)
    throw FileError(path, concat("cannot be read: ", problem.message()), "check the folder's rights");
  std::sort(folders.begin(), folders.end());
  return folders;
}

}  // namespace

void throw_no_such_stone(StoneIndex stone, std::size_t count) {
  throw InvalidArgument(concat("no stone ", stone, "; there are ", count));
}

std::vector<StoneIndex> first_stones(std::size_t count) {
  std::vector<StoneIndex> stones;
  stones.reserve(count);
  for (std::size_t i = 0; i < count; ++i) stones.emplace_back(i);
  return stones;
}

StoneIndex Catalogue::index(const std::string& name) const {
  const Stone* nearest = nullptr;
  for (std::size_t i = 0; i < stones.size(); ++i) {
    if (stones[i].name == name) return StoneIndex(i);
    if (nearest == nullptr || edits(name, stones[i].name) < edits(name, nearest->name)) nearest = &stones[i];
  }
  throw InvalidArgument(
      concat("no stone '", name, "' in ", path,
             nearest == nullptr ? "" : concat("; the nearest name is '", nearest->name, "'")));
}

Catalogue read_catalogue(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw FileError(path, "no such folder", kMakeOne);
  if (!fs::is_directory(path, ignored))
    throw FileError(path, "is not a folder", "a catalogue is a folder with one folder a stone");
  Catalogue catalogue;
  catalogue.path = path;
  for (const fs::path& folder : stone_folders(path)) {
    throw_if_interrupted();
    catalogue.stones.push_back(read_stone(folder));
  }
  if (catalogue.stones.empty()) throw FileError(path, "holds no stones", kMakeOne);
  return catalogue;
}

}  // namespace stonestack::stone
