#include <algorithm>
#include <cmath>
#include <functional>

#include "report/plan_preview.hpp"
#include "report/svg.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::report {
namespace {

constexpr double kPlotWidth = 900, kPlotLeft = 70, kPlotRight = 130, kPlotTop = 84, kPanel = 190, kGap = 34,
                 kFooter = 50;
constexpr double kDegrees = 180.0 / 3.14159265358979323846, kMillimetres = 1000.0;

/// One curve of a panel.
struct Curve {
  std::string name, colour;
  std::function<double(const PlanMoment&)> value;
};

/// Curves over the same axes; they come one below the other.
struct Panel {
  std::string title;
  std::vector<Curve> curves;
};

std::vector<Panel> panels() {
  static const char* const kJoints[] = {"base", "shoulder", "elbow", "wrist 1", "wrist 2", "wrist 3"};
  static const char* const kColours[] = {"#1b6ca8", "#c8553d", "#3b8f4e", "#8a5aa5", "#b58900", "#333333"};
  Panel joints{"joints, degrees", {}};
  for (Eigen::Index j = 0; j < 6; ++j)
    joints.curves.push_back(
        {kJoints[j], kColours[j], [j](const PlanMoment& m) { return kDegrees * m.q[j]; }});
  return {joints,
          {"tool speed, mm/s",
           {{"tool", "#1b6ca8", [](const PlanMoment& m) { return kMillimetres * m.tool_speed; }}}},
          {"clearance, mm",
           {{"nearest", "#c8553d", [](const PlanMoment& m) { return kMillimetres * m.clearance; }}}}};
}

/// From data to one panel.
struct Frame {
  double top = 0, end = 1, low = 0, high = 1;
  [[nodiscard]] double x(double time) const {
    return kPlotLeft + (kPlotWidth - kPlotLeft - kPlotRight) * time / end;
  }
  [[nodiscard]] double y(double value) const {
    return top + kPanel * (1.0 - (std::clamp(value, low, high) - low) / (high - low));
  }
};

/// Bounds of the values, on round numbers and with 0.
Frame frame_of(const Panel& panel, const std::vector<PlanMoment>& moments, double top) {
  Frame frame{top, std::max(1e-9, moments.back().time), 0.0, 0.0};
  for (const auto& curve : panel.curves) {
    for (const auto& m : moments) {
      const double v = curve.value(m);
      if (!std::isfinite(v)) continue;
      frame.low = std::min(frame.low, v);
      frame.high = std::max(frame.high, v);
    }
  }
  const double step = tick(std::max(1e-9, frame.high - frame.low), 6);
  frame.low = step * std::floor(frame.low / step);
  frame.high = std::max(frame.low + step, step * std::ceil(frame.high / step));
  return frame;
}

std::string value_axis(const Panel& panel, const Frame& frame) {
  std::string text;
  const double step = tick(frame.high - frame.low, 6);
  for (double v = frame.low; v <= frame.high + 1e-9 * step; v += step)
    text += format(
        "<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#ddd'/>"
        "<text x='%.0f' y='%.1f' text-anchor='end'>%g</text>\n",
        kPlotLeft, kPlotWidth - kPlotRight, frame.y(v), frame.y(v), kPlotLeft - 8, frame.y(v) + 4,
        std::round(v / step) * step);
  return text + format("<text transform='translate(18 %.0f) rotate(-90)' text-anchor='middle'>%s</text>\n",
                       frame.top + kPanel / 2, panel.title.c_str());
}

std::string curve_path(const Curve& curve, const Frame& frame, const std::vector<PlanMoment>& moments) {
  std::string line;
  for (const auto& m : moments)
    if (const double v = curve.value(m); std::isfinite(v))
      line += format("%s%.1f %.1f", line.empty() ? "M" : "L", frame.x(m.time), frame.y(v));
  return "<path d='" + line + "' fill='none' stroke='" + curve.colour + "' stroke-width='1.5'/>\n";
}

std::string legend(const Panel& panel, const Frame& frame) {
  std::string text;
  double y = frame.top + 12;
  for (const auto& curve : panel.curves) {
    text += format("<text x='%.0f' y='%.0f' fill='%s'>%s</text>\n", kPlotWidth - kPlotRight + 12, y,
                   curve.colour.c_str(), curve.name.c_str());
    y += 17;
  }
  return text;
}

/// Text of a name: what XML gives a meaning is written as an entity.
std::string escaped(const std::string& name) {
  std::string text;
  for (const char c : name) {
    if (c == '&')
      text += "&amp;";
    else if (c == '<')
      text += "&lt;";
    else
      text += c;
  }
  return text;
}

/// A line where each step begins, with its number; the names stand in a title that a browser shows.
std::string step_marks(const PickAndPlacePlan& plan, const std::vector<PlanMoment>& moments, double bottom) {
  const Frame frame{0, std::max(1e-9, moments.back().time), 0, 1};
  std::string text;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    if (i > 0 && moments[i].step == moments[i - 1].step) continue;
    const double x = frame.x(moments[i].time);
    text += format("<line x1='%.1f' x2='%.1f' y1='%.0f' y2='%.0f' stroke='#aaa' stroke-dasharray='3 3'/>", x,
                   x, kPlotTop - 6, bottom);
    const std::string name = escaped(plan.steps[moments[i].step].name);
    text +=
        format("<text transform='translate(%.1f %.0f) rotate(-24)' font-size='10'>", x + 2, kPlotTop - 8) +
        name + "</text>\n";
  }
  return text;
}

std::string time_axis(double end, double bottom) {
  const Frame frame{0, std::max(1e-9, end), 0, 1};
  std::string text;
  const double step = tick(frame.end);
  for (double t = 0; t <= frame.end + 1e-9; t += step)
    text += format("<text x='%.1f' y='%.0f' text-anchor='middle'>%g</text>\n", frame.x(t), bottom + 18, t);
  return text + format("<text x='%.0f' y='%.0f' text-anchor='middle'>s of motion</text>\n",
                       (kPlotLeft + kPlotWidth - kPlotRight) / 2, bottom + 38);
}

}  // namespace

std::string plan_plot(const PickAndPlacePlan& plan, const std::vector<PlanMoment>& moments) {
  require(!moments.empty(), "a plot needs a plan with motions");
  const auto all = panels();
  const double bottom = kPlotTop + static_cast<double>(all.size()) * (kPanel + kGap) - kGap;
  std::string text = format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' font-family='sans-serif' "
      "font-size='12'>\n<rect width='100%%' height='100%%' fill='white'/>\n",
      kPlotWidth, bottom + kFooter);
  double top = kPlotTop;
  for (const auto& panel : all) {
    const Frame frame = frame_of(panel, moments, top);
    text += value_axis(panel, frame);
    for (const auto& curve : panel.curves) text += curve_path(curve, frame, moments);
    text += legend(panel, frame);
    top += kPanel + kGap;
  }
  return text + step_marks(plan, moments, bottom) + time_axis(moments.back().time, bottom) + "</svg>\n";
}

}  // namespace stonestack::report
