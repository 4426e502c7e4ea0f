#include "report/text.hpp"

namespace stonestack::report {

nlohmann::json wall_figures(const WallMetrics& m) {
  return {{"placed", m.placed},       {"asked", m.asked},    {"length_m", m.length},
          {"height_m", m.height},     {"width_m", m.width},  {"fill", m.fill},
          {"face", m.face},           {"joints", m.joints},  {"open_joints", m.open_joints},
          {"flatness_m", m.flatness}, {"margin_g", m.margin}};
}

std::string wall_figures_text(const WallMetrics& m) {
  std::string text = format("wall   %d", m.placed);
  if (m.asked > 0) text += format(" of %d", m.asked);
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
