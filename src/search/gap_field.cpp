#include "search/gap_field.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack {
namespace {

constexpr std::size_t kBlock = 16;
constexpr float kPadding = -1e9F;
/// The centre of mass is moved by this fraction of a cell, so that it never lies on a line between two nodes
/// and the ratio test has no ties.
constexpr float kOffLine = 0.0137F;
constexpr double kViolation = 1e-5;      ///< m
constexpr double kArtificialRim = 0.12;  ///< m, radius of the three artificial cells
constexpr int kMostPivots = 60;

/// Index of the cell that lies highest above the plane. Blocks of fixed length, so that the compiler can
/// vectorise without being told that floats associate.
std::size_t most_violated(const GapField& field, float a, float b, float* value) {
  float best = kPadding;
  std::size_t best_block = 0;
  const std::size_t padded = field.d.size();
  for (std::size_t start = 0; start < padded; start += kBlock) {
    float over[kBlock];
    for (std::size_t k = 0; k < kBlock; ++k)
      over[k] = field.d[start + k] - a * field.x[start + k] - b * field.y[start + k];
    for (std::size_t half = kBlock / 2; half > 0; half /= 2)
      for (std::size_t k = 0; k < half; ++k) over[k] = over[k] < over[k + half] ? over[k + half] : over[k];
    if (over[0] > best) {
      best = over[0];
      best_block = start;
    }
  }
  std::size_t arg = best_block;
  for (std::size_t k = best_block; k < best_block + kBlock; ++k)
    if (field.d[k] - a * field.x[k] - b * field.y[k] == best) {
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
                      static_cast<int>(std::ceil(reach / options.cell)));
  raise_to(raster, turned, low);

  Underside underside;
  underside.R_W_O = R_W_O;
  underside.lowest = -deepest;
  for (int j = -raster.half; j <= raster.half; ++j) {
    for (int i = -raster.half; i <= raster.half; ++i) {
      const float z = raster.z[static_cast<std::size_t>(raster.index(i, j))];
      if (z < static_cast<float>(cut)) continue;
      underside.step.push_back(j * options.stride + i);
      underside.x.push_back(static_cast<float>(i * options.cell));
      underside.y.push_back(static_cast<float>(j * options.cell));
      underside.z.push_back(-z);
    }
  }
  return underside;
}

void lay(const TopSurface& top, const Underside& underside, int i, int j, double active, GapField* field) {
  const std::size_t n = underside.step.size();
  const int centre = top.heights.index(i, j);
  const float* z_top = top.heights.z.data();
  float highest = kPadding;
  for (std::size_t k = 0; k < n; ++k)
    highest = std::max(highest, z_top[centre + underside.step[k]] - underside.z[k]);
  const std::size_t room = (n + kBlock) / kBlock * kBlock;
  if (field->x.capacity() < room) {
    field->x.reserve(room), field->y.reserve(room), field->d.reserve(room), field->node.reserve(room);
  }
  field->x.resize(room), field->y.resize(room), field->d.resize(room), field->node.resize(room);
  const float least = highest - static_cast<float>(active);
  const float off = kOffLine * static_cast<float>(top.heights.cell);
  std::size_t count = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const int node = centre + underside.step[k];
    const float d = z_top[node] - underside.z[k];
    field->x[count] = underside.x[k] + off;
    field->y[count] = underside.y[k] + 0.52F * off;
    field->d[count] = d;
    field->node[count] = node;
    count += d >= least ? 1 : 0;
  }
  const std::size_t padded = (count + kBlock - 1) / kBlock * kBlock;
  field->x.resize(padded), field->y.resize(padded), field->d.resize(padded), field->node.resize(padded);
  for (std::size_t k = count; k < padded; ++k) {
    field->x[k] = field->y[k] = 0.0F;
    field->d[k] = kPadding;
    field->node[k] = centre;
  }
  field->size = count;
  field->highest = highest;
}

GapRest solve_rest(const GapField& field, const TopSurface& top, double largest_slope) {
  GapRest rest;
  if (field.size == 0) return rest;
  Basis basis = artificial_basis(field.highest, largest_slope);
  for (int pivot = 0; pivot < kMostPivots; ++pivot) {
    if (!basis.fit_plane()) return rest;
    float over = 0.0F;
    const std::size_t k =
        most_violated(field, static_cast<float>(basis.a), static_cast<float>(basis.b), &over);
    if (static_cast<double>(over) - basis.c <= kViolation) break;
    const Eigen::Vector3d q(static_cast<double>(field.x[k]), static_cast<double>(field.y[k]),
                            static_cast<double>(field.d[k]));
    if (!basis.enter(q, static_cast<int>(k))) return rest;
  }
  rest.height = basis.c;
  rest.a = basis.a;
  rest.b = basis.b;
  rest.cells = basis.cell;
  rest.rests = std::all_of(basis.cell.begin(), basis.cell.end(), [](int cell) { return cell >= 0; });
  rest.clean = rest.rests && std::all_of(basis.cell.begin(), basis.cell.end(), [&](int cell) {
                 return top.may_touch[static_cast<std::size_t>(field.node[static_cast<std::size_t>(cell)])];
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
  for (std::size_t k = 0; k < field.size; ++k) {
    if (field.d[k] < c + a * field.x[k] + b * field.y[k]) continue;
    for (std::size_t m = 0; m < kDirections; ++m)
      reach[m] = std::max(reach[m], directions[m].x() * field.x[k] + directions[m].y() * field.y[k]);
    sum += static_cast<double>(top.heights.z[static_cast<std::size_t>(field.node[k])]);
    ++count;
  }
  GapContact contact;
  if (count == 0) return contact;
  contact.margin = static_cast<double>(*std::min_element(reach.begin(), reach.end()));
  contact.height = rest.height - sum / count;
  return contact;
}

}  // namespace stonestack
