#include "search/gap_field.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stonestack::search {
namespace {

constexpr float kPadding = -1e9F;
/// The centre of mass is moved by this fraction of a cell, so that it never lies on a line between two nodes
/// and the ratio test has no ties.
constexpr float kOffLine = 0.0137F;
constexpr double kViolation = 1e-5;      ///< [m]
constexpr double kArtificialRim = 0.12;  ///< radius of the three artificial cells [m]
constexpr double kDeepestStart =
    0.1;  ///< distance [m] below the largest gap: deeper cells carry no information
constexpr int kMaxPivots = 60;

using Run = Eigen::Array<float, kRun, 1>;
Eigen::Map<const Run> run_of(const std::vector<float>& values, std::size_t run) {
  return Eigen::Map<const Run>(values.data() + run * kRun);
}

/// The cell that lies highest above the plane a x + b y, if one lies above it by more than *value, which
/// becomes its height; -1 if none does. Runs that cannot hold it are passed over.
int most_violated(const GapField& field, float a, float b, float* value) {
  const Underside& side = *field.underside;
  const float slack = std::abs(a) * static_cast<float>(side.run_reach);
  float best = *value;
  int best_run = -1;
  for (std::size_t block = 0; block < field.active_d.size(); block += kRun) {
    const std::size_t k = block / kRun;
    const Run at_most =
        run_of(field.active_d, k) - a * run_of(field.active_x, k) - b * run_of(field.active_y, k) + slack;
    if (at_most.maxCoeff() <= best) continue;
    for (std::size_t m = 0; m < kRun; ++m) {
      if (at_most[static_cast<Eigen::Index>(m)] <= best) continue;
      const int r = field.runs[block + m];
      const auto run = static_cast<std::size_t>(r);
      const float highest = (run_of(field.d, run) - a * run_of(side.x, run)).maxCoeff() - b * side.row_y[run];
      if (highest > best) {
        best = highest;
        best_run = r;
      }
    }
  }
  if (best_run < 0) return -1;
  *value = best;
  const auto run = static_cast<std::size_t>(best_run);
  Eigen::Index arg = 0;
  (run_of(field.d, run) - a * run_of(side.x, run)).maxCoeff(&arg);
  return best_run * kRun + static_cast<int>(arg);
}

/// Three cells around the centre of mass and the plane through them.
struct Basis {
  std::array<Eigen::Vector3d, 3> p;
  std::array<int, 3> cell = kArtificial;
  double c = 0.0, a = 0.0, b = 0.0;

  void set(std::size_t k, const Eigen::Vector3d& q, int index) {
    p[k] = q;
    cell[k] = index;
  }
  /// Height of a point over the plane a x + b y.
  [[nodiscard]] double over_slope(const Eigen::Vector3d& q) const { return q.z() - a * q.x() - b * q.y(); }
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
    double min = 1e300;
    for (std::size_t k = 0; k < 3; ++k) {
      if (at_q[k] <= 1e-9) continue;
      const double ratio = at_centre[k] / at_q[k];
      if (ratio < min) {
        min = ratio;
        leaving = k;
      }
    }
    if (leaving == 3) return false;
    set(leaving, q, index);
    return true;
  }
};

Basis artificial_basis(double highest, double max_slope) {
  Basis basis;
  for (std::size_t k = 0; k < 3; ++k) {
    const double angle = 2.0943951 * static_cast<double>(k) + 0.1;
    basis.p[k] = {kArtificialRim * std::cos(angle), kArtificialRim * std::sin(angle),
                  highest - max_slope * kArtificialRim};
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
  raise_to(raster, turned, low, Winding::kClockwise);
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
  float* d = field->d.data();
  for (std::size_t run = 0; run < runs; ++run, d += kRun) {
    const Run gap = Eigen::Map<const Run>(z_top + underside.step[run]) - run_of(underside.z, run);
    Eigen::Map<Run>{d} = gap;
    field->highest_d[run] = gap.maxCoeff();
    field->highest = std::max(field->highest, field->highest_d[run]);
  }
  const float min = field->highest - static_cast<float>(active);
  field->runs.clear();
  for (std::size_t run = 0; run < runs; ++run)
    if (field->highest_d[run] >= min) field->runs.push_back(static_cast<int>(run));
  while (field->runs.size() % kRun != 0) field->runs.push_back(field->runs.back());
  const std::size_t kept = field->runs.size();
  field->active_d.resize(kept);
  field->active_x.resize(kept);
  field->active_y.resize(kept);
  for (std::size_t k = 0; k < kept; ++k) {
    const auto run = static_cast<std::size_t>(field->runs[k]);
    field->active_d[k] = field->highest_d[run];
    field->active_x[k] = underside.middle_x[run];
    field->active_y[k] = underside.row_y[run];
  }
}

GapRest solve_rest(const GapField& field, const TopSurface& top, double max_slope,
                   const std::array<int, 3>& start) {
  GapRest rest;
  if (field.runs.empty()) return rest;
  const Basis rim = artificial_basis(field.highest, max_slope);
  Basis basis = rim;
  for (std::size_t k = 0; k < 3; ++k)
    basis.set(k, start[k] < 0 ? rim.p[static_cast<std::size_t>(-1 - start[k])] : field.point(start[k]),
              start[k]);
  const double lowest = static_cast<double>(field.highest) - kDeepestStart;
  if (std::any_of(basis.p.begin(), basis.p.end(), [&](const auto& p) { return p.z() < lowest; })) basis = rim;
  for (int pivot = 0; pivot < kMaxPivots; ++pivot) {
    if (!basis.fit_plane()) return rest;
    auto over = static_cast<float>(basis.c + kViolation);
    int entering = most_violated(field, static_cast<float>(basis.a), static_cast<float>(basis.b), &over);
    bool optimal = entering < 0;
    Eigen::Vector3d q = optimal ? Eigen::Vector3d::Zero() : field.point(entering);
    for (std::size_t k = 0; k < 3; ++k)
      if (const auto at = static_cast<float>(basis.over_slope(rim.p[k])); at > over) {
        over = at;
        entering = kArtificial[k];
        q = rim.p[k];
        optimal = false;
      }
    if (optimal) {
      rest.rests = std::all_of(basis.cell.begin(), basis.cell.end(), [](int cell) { return cell >= 0; });
      break;
    }
    if (!basis.enter(q, entering)) return rest;
  }
  rest.height = basis.c;
  rest.a = basis.a;
  rest.b = basis.b;
  rest.cells = basis.cell;
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
  int last = -1;
  for (const int r : field.runs) {
    if (r == std::exchange(last, r)) break;  // filled up
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

}  // namespace stonestack::search
