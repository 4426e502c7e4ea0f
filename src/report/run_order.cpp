#include "report/run_order.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "hardware/cell_config.hpp"
#include "stacking/resume_point.hpp"
#include "stacking/state_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kOrderSchema = "stonestack.order/1";
constexpr std::size_t kMaxOrder = std::size_t{1} << 24;
constexpr const char* kAnew = "start a new run; see with `stonestack inspect` what this one has done";

json changed_options(SimulatedRun run) {
  SimulatedRun usual;
  return stacking::changed_fields_json(fields(run), fields(usual));
}

std::string absolute_path(const std::string& path) {
  return path.empty() ? path : fs::absolute(path).lexically_normal().string();
}

/// A robot or cell by its path, or by the name of one that comes with stonestack.
std::string name_or_path(const std::string& name) {
  return fs::exists(name) ? absolute_path(name) : name;
}

RunOrder order_of(const json& j, const std::string& folder) {
  require(j.at("schema").get<std::string>() == kOrderSchema, "its schema is not ", kOrderSchema);
  RunOrder order;
  order.resume = folder;
  order.run.seed = j.at("seed").get<int>();
  const FieldList list = fields(order.run);
  for (const auto& [name, value] : j.at("options").items())
    set_field(list, concat(name, "=", value.is_string() ? value.get<std::string>() : value.dump()));
  order.per_run = j.at("per_run").get<int>();
  order.save_catalogue = j.at("save_catalogue").get<std::string>();
  const auto cell = j.at("cell").get<std::string>();
  if (cell.empty()) {
    order.robot = read_robot(j.at("robot").get<std::string>());
    return order;
  }
  order.cell = read_cell(cell);
  if (stacking::layout_json(to_layout(order.cell->cell())) != j.at("layout"))
    throw FileError(cell, "has another layout than when the run began",
                    "take back what was changed in it, or start a new run");
  return order;
}

void refuse_ended(const std::string& folder) {
  const std::string path = folder + "/result.json";
  if (!fs::exists(path) || !fs::exists(folder + "/report.html")) return;
  const auto ended = json::parse(read_file(path, kMaxOrder)).at("ended").get<std::string>();
  if (ended == to_text(RunEnd::kInterrupted) || ended == to_text(RunEnd::kStopped)) return;
  throw FileError(folder, concat("holds a run that ended (", ended, ")"), "start a new run");
}

}  // namespace

bool can_resume(const RunOrder& order) {
  return !order.dry && !order.only_model && !(order.cell && order.cell->simulate);
}

void write_order(const std::string& folder, const RunOrder& order, const Catalogue& catalogue) {
  json j{{"schema", kOrderSchema},
         {"version", order.version},
         {"seed", order.run.seed},
         {"options", changed_options(order.run)},
         {"catalogue", absolute_path(catalogue.path)},
         {"per_run", order.per_run},
         {"save_catalogue", absolute_path(order.save_catalogue)},
         {"robot", name_or_path(order.cell ? order.cell->robot() : order.robot.name)},
         {"cell", order.cell ? name_or_path(order.cell->path) : std::string()}};
  if (order.cell) j["layout"] = stacking::layout_json(to_layout(order.cell->cell()));
  write_file(folder + kOrderFile, j.dump(1) + "\n");
}

RecordFolder take_resumed_folder(const std::string& folder) {
  if (!fs::is_directory(folder)) throw FileError(folder, "is no folder", "give the folder of a run");
  try {
    return RecordFolder(folder);
  } catch (const FileError&) {
    throw FileError(folder, "is in use, or takes no files",
                    "wait until the run in it has ended, or end it; check the folder's rights");
  }
}

ResumableRun read_resumable_run(const std::string& folder) {
  const RecordFolder nobody_else = take_resumed_folder(folder);
  const std::string path = folder + kOrderFile;
  std::string problem;
  try {
    refuse_ended(folder);
    for (const std::string& needed : {path, folder + stacking::kResumeFile})
      if (!fs::exists(needed))
        throw FileError(needed, "is not there: no run that can go on was begun in this folder", kAnew);
    const json j = json::parse(read_file(path, kMaxOrder));
    ResumableRun run{order_of(j, folder), read_catalogue(j.at("catalogue").get<std::string>())};
    const bool models = run.order.run.build.unseen;
    if (!models) (void)stacking::read_resume_point(folder, run.catalogue);
    return run;
  } catch (const json::exception& wrong) {
    problem = wrong.what();
  } catch (const InvalidArgument& wrong) {
    problem = wrong.what();
  }
  throw FileError(path, "is not what a run wrote that can go on: " + problem, kAnew);
}

}  // namespace stonestack::report
