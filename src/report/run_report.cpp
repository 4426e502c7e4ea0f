#include "stonestack/report/record_run.hpp"

#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "physics/shape.hpp"
#include "report/base64.hpp"
#include "report/cell_page.hpp"
#include "report/modelling_results.hpp"
#include "report/picture.hpp"
#include "report/run_page.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::report {

// Files of src/report/page and three.js, embedded by the build.
extern const std::string_view kPageHtml, kPageCss, kElementsJs, kSceneJs, kPageJs, kThreeJs, kLiveJs,
    kExperimentHtml, kExperimentJs, kCellHtml, kCellJs;

namespace {

using nlohmann::json;

constexpr double kReportDegrees = 57.295779513082321;

json placement_entry(const PlacementRecord& record) {
  json entry{{"stone", record.stone},
             {"T_W_O_planned", pose_json(record.planned.T_W_O)},
             {"T_W_O_measured", record.T_W_O_measured ? pose_json(*record.T_W_O_measured) : json(nullptr)},
             {"cost", record.planned.cost},
             {"terms", record.planned.terms},
             {"predicted_success", record.planned.predicted_success},
             {"outcome", to_text(record.outcome)},
             {"level", record.level},
             {"note", record.note}};
  if (record.course > 0) entry["course"] = record.course;
  return entry;
}

json truth_entry(const TruthReport& truth) {
  json engines = json::array();
  for (const EngineVerdict& verdict : truth.engines)
    engines.push_back({{"engine", verdict.engine},
                       {"height", verdict.height},
                       {"seconds", verdict.seconds},
                       {"shift_m", verdict.shift},
                       {"turn_rad", verdict.turn},
                       {"note", verdict.note}});
  return {{"height", truth.height},   {"stands", truth.stands},
          {"seconds", truth.seconds}, {"shift_m", truth.shift},
          {"turn_rad", truth.turn},   {"note", truth.note},
          {"engines", engines},       {"engines_disagree", engines_disagree(truth)}};
}

double term(const Placement& placement, const std::string& name) {
  const auto found = placement.terms.find(name);
  return found == placement.terms.end() ? 0.0 : found->second;
}

std::string pose_text(const Pose& pose) {
  const Eigen::Vector3d& p = pose.translation();
  const Eigen::AngleAxisd turn(pose.linear());
  const Eigen::Vector3d r = turn.angle() * turn.axis() * kReportDegrees;
  return format("(%4.0f %4.0f %4.0f) mm (%4.0f %4.0f %4.0f) deg", 1000 * p.x(), 1000 * p.y(), 1000 * p.z(),
                r.x(), r.y(), r.z());
}

std::string escape(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else
      safe += c;
  }
  return safe;
}

/// JSON that may stand within a script element: no tag and no comment begins in it.
std::string within_script(const std::string& text) {
  std::string safe;
  for (const char c : text)
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  return safe;
}

std::string summary(const RunReport& report) {
  std::string text = format("%s of %d of %d stones; ended: ", structure_name(report).c_str(),
                            report.result.height, static_cast<int>(report.present.size())) +
                     report.result.ended + "\n";
  if (report.result.wall) text += wall_figures_text(*report.result.wall) + "\n";
  if (!report.cell.empty()) text += "simulated cell " + cell_text(report) + "\n";
  if (report.truth)
    text += format("true world: %d stones stacked, %s after %.0f s (largest shift %.2f mm)\n",
                   report.truth->height, report.truth->stands ? "standing" : "not standing",
                   report.truth->seconds, 1000 * report.truth->shift);
  if (report.truth && engines_disagree(*report.truth))
    for (const EngineVerdict& verdict : report.truth->engines)
      text += format("  in %s %d stones stand %.0f s%s\n", verdict.engine.c_str(), verdict.height,
                     verdict.seconds, verdict.note.empty() ? "" : (": " + verdict.note).c_str());
  text += format("%s by the paper's protocol (before the first placement that failed): %d\n",
                 report.result.wall ? "stones" : "height", paper_height(report));
  const auto& s = report.result.seconds;
  text += format(
      "seconds: detection %.1f, search %.1f, planning %.1f (host; %.1f more while the arm moved); "
      "motion %.1f (robot)\n",
      s.detection, s.search, s.planning, s.beside_motion, s.motion);
  return text;
}

/// Steps of a dry run.
std::string planned_table(const std::vector<PlannedStep>& steps) {
  std::string text = "\n   s  tool m/s  clearance mm  step that would be done\n";
  for (const PlannedStep& step : steps) {
    text += step.seconds > 0 ? format("%4.1f  %8.3f  ", step.seconds, step.tool_speed) : "   -         -  ";
    text += (step.clearance ? format("%12.0f", 1e3 * *step.clearance) : std::string("           -")) + "  " +
            step.name + "\n";
  }
  return text;
}

}  // namespace

