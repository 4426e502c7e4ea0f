#include "stonestack/core/file.hpp"

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "stonestack/core/error.hpp"

namespace stonestack::core {

std::string data_path(const std::string& name) {
  namespace fs = std::filesystem;
  std::vector<fs::path> folders;
  if (const char* given = std::getenv("STONESTACK_DATA")) folders.emplace_back(given);
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  if (!program.empty()) folders.push_back(program.parent_path().parent_path() / "share" / "stonestack");
  folders.emplace_back(STONESTACK_DATA_DIR);
  std::string tried;
  for (const auto& folder : folders) {
    if (fs::exists(folder / name, ignored)) return (folder / name).string();
    tried += (tried.empty() ? "" : ", ") + (folder / name).string();
  }
  throw FileError(name, "is not among stonestack's data (tried " + tried + ")",
                  "set STONESTACK_DATA to the data folder");
}

}  // namespace stonestack::core
