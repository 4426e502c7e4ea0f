#include "report/text.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack::report {

const char* structure_name(const std::optional<WallMetrics>& wall) {
  if (!wall) return "tower";
  return wall->to_span > 0.0 ? "bridge" : "wall";
}

std::string structure_name(const RunReport& report) {
  return report.result.wall ? structure_name(report.result.wall) : report.structure;
}

std::string run_title(const RunReport& report) {
  std::string title = concat(structure_name(report), " of ", report.result.height);
  title.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(title.front())));
  return title;
}

nlohmann::json wall_figures(const WallMetrics& m) {
  return {{"placed", m.placed},       {"asked", m.asked},     {"length_m", m.length},
          {"height_m", m.height},     {"width_m", m.width},   {"fill", m.fill},
          {"face", m.face},           {"joints", m.joints},   {"open_joints", m.open_joints},
          {"flatness_m", m.flatness}, {"margin_g", m.margin}, {"spanned_m", m.spanned},
          {"to_span_m", m.to_span}};
}

std::string wall_figures_text(const WallMetrics& m) {
  std::string text = format("%-6s %d", structure_name(m), m.placed);
  if (m.asked > 0) text += format(" of %d", m.asked);
  if (m.to_span > 0.0)
    return text + format(
                      " stones, %.2f m long, %.2f m high, %.2f m wide; bears %.3f g sideways\n"
                      "       %.0f of %.0f mm spanned",
                      m.length, m.height, m.width, m.margin, 1e3 * m.spanned, 1e3 * m.to_span);
  return text +
         format(
             " stones, %.2f m long, %.2f m high, %.2f m wide; bears %.3f g sideways\n"
             "       %.0f %% of its volume and %.0f %% of its face are stone; tops of a course %.0f mm "
             "about their mean\n"
             "       %d of %d joints run through two courses",
             m.length, m.height, m.width, m.margin, 1e2 * m.fill, 1e2 * m.face, 1e3 * m.flatness,
             m.open_joints, m.joints);
}

}  // namespace stonestack::report