std::string run_json(const RunReport& report) {
  const RunResult& result = report.result;
  json placements = json::array();
  for (const auto& record : result.placements) placements.push_back(placement_entry(record));
  json out = {
      {"schema", "stonestack.run/1"},
      {"height", result.height},
      {"paper_height", paper_height(report)},
      {"placements", placements},
      {"ended", to_text(result.end)},
      {"reason", result.ended},
      {"robot", report.robot},
      {"seed", report.seed},
      {"cell", {{"name", report.cell.empty() ? "real" : report.cell}, {"changes", report.cell_changes}}},
      {"stones", report.present},
      {"seconds",
       {{"detection", result.seconds.detection},
        {"search", result.seconds.search},
        {"planning", result.seconds.planning},
        {"motion", result.seconds.motion},
        {"beside_motion", result.seconds.beside_motion}}}};
  if (!report.safety_checksum.empty()) out["cell"]["safety_checksum"] = report.safety_checksum;
  if (result.wall) out["wall"] = wall_figures(*result.wall);
  for (const PlannedStep& step : result.planned) {
    out["planned"].push_back(
        {{"step", step.name}, {"seconds", step.seconds}, {"tool_speed", step.tool_speed}});
    if (step.clearance) out["planned"].back()["clearance_m"] = *step.clearance;
  }
  if (report.truth) out["truth"] = truth_entry(*report.truth);
  if (report.modelling) out["modelling"] = modelling_entry(*report.modelling);
  if (!report.version.empty()) out["version"] = report.version;
  if (!report.picture.empty()) out["picture"] = std::filesystem::path(report.picture).filename().string();
  return out.dump(2) + "\n";
}

std::string run_table(const RunReport& report) {
  std::string text = report.modelling ? modelling_text(*report.modelling) : std::string();
  if (report.modelling && report.result.placements.empty()) return text + summary(report);
  text += "\nlevel stone            cost   area  ekin  dist  norm  p(ok) outcome     planned | measured\n";
  int level = 0;
  for (const auto& r : report.result.placements) {
    const auto& p = r.planned;
    text += format("%5d %-15s %5.2f  %5.2f %5.2f %5.2f %5.2f  %4.2f  %-10s  ", ++level, r.stone.c_str(),
                   p.cost, term(p, "area"), term(p, "kinetic_energy"), term(p, "distance"), term(p, "normal"),
                   p.predicted_success, to_text(r.outcome).c_str());
    text += pose_text(p.T_W_O) + " | " +
            (r.T_W_O_measured ? pose_text(*r.T_W_O_measured) : std::string("not seen")) + "\n";
  }
  return (report.result.planned.empty() ? text : planned_table(report.result.planned)) + summary(report);
}

std::string picture_uri(const RunReport& report) {
  if (report.picture.empty()) return "";
  return "data:image/png;base64," + base64(read_file(report.picture, std::size_t{1} << 26));
}

namespace {

/// Begin of a page up to its body.
std::string page_head(const std::string& title) {
  std::string text = "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n";
  text += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
          escape(title) + "</title>\n<style>\n";
  return text.append(kPageCss).append("</style>\n<body>\n");
}

std::string script(std::string_view text) {
  return std::string("<script>\n").append(text).append("</script>\n");
}

}  // namespace

std::string page_html(const std::string& title, const std::string& text, const std::string& data) {
  std::string page = page_head(title);
  page.append(kPageHtml).append("<noscript><pre>").append(escape(text)).append("</pre></noscript>\n");
  page += script(kThreeJs) + script("const run = " + within_script(data) + ";\n");
  page += script(kElementsJs) + script(kSceneJs) + script(kLiveJs) + script(kPageJs);
  return page + "</body>\n</html>\n";
}

std::string experiment_page(const std::string& data, const std::string& text) {
  std::string page = page_head("Experiment");
  page.append(kExperimentHtml).append("<noscript><pre>").append(escape(text)).append("</pre></noscript>\n");
  page += script("const experiment = " + within_script(data) + ";\n") + script(kElementsJs) +
          script(kLiveJs) + script(kExperimentJs);
  return page + "</body>\n</html>\n";
}

std::string cell_page(const std::string& title, const std::string& text, const std::string& data) {
  std::string page = page_head(title);
  page.append(kCellHtml).append("<noscript><pre>").append(escape(text)).append("</pre></noscript>\n");
  page += script(kThreeJs) + script("const run = " + within_script(data) + ";\n");
  page += script(kElementsJs) + script(kSceneJs) + script(kCellJs);
  return page + "</body>\n</html>\n";
}

std::string run_html(const RunReport& report, const Catalogue& catalogue, const RobotModel& robot) {
  return page_html(run_title(report), run_table(report),
                   page_data(report, catalogue, robot, picture_uri(report)));
}

std::vector<DrawnMesh> drawn_stones(const Catalogue& catalogue, const std::vector<PlacedStone>& stones) {
  static const std::array<Eigen::Vector3d, 6> kColours{{{0.72, 0.68, 0.60},
                                                        {0.62, 0.60, 0.57},
                                                        {0.70, 0.60, 0.50},
                                                        {0.58, 0.61, 0.63},
                                                        {0.76, 0.72, 0.68},
                                                        {0.60, 0.54, 0.47}}};
  std::vector<DrawnMesh> drawn;
  for (const auto& placed : stones)
    drawn.push_back({catalogue[placed.stone].scan, placed.T_W_O,
                     kColours[static_cast<std::size_t>(placed.stone.value()) % kColours.size()], true, true});
  return drawn;
}

ShapeList shapes_for_output(const std::vector<Stone>& stones) {
  ShapeList shapes;
  for (const Stone& stone : stones)
    shapes.push_back(
        physics::make_contact_shape(stone.scan, stone.mass, stone.name, physics::ShapeOptions{}));
  return shapes;
}

View view_of_site(const Eigen::Vector2d& site, double top_height) {
  View view;
  view.p_W_target = {site.x(), site.y() - 0.05, 0.45 * std::max(top_height, 0.15)};
  const double distance = 0.75 + 1.1 * top_height;
  view.p_W_eye = view.p_W_target + distance * Eigen::Vector3d(0.62, -0.70, 0.42).normalized();
  return view;
}

}  // namespace stonestack::report
