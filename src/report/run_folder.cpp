#include "report/run_folder.hpp"

#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::report {
namespace {

/// A journal in which something stands: its run looked, and perhaps moved something.
bool has_begun(const std::string& folder) {
  const std::string path = folder + "/journal.jsonl";
  if (!std::filesystem::is_regular_file(path)) return false;
  std::ifstream journal(path);
  std::string line;
  return std::getline(journal, line) && !line.empty();
}

}  // namespace

std::string stamped_name(const std::string& kind, int seed) {
  const std::time_t now = std::time(nullptr);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", std::localtime(&now));
  return concat(kind, '/', stamp, "-seed", seed);
}

RecordFolder take_run_folder(const std::string& out, int seed) {
  if (out.empty()) return RecordFolder::make_new(stamped_name("runs", seed));
  RecordFolder folder(out);
  require(!std::filesystem::exists(folder.path() + "/result.json"), folder.path(),
          " holds a run already; name another folder with --out, or remove it");
  if (has_begun(folder.path())) {
    const std::string aside = folder.put_aside();
    log_info(concat(out, " holds a run that did not end; it is kept as ", aside));
  }
  return folder;
}

}  // namespace stonestack::report
