#include <cstdlib>
#include <filesystem>
#include <vector>

#include "core/prefix.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::core {

std::string data_path(const std::string& name) {
  namespace fs = std::filesystem;
  std::vector<fs::path> folders;
  if (const char* given = std::getenv("STONESTACK_DATA")) folders.emplace_back(given);
  std::error_code ignored;
  for (const fs::path& prefix : install_prefixes()) {
    const fs::path folder = prefix / "share" / "stonestack";
    const fs::path linked = fs::canonical(folder, ignored);  // the build folder has a link to the sources
    folders.push_back(linked.empty() ? folder : linked);
  }
  std::string tried;
  for (const auto& folder : folders) {
    if (fs::exists(folder / name, ignored)) return (folder / name).string();
    tried += (tried.empty() ? "" : ", ") + (folder / name).string();
  }
  throw FileError(name, "is not among stonestack's data (tried " + tried + ")",
                  "set STONESTACK_DATA to the data folder");
}

}  // namespace stonestack::core
