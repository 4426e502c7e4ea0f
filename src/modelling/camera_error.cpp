#include "modelling/camera_error.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "detection/scene/preprocess.hpp"
#include "detection/segment/object_surface.hpp"
#include "geometry/camera_check.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::modelling {
namespace {

using detection::DepthError;

constexpr double kFullCell = 0.5;      // of a cell's pixels: enough to speak of its mean
constexpr double kFewestPairs = 50.0;  // of views that show table in the same cell, to tell what they share
constexpr double kElsewhere = 0.03;  // m between places of the table, of which each is uneven in its own way
constexpr double kMinRest = 0.02;    // of the variance of all cells: noise is never nothing
constexpr std::size_t kAround = 48;  // cells of which the error at one is made
constexpr double kReach = 2.5;       // correlation lengths, beyond which cells tell nothing

/// The table of one view.
struct SeenTable {
  DepthError error;
  std::vector<Eigen::Vector3d> p_W;  ///< where the middle of each cell sees it
};

SeenTable seen_table(const DepthView& view, const DepthImage& smooth, const Plane& table_C,
                     const DetectionOptions& options) {
  SeenTable seen{detection::measure_depth_error(smooth, table_C, options), {}};
  for (int row = 0; row < seen.error.rows; ++row)
    for (int column = 0; column < seen.error.columns; ++column) {
      const Eigen::Vector3d ray =
          deproject(view.image.camera, seen.error.cell * (column + 0.5), seen.error.cell * (row + 0.5));
      seen.p_W.push_back(view.T_W_C * (table_C.offset / table_C.normal.dot(ray) * ray));
    }
  return seen;
}

/// Deviations of the table, all views together.
struct SharedCells {
  std::vector<double> mean;  ///< a cell each [m]
  std::vector<int> views;    ///< that show table there
  DepthError shared;         ///< how far the shared error is alike; its sigma is 0 where views share nothing
  double rest = 0.0;         ///< variance of a cell's deviation that a view has alone [m^2]

  /// Distance of two cells [px].
  [[nodiscard]] double apart(std::size_t a, std::size_t b) const {
    const auto columns = static_cast<std::size_t>(shared.columns);
    const double du = static_cast<double>(a % columns) - static_cast<double>(b % columns);
    const double dv = static_cast<double>(a / columns) - static_cast<double>(b / columns);
    return shared.cell * std::hypot(du, dv);
  }
};

SharedCells merge(const std::vector<SeenTable>& views) {
  SharedCells cells;
  cells.shared = views.front().error;
  cells.shared.sigma = 0.0;
  const std::size_t count = cells.shared.offset.size();
  const double full = kFullCell * cells.shared.cell * cells.shared.cell;
  cells.mean.assign(count, 0.0);
  cells.views.assign(count, 0);
  double products = 0.0, pairs = 0.0, squares = 0.0, shown = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t a = 0; a < views.size(); ++a) {
      if (views[a].error.count[i] < full) continue;
      const double offset = views[a].error.offset[i];
      cells.mean[i] += (offset - cells.mean[i]) / ++cells.views[i];
      squares += offset * offset;
      ++shown;
      for (std::size_t b = 0; b < a; ++b)
        if (views[b].error.count[i] >= full && (views[a].p_W[i] - views[b].p_W[i]).norm() > kElsewhere) {
          products += offset * views[b].error.offset[i];
          ++pairs;
        }
    }
  }
  if (pairs < kFewestPairs) return cells;
  const double all = squares / shown, shared = std::clamp(products / pairs, 0.0, all);
  cells.shared.sigma = std::sqrt(shared);
  cells.rest = std::max(kMinRest * all, all - shared);
  double lengths = 0.0;
  for (const SeenTable& view : views) lengths += view.error.length;
  cells.shared.length = lengths / static_cast<double>(views.size());
  return cells;
}

/// The expected error of one cell, given what the cells around it show.
double expected(const SharedCells& cells, std::size_t cell) {
  struct Near {
    double distance;
    std::size_t cell;
  };
  std::vector<Near> around;
  for (std::size_t i = 0; i < cells.mean.size(); ++i)
    if (const double distance = cells.apart(i, cell);
        cells.views[i] > 0 && distance < kReach * cells.shared.length)
      around.push_back({distance, i});
  if (around.empty()) return 0.0;
  const std::size_t taken = std::min(kAround, around.size());
  std::partial_sort(around.begin(), around.begin() + static_cast<std::ptrdiff_t>(taken), around.end(),
                    [](const Near& a, const Near& b) {
                      return a.distance != b.distance ? a.distance < b.distance : a.cell < b.cell;
                    });
  const auto size = static_cast<Eigen::Index>(taken);
  Eigen::MatrixXd K(size, size);
  Eigen::VectorXd k(size), mean(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Near& a = around[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < size; ++j)
      K(i, j) = cells.shared.covariance(cells.apart(a.cell, around[static_cast<std::size_t>(j)].cell));
    K(i, i) += cells.rest / cells.views[a.cell];
    k(i) = cells.shared.covariance(a.distance);
    mean(i) = cells.mean[a.cell];
  }
  return k.dot(K.ldlt().solve(mean));
}

}  // namespace

double CameraError::at(double u, double v) const {
  if (offset.empty()) return 0.0;
  const double x = std::clamp(u / cell - 0.5, 0.0, columns - 1.0);
  const double y = std::clamp(v / cell - 0.5, 0.0, rows - 1.0);
  const int column = std::min(static_cast<int>(x), columns - 2),
            row = std::min(static_cast<int>(y), rows - 2);
  const double s = x - column, t = y - row;
  const auto value = [&](int c, int r) { return offset[static_cast<std::size_t>(r * columns + c)]; };
  return (1 - t) * ((1 - s) * value(column, row) + s * value(column + 1, row)) +
         t * ((1 - s) * value(column, row + 1) + s * value(column + 1, row + 1));
}

CameraError measure_camera_error(std::span<const DepthView> views, const SegmentOptions& segment) {
  for (const DepthView& view : views) require_usable(view.image);
  const DetectionOptions options = detection::detection_options(segment);
  std::vector<SeenTable> seen;
  for (const DepthView& view : views) {
    const CameraIntrinsics &camera = view.image.camera, &first = views.front().image.camera;
    if (camera.width != first.width || camera.height != first.height) return {};
    const DepthImage smooth = detection::smooth_depth(view.image, options);
    if (const auto table_C = detection::find_table(smooth, std::nullopt, options))
      seen.push_back(seen_table(view, smooth, *table_C, options));
  }
  if (seen.size() < 2 || seen.front().error.columns < 2 || seen.front().error.rows < 2) return {};
  const SharedCells cells = merge(seen);
  if (!(cells.shared.sigma > 0.0)) return {};
  CameraError error{cells.shared.cell, cells.shared.columns, cells.shared.rows, {}, cells.shared.sigma};
  error.offset.resize(cells.mean.size());
  tbb::parallel_for(std::size_t{0}, error.offset.size(),
                    [&](std::size_t i) { error.offset[i] = expected(cells, i); });
  return error;
}

DepthImage without_error(DepthImage image, const CameraError& error) {
  if (error.offset.empty()) return image;
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      float& z = image.z[static_cast<std::size_t>(v * image.camera.width + u)];
      if (z > 0) z -= static_cast<float>(error.at(u + 0.5, v + 0.5));
    }
  return image;
}

}  // namespace stonestack::modelling
