#include "kinematics/mesh_uri.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <vector>

#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

namespace fs = std::filesystem;
constexpr const char* kPackage = "package://";

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

std::vector<fs::path> listed(const char* variable) {
  std::vector<fs::path> folders;
  const char* value = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe): nothing here sets it
  std::istringstream list(value != nullptr ? value : "");
  for (std::string folder; std::getline(list, folder, ':');)
    if (!folder.empty()) folders.emplace_back(folder);
  return folders;
}

/// Where a folder of this name may be, the likeliest first.
std::vector<fs::path> folders_of(const std::string& package, const fs::path& urdf) {
  std::vector<fs::path> folders;
  const fs::path around = fs::absolute(urdf).parent_path();
  for (fs::path up = around; up.has_relative_path(); up = up.parent_path()) {
    if (up.filename() == package) folders.push_back(up);
    folders.push_back(up / package);
  }
  for (const fs::path& path : listed("ROS_PACKAGE_PATH")) {
    if (path.filename() == package) folders.push_back(path);
    folders.push_back(path / package);
  }
  for (const fs::path& prefix : listed("AMENT_PREFIX_PATH")) folders.push_back(prefix / "share" / package);
  return folders;
}

}  // namespace

std::string find_mesh(const std::string& uri, const std::string& link, const std::string& urdf) {
  const auto refuse = [&](const std::string& problem, const std::string& remedy) {
    throw FileError(urdf, concat("link '", link, "' has the collision mesh '", uri, "', ", problem), remedy);
  };
  const bool in_package = uri.starts_with(kPackage);
  const fs::path path = in_package ? uri.substr(std::string(kPackage).size()) : uri;
  if (path.empty() || path.is_absolute() || uri.find('\0') != std::string::npos ||
      (!in_package && uri.find("://") != std::string::npos) ||
      std::find(path.begin(), path.end(), "..") != path.end())
    refuse(
        "which is not opened",
        "write package://NAME/PATH or a path from the URDF's own folder, without '..': copy the mesh there");
  if (!in_package) {
    const fs::path file = fs::path(urdf).parent_path() / path;
    if (!is_file(file)) refuse(concat("and there is no file '", file.string(), "'"), "put it there");
    return file.string();
  }
  const std::string package = path.begin()->string();
  const fs::path below = path.lexically_relative(package);
  for (const fs::path& folder : folders_of(package, urdf))
    if (is_file(folder / below)) return (folder / below).string();
  refuse(
      concat("which lies in no folder '", package, "'"),
      concat("put that folder beside the URDF, or name the one it lies in by ROS_PACKAGE_PATH; for a UR "
             "without changes, --robot ur10 and its like need no URDF, and a calibrated one is a YAML with "
             "`robot: ur10` and its DH table"));
  return {};
}

}  // namespace stonestack::kinematics
