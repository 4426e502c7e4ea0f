#include "report/known_cells.hpp"

#include <cstdlib>
#include <filesystem>
#include <span>

#include "protocol/frame_stream.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr const char* kSchema = "stonestack.cells/1";
constexpr std::size_t kMaxBytes = 1 << 20;

/// "0badf00d-4711": checksum and length.
std::string checksum(const std::string& path) {
  const std::string content = read_file(path, kMaxBytes);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(content.data());
  return format("%08x-%zu", crc32(std::span(bytes, content.size())), content.size());
}

std::string real_path(const std::string& path) {
  return std::filesystem::weakly_canonical(path).string();
}

/// Checksums by path. What is damaged counts as empty.
json read_cells() {
  const std::string path = known_cells_path();
  if (!std::filesystem::exists(path)) return json::object();
  try {
    const json file = json::parse(read_file(path, kMaxBytes));
    if (file.at("schema") == kSchema && file.at("cells").is_object()) return file.at("cells");
    throw FileError(path, "is of another schema", "remove it");
  } catch (const json::exception&) {
    log_warning(path + " is damaged: no cell counts as one that has run; remove it");
  } catch (const FileError& problem) {
    log_warning(concat(problem.what(), "; no cell counts as one that has run"));
  }
  return json::object();
}

}  // namespace

std::string known_cells_path() {
  const char* state = std::getenv("XDG_STATE_HOME");
  const char* home = std::getenv("HOME");
  const std::string folder = state != nullptr && *state == '/' ? std::string(state)
                             : home != nullptr                 ? std::string(home) + "/.local/state"
                                                               : std::string(".");
  return folder + "/stonestack/cells.json";
}

bool is_known_cell(const std::string& cell_path) {
  const json cells = read_cells();
  const auto known = cells.find(real_path(cell_path));
  return known != cells.end() && *known == checksum(cell_path);
}

void note_known_cell(const std::string& cell_path) {
  try {
    json cells = read_cells();
    cells[real_path(cell_path)] = checksum(cell_path);
    write_file(known_cells_path(), document({{"schema", kSchema}, {"cells", cells}}));
  } catch (const FileError& problem) {
    log_warning(concat("that ", cell_path, " has completed a run is not remembered: ", problem.what()));
  }
}

}  // namespace stonestack::report
