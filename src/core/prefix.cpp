#include "core/prefix.hpp"

#include <dlfcn.h>

#include <algorithm>

namespace stonestack::core {
namespace {

namespace fs = std::filesystem;

/// File of the library that this function was linked into; empty where that is a program that does not know
/// its own path.
fs::path library_file() {
  Dl_info found{};
  if (::dladdr(reinterpret_cast<const void*>(&install_prefixes), &found) == 0 || found.dli_fname == nullptr)
    return {};
  const fs::path file = found.dli_fname;
  std::error_code ignored;
  return file.is_absolute() ? fs::canonical(file, ignored) : fs::path{};
}

}  // namespace

std::vector<fs::path> install_prefixes() {
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored), library = library_file();
  std::vector<fs::path> prefixes;
  const auto add = [&](const fs::path& folder) {
    if (!folder.empty() && std::find(prefixes.begin(), prefixes.end(), folder) == prefixes.end())
      prefixes.push_back(folder);
  };
  add(program.parent_path().parent_path());
  add(library.parent_path().parent_path());
  add(library.parent_path().parent_path().parent_path());
  return prefixes;
}

}  // namespace stonestack::core
