#include "detection/segment/complete_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/quantile.hpp"
#include "detection/scene/seen_normal.hpp"

namespace stonestack::detection {
namespace {

constexpr int kInset = 6;              // px from the end of a run: normals span 4 px to each side
constexpr int kSmear = 3;              // px at the end of a run that mix both sides
constexpr double kWidestFront = 0.20;  // m that the object in front may hide
constexpr double kMaxBend = 0.35;    // rad between the tangent planes on both sides (20 deg): noise over 8 px
constexpr double kOffPlane = 0.006;  // m of a point from the other side's tangent plane, ...
constexpr double kOffPlaneGrowth = 0.10;  // ... and times the distance
constexpr double kFrontBefore = 0.003;    // m that the object in front must be nearer than the line behind it
constexpr int kFewestAgreeing = 18;       // lines that agree
constexpr double kAgreeing = 0.45;        // share of the lines that lead from one part to the other
constexpr int kRimGap = 6;                // px without depth between the inside of a vessel and its rim
constexpr int kRimPixels = 12;            // of a rim at least
constexpr int kShortestSpan = 8;          // px across a hollow
constexpr double kHollow = 0.02;          // mean depth of a hollow over its width
constexpr double kLevelRim = 0.012;       // m between the tenth and the ninth tenth of a rim's heights
constexpr double kSameRim = 0.012;        // m between the rim in front and the top of the inside

/// Part or other surface along a line of pixels.
struct Run {
  int label;                ///< part; kNoDepth, kOther
  std::size_t first, last;  ///< positions on the line
};
constexpr int kNoDepth = -1, kOther = -2;

using Line = std::vector<std::size_t>;  // pixels

/// All rows, columns and diagonals.
std::vector<Line> lines_of(const CameraIntrinsics& camera) {
  std::vector<Line> lines;
  const auto add = [&](int u, int v, int du, int dv) {
    Line line;
    for (; u >= 0 && u < camera.width && v >= 0 && v < camera.height; u += du, v += dv)
      line.push_back(static_cast<std::size_t>(v * camera.width + u));
    lines.push_back(std::move(line));
  };
  for (int v = 0; v < camera.height; ++v) add(0, v, 1, 0), add(0, v, 1, 1), add(0, v, 1, -1);
  for (int u = 0; u < camera.width; ++u) add(u, 0, 0, 1);
  for (int u = 1; u < camera.width; ++u) add(u, 0, 1, 1), add(u, camera.height - 1, 1, -1);
  return lines;
}

std::vector<Run> runs_along(const Line& line, const ObjectSurface& surface, const SurfaceParts& parts) {
  std::vector<Run> runs;
  for (std::size_t k = 0; k < line.size(); ++k) {
    const int part = parts.label[line[k]];
    const int label = part >= 0 ? part : surface.depth.z[line[k]] > 0 ? kOther : kNoDepth;
    if (runs.empty() || runs.back().label != label)
      runs.push_back({label, k, k});
    else
      runs.back().last = k;
  }
  return runs;
}

/// Evidence of the lines about a pair of parts, the lower index first.
struct Continuation {
  int lines = 0, agreeing = 0;
};
/// Sight of a part behind the rim of another.
struct Rim {
  std::vector<double> heights;  ///< above the table, of the pixels in front [m]
};
/// How a part curves: sum of depth behind the chord over width, and how many chords.
struct Hollow {
  double sum = 0.0;
  int chords = 0;
};

class Evidence {
 public:
  Evidence(const ObjectSurface& surface, const SurfaceParts& parts) : surface_(surface), parts_(parts) {
    hollows.resize(parts.pixels.size());
    for (const Line& line : lines_of(surface.depth.camera)) {
      const std::vector<Run> runs = runs_along(line, surface, parts);
      for (std::size_t i = 0; i < runs.size(); ++i) {
        if (runs[i].label < 0) continue;
        bend(line, runs[i]);
        look_for_rim(line, runs, i);
        look_behind(line, runs, i);
      }
    }
  }

