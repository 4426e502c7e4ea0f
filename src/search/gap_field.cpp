#include "search/gap_field.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack {
namespace {

constexpr float kPadding = -1e9F;
/// The centre of mass is moved by this fraction of a cell, so that it never lies on a line between two nodes
/// and the ratio test has no ties.
constexpr float kOffLine = 0.0137F;
constexpr double kViolation = 1e-5;      ///< m
constexpr double kArtificialRim = 0.12;  ///< m, radius of the three artificial cells
constexpr int kMostPivots = 60;

/// Highest of the eight, without being told that floats associate, so that the compiler may do it at once.
float highest_of(const float* values) {
  float v[kRun / 2];
  for (int k = 0; k < 4; ++k) v[k] = values[k] < values[k + 4] ? values[k + 4] : values[k];
  for (int k = 0; k < 2; ++k) v[k] = v[k] < v[k + 2] ? v[k + 2] : v[k];
  return v[0] < v[1] ? v[1] : v[0];
}

/// The cell that lies highest above the plane a x + b y. Runs that cannot hold it are passed over.
std::size_t most_violated(const GapField& field, float a, float b, float* value) {
  const Underside& side = *field.underside;
  const float slack = std::abs(a) * static_cast<float>(side.run_reach);
  float best = kPadding;
  std::size_t best_run = 0;
  for (const int r : field.runs) {
    const auto run = static_cast<std::size_t>(r);
    const float at_most = field.highest_d[run] - a * side.middle_x[run] - b * side.row_y[run] + slack;
    if (at_most < best) continue;
    const std::size_t start = run * kRun;
    float over[kRun];
    for (std::size_t k = 0; k < kRun; ++k)
      over[k] = field.d[start + k] - a * side.x[start + k] - b * side.y[start + k];
    const float highest = highest_of(over);
    if (highest > best) {
      best = highest;
      best_run = run;
    }
  }
  std::size_t arg = best_run * kRun;
  for (std::size_t k = arg; k < (best_run + 1) * kRun; ++k)
    if (field.d[k] - a * side.x[k] - b * side.y[k] == best) {
      arg = k;
      break;
    }
  *value = best;
  return arg;
}

/// Three cells around the centre of mass and the plane through them.
struct Basis {
  std::array<Eigen::Vector3d, 3> p;
  std::array<int, 3> cell{-1, -1, -1};  ///< -1: artificial
  double c = 0.0, a = 0.0, b = 0.0;

