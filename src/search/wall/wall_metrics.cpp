#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "search/wall/wall_state.hpp"

namespace stonestack::search {
namespace {

constexpr double kThrough = 0.015;   // m between joints of two courses that are one joint running through
constexpr double kFaceCell = 0.004;  // m
constexpr int kWallDirections = 16;

/// Rows of the wall's face: cells that a stone covers, seen across the wall.
class Face {
 public:
  Face(double left, double right, double height)
      : left_(left),
        columns_(std::max(1, static_cast<int>(std::ceil((right - left) / kFaceCell)))),
        rows_(std::max(1, static_cast<int>(std::ceil(height / kFaceCell)))),
        covered_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0) {}

  /// Covers the span between the lowest and the highest point of a stone in each column.
  void add(const BodyPose& body) {
    std::vector<double> low(static_cast<std::size_t>(columns_), 1e9), high(low.size(), -1e9);
    for (const Eigen::Vector3i& f : body.stone->faces)
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d p = corner(body, f[k]), q = corner(body, f[(k + 1) % 3]);
        const double first = std::min(p.x(), q.x()), last = std::max(p.x(), q.x());
        for (int c = column(first); c <= column(last); ++c) {
          if (c < 0 || c >= columns_) continue;
          const double x = std::clamp(left_ + (c + 0.5) * kFaceCell, first, last);
          const double t = last - first > 1e-9 ? (x - p.x()) / (q.x() - p.x()) : 0.0;
          const double z = p.z() + t * (q.z() - p.z());
          const auto at = static_cast<std::size_t>(c);
          low[at] = std::min(low[at], z);
          high[at] = std::max(high[at], z);
        }
      }
    for (int c = 0; c < columns_; ++c)
      for (int r = 0; r < rows_; ++r) {
        const double z = (r + 0.5) * kFaceCell;
        const auto at = static_cast<std::size_t>(c);
        if (z >= low[at] && z <= high[at]) covered_[cell(c, r)] = 1;
      }
  }
  /// Number of covered cells and of all cells between two heights and two places.
  [[nodiscard]] std::pair<long, long> count(double left, double right, double low, double high) const {
    std::pair<long, long> sum{0, 0};
    for (int c = 0; c < columns_; ++c)
      for (int r = 0; r < rows_; ++r) {
        const double x = left_ + (c + 0.5) * kFaceCell, z = (r + 0.5) * kFaceCell;
        if (x < left || x > right || z < low || z > high) continue;
        sum.first += covered_[cell(c, r)];
        ++sum.second;
      }
    return sum;
  }

 private:
  [[nodiscard]] static Eigen::Vector3d corner(const BodyPose& body, int vertex) {
    return body.R_W_O * body.stone->vertices_M[static_cast<std::size_t>(vertex)] + body.p_W_M;
  }
  [[nodiscard]] int column(double x) const { return static_cast<int>(std::floor((x - left_) / kFaceCell)); }
  [[nodiscard]] std::size_t cell(int c, int r) const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c);
  }

  double left_;
  int columns_, rows_;
  std::vector<std::uint8_t> covered_;
};

/// A course as one block of the wall.
struct CourseBox {
  double left = 0.0, right = 0.0, low = 0.0, high = 0.0, width = 0.0;
  std::vector<double> joints;
};

CourseBox course_box(const WallState& state, const std::vector<int>& course, double low) {
  CourseBox box{1e9, -1e9, low, 0.0, 0.0, {}};
  const auto count = static_cast<double>(course.size());
  for (std::size_t k = 0; k < course.size(); ++k) {
    const WallStonePlaced& placed = state.stones[static_cast<std::size_t>(course[k])];
    box.left = std::min(box.left, placed.reach.min.x());
    box.right = std::max(box.right, placed.reach.max.x());
    box.high += placed.top / count;
    box.width += (placed.reach.max - placed.reach.min).y() / count;
    if (k == 0) continue;
    const WallStonePlaced& before = state.stones[static_cast<std::size_t>(course[k - 1])];
    box.joints.push_back(0.5 * (before.reach.max.x() + placed.reach.min.x()));
  }
  return box;
}

}  // namespace

double margin_of_all(const SearchContext& context, const WallState& state) {
  EquilibriumOptions statics;
  statics.friction = context.options->friction;
  statics.directions = kWallDirections;
  statics.min_friction = false;
  return stack_equilibrium(context.shapes(), state.stack(), statics).margin;
}

WallMetrics wall_metrics(const SearchContext& context, const WallState& state) {
  WallMetrics metrics;
  metrics.placed = static_cast<int>(state.stones.size());
  if (state.stones.empty()) return metrics;
  std::vector<CourseBox> boxes;
  double squares = 0.0, volume = 0.0, envelope = 0.0;
  for (int k = 0;; ++k) {
    const std::vector<int> course = state.course(k);
    if (course.empty()) break;
    boxes.push_back(course_box(state, course, boxes.empty() ? 0.0 : boxes.back().high));
    for (const int i : course) {
      const double off = state.stones[static_cast<std::size_t>(i)].top - boxes.back().high;
      squares += off * off;
    }
  }
  Face face(boxes.front().left, boxes.front().right, boxes.back().high);
  for (const WallStonePlaced& placed : state.stones) {
    const ContactShape& shape = *at(context.shapes(), placed.stone);
    face.add(body_pose(at(context.geometry, placed.stone), placed.T_W_O));
    volume += mass_properties(shape.scan, 1.0).mass;
  }
  long covered = 0, all = 0;
  for (const CourseBox& box : boxes) {
    const auto [of_box, cells] = face.count(box.left, box.right, box.low, box.high);
    covered += of_box;
    all += cells;
    metrics.width += box.width / static_cast<double>(boxes.size());
  }
  for (const CourseBox& box : boxes) envelope += (box.right - box.left) * (box.high - box.low) * box.width;
  for (std::size_t k = 0; k + 1 < boxes.size(); ++k)
    for (const double joint : boxes[k].joints) {
      if (joint < boxes[k + 1].left || joint > boxes[k + 1].right) continue;
      ++metrics.joints;
      const auto& above = boxes[k + 1].joints;
      metrics.open_joints += std::any_of(above.begin(), above.end(),
                                         [&](double other) { return std::abs(other - joint) < kThrough; })
                                 ? 1
                                 : 0;
    }
  metrics.length = boxes.front().right - boxes.front().left;
  metrics.height = boxes.back().high;
  metrics.flatness = std::sqrt(squares / static_cast<double>(state.stones.size()));
  metrics.fill = envelope > 0.0 ? volume / envelope : 0.0;
  metrics.face = all > 0 ? static_cast<double>(covered) / static_cast<double>(all) : 0.0;
  metrics.margin = margin_of_all(context, state);
  return metrics;
}

}  // namespace stonestack::search