  std::map<std::pair<int, int>, Continuation> continuations;
  std::map<std::pair<int, int>, Rim> rims;  ///< (part behind, part in front)
  std::vector<Hollow> hollows;              ///< a part each

 private:
  [[nodiscard]] Eigen::Vector3d point(std::size_t pixel) const {
    return surface_.points[pixel].cast<double>();
  }
  [[nodiscard]] Eigen::Vector3d normal(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(surface_.depth.camera.width);
    return seen_normal(surface_.depth, static_cast<int>(pixel % width), static_cast<int>(pixel / width));
  }

  /// Depth of the middle of a run behind the chord between its ends.
  void bend(const Line& line, const Run& run) {
    if (run.last - run.first + 1 < static_cast<std::size_t>(kShortestSpan)) return;
    const std::size_t a = line[run.first + 1], b = line[run.last - 1], m = line[(run.first + run.last) / 2];
    const double za = surface_.depth.z[a], zb = surface_.depth.z[b];
    const double width = (point(b) - point(a)).norm();
    Hollow& hollow = hollows[static_cast<std::size_t>(run.label)];
    const double share = static_cast<double>((run.first + run.last) / 2 - run.first - 1) /
                         static_cast<double>(run.last - run.first - 2);
    hollow.sum += (surface_.depth.z[m] - 1.0 / ((1.0 - share) / za + share / zb)) / std::max(width, 1e-3);
    ++hollow.chords;
  }

  void look_for_rim(const Line& line, const std::vector<Run>& runs, std::size_t i) {
    std::size_t k = i + 1;
    if (k < runs.size() && runs[k].label == kNoDepth &&
        runs[k].last - runs[k].first < static_cast<std::size_t>(kRimGap))
      ++k;
    if (k >= runs.size() || runs[k].label < 0 || runs[k].label == runs[i].label) return;
    const auto inset = [](const Run& run) { return std::min<std::size_t>(kSmear, run.last - run.first); };
    const bool first_behind = surface_.depth.z[line[runs[i].last - inset(runs[i])]] >
                              surface_.depth.z[line[runs[k].first + inset(runs[k])]];
    const Run& front = first_behind ? runs[k] : runs[i];
    const auto length = std::min<std::size_t>(kRimGap, front.last - front.first + 1);
    double top = 0.0;
    for (std::size_t m = 0; m < length; ++m)
      top = std::max(
          top, surface_.table_V->distance(point(line[first_behind ? front.first + m : front.last - m])));
    const auto key = std::pair(first_behind ? runs[i].label : runs[k].label, front.label);
    rims[key].heights.push_back(top);
  }

  /// True if every pixel of a run, but for its smeared ends, is nearer than the straight line behind it.
  [[nodiscard]] bool hides(const Line& line, const Run& run, const Run& from, const Run& to) const {
    const double za = surface_.depth.z[line[from.last]], zb = surface_.depth.z[line[to.first]];
    const auto smear = std::min<std::size_t>(kSmear, (run.last - run.first) / 2);
    for (std::size_t k = run.first + smear; k + smear <= run.last; ++k) {
      const double share = static_cast<double>(k - from.last) / static_cast<double>(to.first - from.last);
      if (surface_.depth.z[line[k]] > 1.0 / ((1.0 - share) / za + share / zb) - kFrontBefore) return false;
    }
    return true;
  }

  void look_behind(const Line& line, const std::vector<Run>& runs, std::size_t i) {
    for (std::size_t k = i + 1; k < runs.size() && runs[k].label != kOther; ++k) {
      if (runs[k].label < 0) continue;
      if (runs[k].label == runs[i].label) return;
      bool hidden = false;
      bool all = true;
      for (std::size_t m = i + 1; m < k; ++m) {
        if (runs[m].label < 0) continue;
        hidden = true;
        all = all && hides(line, runs[m], runs[i], runs[k]);
      }
      const double gap = (point(line[runs[k].first]) - point(line[runs[i].last])).norm();
      if (hidden && all && gap < kWidestFront) compare(line, runs[i], runs[k]);
    }
  }