  /// Barycentric coordinates of a point of the plane z = 0. False if the three are on one line.
  bool weights(double x, double y, std::array<double, 3>* w) const {
    const double ux = p[1].x() - p[0].x(), uy = p[1].y() - p[0].y();
    const double vx = p[2].x() - p[0].x(), vy = p[2].y() - p[0].y();
    const double det = ux * vy - uy * vx;
    if (std::abs(det) < 1e-12) return false;
    const double dx = x - p[0].x(), dy = y - p[0].y();
    (*w)[1] = (dx * vy - dy * vx) / det;
    (*w)[2] = (ux * dy - uy * dx) / det;
    (*w)[0] = 1.0 - (*w)[1] - (*w)[2];
    return true;
  }
  bool fit_plane() {
    std::array<double, 3> w0{}, wx{}, wy{};
    if (!weights(0, 0, &w0) || !weights(1, 0, &wx) || !weights(0, 1, &wy)) return false;
    const auto height = [&](const std::array<double, 3>& w) {
      return w[0] * p[0].z() + w[1] * p[1].z() + w[2] * p[2].z();
    };
    c = height(w0);
    a = height(wx) - c;
    b = height(wy) - c;
    return true;
  }
  /// Brings a cell in and takes the one out that keeps the centre of mass enclosed.
  bool enter(const Eigen::Vector3d& q, int index) {
    std::array<double, 3> at_centre{}, at_q{};
    if (!weights(0, 0, &at_centre) || !weights(q.x(), q.y(), &at_q)) return false;
    std::size_t leaving = 3;
    double least = 1e300;
    for (std::size_t k = 0; k < 3; ++k) {
      if (at_q[k] <= 1e-9) continue;
      const double ratio = at_centre[k] / at_q[k];
      if (ratio < least) {
        least = ratio;
        leaving = k;
      }
    }
    if (leaving == 3) return false;
    p[leaving] = q;
    cell[leaving] = index;
    return true;
  }
};

Basis artificial_basis(double highest, double largest_slope) {
  Basis basis;
  for (std::size_t k = 0; k < 3; ++k) {
    const double angle = 2.0943951 * static_cast<double>(k) + 0.1;
    basis.p[k] = {kArtificialRim * std::cos(angle), kArtificialRim * std::sin(angle),
                  highest - largest_slope * kArtificialRim};
  }
  return basis;
}

/// The nodes of one row that lie below the cut (z is negated), in runs inside the raster.
void add_row(const HeightRaster& raster, int j, float cut, const UndersideOptions& options, Underside* side) {
  const float* row = raster.z.data() + raster.index(0, j);
  const auto off = kOffLine * static_cast<float>(options.cell);
  for (int i = -raster.half; i <= raster.half; ++i) {
    if (row[i] < cut) continue;
    const int first = std::min(i, raster.half - kRun + 1);  // the last run ends at the raster's rim
    side->step.push_back(j * options.stride + first);
    side->middle_x.push_back(static_cast<float>((first + 0.5 * (kRun - 1)) * options.cell) + off);
    side->row_y.push_back(static_cast<float>(j * options.cell) + 0.52F * off);
    for (int k = first; k < first + kRun; ++k) {
      side->x.push_back(static_cast<float>(k * options.cell) + off);
      side->y.push_back(side->row_y.back());
      side->z.push_back(k >= i && row[k] >= cut ? -row[k] : -kPadding);
    }
    i = first + kRun - 1;
  }
}

}  // namespace

Underside make_underside(const std::vector<Eigen::Vector3d>& vertices_M,
                         const std::vector<Eigen::Vector3i>& faces, const Eigen::Matrix3d& R_W_O,
                         const UndersideOptions& options) {
  // Heights are negated, so that the underside is a top.
  std::vector<Eigen::Vector3d> turned(vertices_M.size());
  double deepest = -1e300, reach = 0.0;
  for (std::size_t k = 0; k < vertices_M.size(); ++k) {
    turned[k] = R_W_O * vertices_M[k];
    turned[k].z() = -turned[k].z();
    deepest = std::max(deepest, turned[k].z());
  }
  const double cut = deepest - options.cut;
  std::vector<Eigen::Vector3i> low;
  low.reserve(faces.size() / 2);
  for (const Eigen::Vector3i& f : faces) {
    const auto &p = turned[static_cast<std::size_t>(f[0])], &q = turned[static_cast<std::size_t>(f[1])],
               &r = turned[static_cast<std::size_t>(f[2])];
    if (std::max({p.z(), q.z(), r.z()}) < cut) continue;
    low.push_back(f);
    for (const auto* v : {&p, &q, &r}) reach = std::max({reach, std::abs(v->x()), std::abs(v->y())});
  }
  HeightRaster raster(Eigen::Vector2d::Zero(), options.cell,
                      std::max(kRun / 2, static_cast<int>(std::ceil(reach / options.cell))));
  raise_to(raster, turned, low);
  Underside underside;
  underside.R_W_O = R_W_O;
  underside.lowest = -deepest;
  underside.run_reach = 0.5 * kRun * options.cell;
  for (int j = -raster.half; j <= raster.half; ++j)
    add_row(raster, j, static_cast<float>(cut), options, &underside);
  return underside;
}

