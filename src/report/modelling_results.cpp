#include "report/modelling_results.hpp"

#include <filesystem>
#include <utility>

#include "core/quantile.hpp"
#include "report/text.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

double median(std::vector<double> values) {
  return values.empty() ? 0.0 : quantile(std::move(values), 0.5);
}

}  // namespace

json modelling_entry(const ModellingReport& made) {
  json stones = json::array();
  for (const StoneModelReport& stone : made.stones)
    stones.push_back({{"name", stone.name},
                      {"turned", stone.turned},
                      {"views", stone.views},
                      {"seen_share", stone.seen_share},
                      {"sigma_m", stone.sigma},
                      {"mass", stone.mass},
                      {"weighed", stone.weighed},
                      {"note", stone.note}});
  return {{"catalogue", made.folder},          {"views", made.views},
          {"robot_seconds", made.seconds},     {"apart_before_m", made.apart_before},
          {"apart_after_m", made.apart_after}, {"stones", stones},
          {"left_out", made.left_out}};
}

std::string modelling_text(const ModellingReport& made) {
  std::string text =
      format("\nmodelled by the camera: %d views, %.0f s of the robot; views agree within %.2f mm\n",
             made.views, made.seconds, 1e3 * made.apart_after);
  text += "stone            mass (kg)  seen (%)  sigma (mm)  views  turned\n";
  for (const StoneModelReport& stone : made.stones)
    text += format("%-15s %10.2f %9.0f %11.2f %6d  %-6s %s\n", stone.name.c_str(), stone.mass,
                   100 * stone.seen_share, 1e3 * stone.sigma, stone.views, stone.turned ? "yes" : "no",
                   stone.note.c_str());
  for (const std::string& left : made.left_out) text += "left out: " + left + "\n";
  return text;
}

std::string modelled_json(const ModelledViews& modelled, const std::string& catalogue) {
  json stones = json::array(), failed = json::array();
  for (std::size_t k = 0; k < modelled.stones.size(); ++k) {
    const StoneSummary& summary = modelled.stones[k];
    const ObjectModel& model = modelled.models[k];
    stones.push_back({{"name", summary.stone.name},
                      {"folder", (std::filesystem::path(catalogue) / summary.stone.name).string()},
                      {"T_W_O", pose_json(summary.stone.T_O_file.inverse())},
                      {"mass", summary.stone.mass.mass},
                      {"volume", summary.volume},
                      {"views", model.views},
                      {"seen_share", model.seen_share},
                      {"sigma_m", median(model.sigma)},
                      {"warnings", summary.warnings}});
  }
  for (const FailedScan& object : modelled.failed)
    failed.push_back({{"name", object.file}, {"error", object.error}});
  return document({{"schema", "stonestack.model/1"},
                   {"views", modelled.scene.views.size()},
                   {"apart_before_m", modelled.scene.apart_before},
                   {"apart_after_m", modelled.scene.apart_after},
                   {"stones", stones},
                   {"failed", failed}});
}

std::string modelled_table(const ModelledViews& modelled) {
  std::string text = "stone                 size (mm)           mass (kg)  seen (%)  sigma (mm)  views\n";
  for (std::size_t k = 0; k < modelled.stones.size(); ++k) {
    const StoneSummary& summary = modelled.stones[k];
    const ObjectModel& model = modelled.models[k];
    const Eigen::Vector3d mm = 1e3 * summary.extents;
    text += format("%-20s%6.0f%6.0f%6.0f%13.2f%10.0f%12.2f%7d\n", summary.stone.name.c_str(), mm.x(), mm.y(),
                   mm.z(), summary.stone.mass.mass, 100 * model.seen_share, 1e3 * median(model.sigma),
                   model.views);
  }
  for (const FailedScan& object : modelled.failed) text += object.file + ": " + object.error + "\n";
  return text;
}

}  // namespace stonestack::report