  void compare(const Line& line, const Run& from, const Run& to) {
    const auto inset = static_cast<std::size_t>(kInset);
    if (from.last - from.first < inset || to.last - to.first < inset) return;
    const std::size_t a = line[from.last - inset], b = line[to.first + inset];
    const Eigen::Vector3d n_a = normal(a), n_b = normal(b);
    if (n_a.isZero() || n_b.isZero()) return;
    const Eigen::Vector3d gap = point(b) - point(a);
    const double off = kOffPlane + kOffPlaneGrowth * gap.norm();
    const auto [low, high] = std::minmax(from.label, to.label);
    Continuation& found = continuations[{low, high}];
    ++found.lines;
    const bool agrees =
        n_a.dot(n_b) > std::cos(kMaxBend) && std::abs(n_a.dot(gap)) < off && std::abs(n_b.dot(gap)) < off;
    found.agreeing += agrees ? 1 : 0;
  }

  const ObjectSurface& surface_;
  const SurfaceParts& parts_;
};

/// Highest surface of a part above the table, but for a twentieth of it [m].
double top_of(const ObjectSurface& surface, const SurfaceParts& parts, int part) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < parts.label.size(); ++i)
    if (parts.label[i] == part)
      heights.push_back(surface.table_V->distance(surface.points[i].cast<double>()));
  return quantile(std::move(heights), 0.95);
}

bool is_vessel(const ObjectSurface& surface, const SurfaceParts& parts, int inside, const Rim& rim,
               const Hollow& hollow) {
  if (rim.heights.size() < static_cast<std::size_t>(kRimPixels) || hollow.chords == 0) return false;
  if (hollow.sum / hollow.chords < kHollow) return false;
  const double low = quantile(rim.heights, 0.1), high = quantile(rim.heights, 0.9);
  return high - low < kLevelRim && std::abs(top_of(surface, parts, inside) - high) < kSameRim;
}

}  // namespace

void complete_parts(const ObjectSurface& surface, SurfaceParts& parts) {
  const Evidence evidence(surface, parts);
  std::vector<int> owner(parts.pixels.size());
  std::iota(owner.begin(), owner.end(), 0);
  const auto root = [&](int a) {
    while (owner[static_cast<std::size_t>(a)] != a) a = owner[static_cast<std::size_t>(a)];
    return a;
  };
  const auto join = [&](int a, int b) {
    a = root(a), b = root(b);
    owner[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  };
  for (const auto& [pair, found] : evidence.continuations)
    if (found.agreeing >= kFewestAgreeing && found.agreeing >= kAgreeing * found.lines)
      join(pair.first, pair.second);
  for (const auto& [pair, rim] : evidence.rims)
    if (is_vessel(surface, parts, pair.first, rim, evidence.hollows[static_cast<std::size_t>(pair.first)]))
      join(pair.first, pair.second);
  SurfaceParts joined;
  std::vector<int> name(owner.size(), -1);
  for (std::size_t k = 0; k < owner.size(); ++k) {
    const auto r = static_cast<std::size_t>(root(static_cast<int>(k)));
    if (name[r] < 0) {
      name[r] = static_cast<int>(joined.pixels.size());
      joined.pixels.push_back(0);
    }
    name[k] = name[r];
    joined.pixels[static_cast<std::size_t>(name[k])] += parts.pixels[k];
  }
  joined.label = std::move(parts.label);
  for (int& label : joined.label)
    if (label >= 0) label = name[static_cast<std::size_t>(label)];
  parts = std::move(joined);
}

}  // namespace stonestack::detection