void lay(const TopSurface& top, const Underside& underside, int i, int j, double active, GapField* field) {
  const std::size_t runs = underside.step.size();
  field->underside = &underside;
  field->centre = top.heights.index(i, j);
  field->d.resize(runs * kRun);
  field->highest_d.resize(runs);
  field->highest = kPadding;
  const float* z_top = top.heights.z.data() + field->centre;
  const float* z_side = underside.z.data();
  float* d = field->d.data();
  for (std::size_t run = 0; run < runs; ++run, z_side += kRun, d += kRun) {
    const float* z = z_top + underside.step[run];
    for (std::size_t k = 0; k < kRun; ++k) d[k] = z[k] - z_side[k];
    field->highest_d[run] = highest_of(d);
    field->highest = std::max(field->highest, field->highest_d[run]);
  }
  const float least = field->highest - static_cast<float>(active);
  field->runs.clear();
  for (std::size_t run = 0; run < runs; ++run)
    if (field->highest_d[run] >= least) field->runs.push_back(static_cast<int>(run));
}

GapRest solve_rest(const GapField& field, const TopSurface& top, double largest_slope) {
  GapRest rest;
  if (field.runs.empty()) return rest;
  Basis basis = artificial_basis(field.highest, largest_slope);
  for (int pivot = 0; pivot < kMostPivots; ++pivot) {
    if (!basis.fit_plane()) return rest;
    float over = 0.0F;
    const std::size_t k =
        most_violated(field, static_cast<float>(basis.a), static_cast<float>(basis.b), &over);
    if (static_cast<double>(over) - basis.c <= kViolation) break;
    const Underside& side = *field.underside;
    const Eigen::Vector3d q(static_cast<double>(side.x[k]), static_cast<double>(side.y[k]),
                            static_cast<double>(field.d[k]));
    if (!basis.enter(q, static_cast<int>(k))) return rest;
  }
  rest.height = basis.c;
  rest.a = basis.a;
  rest.b = basis.b;
  rest.cells = basis.cell;
  rest.rests = std::all_of(basis.cell.begin(), basis.cell.end(), [](int cell) { return cell >= 0; });
  rest.clean =
      rest.rests && std::all_of(basis.cell.begin(), basis.cell.end(), [&](int cell) {
        return top.may_touch[static_cast<std::size_t>(field.node(static_cast<std::size_t>(cell)))] != 0;
      });
  return rest;
}

GapContact contact_of(const GapField& field, const GapRest& rest, const TopSurface& top, double tolerance) {
  constexpr std::size_t kDirections = 12;
  static const auto directions = [] {
    std::array<Eigen::Vector2f, kDirections> list;
    for (std::size_t k = 0; k < kDirections; ++k) {
      const double angle = 6.283185307179586 * static_cast<double>(k) / kDirections;
      list[k] = Eigen::Vector2d(std::cos(angle), std::sin(angle)).cast<float>();
    }
    return list;
  }();
  std::array<float, kDirections> reach;
  reach.fill(kPadding);
  double sum = 0.0;
  int count = 0;
  const auto c = static_cast<float>(rest.height - tolerance);
  const auto a = static_cast<float>(rest.a), b = static_cast<float>(rest.b);
  const Underside& side = *field.underside;
  const float slack = std::abs(a) * static_cast<float>(side.run_reach);
  for (const int r : field.runs) {
    const auto run = static_cast<std::size_t>(r);
    if (field.highest_d[run] < c + a * side.middle_x[run] + b * side.row_y[run] - slack) continue;
    for (std::size_t k = run * kRun; k < (run + 1) * kRun; ++k) {
      if (field.d[k] < c + a * side.x[k] + b * side.y[k]) continue;
      for (std::size_t m = 0; m < kDirections; ++m)
        reach[m] = std::max(reach[m], directions[m].x() * side.x[k] + directions[m].y() * side.y[k]);
      sum += static_cast<double>(top.heights.z[static_cast<std::size_t>(field.node(k))]);
      ++count;
    }
  }
  GapContact contact;
  if (count == 0) return contact;
  contact.margin = static_cast<double>(*std::min_element(reach.begin(), reach.end()));
  contact.height = rest.height - sum / count;
  return contact;
}

}  // namespace stonestack
