#include "stonestack/stone/model_stone.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "stone/geodesic.hpp"
#include "stone/rubble.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/geometry/convex_pieces.hpp"

namespace stonestack::stone {
namespace {

constexpr std::uint64_t kAttempts = 64;  // forms drawn

/// How many times as deep as drawn hollows may become. Averaging over large faces fills hollows (surface),
/// so with 1000 faces a form in twenty reaches the usual fullness at the first depth, with 500 none in two
/// hundred; at the second all do. The second is asked only when the first failed: deep hollows look carved.
constexpr double kDepths[] = {2.2, 4.4};

void check(const LimestoneOptions& o) {
  require(o.min_extent >= 0.02 && o.min_extent <= o.max_extent && o.max_extent <= 2.0,
          "longest extent must be in [0.02, 2] m, got [", o.min_extent, ", ", o.max_extent, "]");
  require(o.widest >= 0.6 * o.min_extent, "widest must be at least 0.6 * smallest, got ", o.widest, " m");
  require(o.min_fullness >= 0.7 && o.max_fullness <= 0.95 && o.min_fullness + 0.02 <= o.max_fullness,
          "volume over hull must be in [0.7, 0.95] and 0.02 wide, got [", o.min_fullness, ", ",
          o.max_fullness, "]");
  require(o.faces >= 320 && o.faces <= 200000, "faces must be in [320, 200000], got ", o.faces);
}

/// Longest, second and shortest extent: near 1 : 0.8 : 0.55, as rubble is.
Eigen::Vector3d draw_extents(Random& random, const LimestoneOptions& options) {
  const double longest = random.uniform(options.min_extent, options.max_extent);
  const double second = std::min(longest * random.uniform(0.68, 0.90),
                                 options.widest - 0.002);  // the grain adds up to a millimetre a side
  return {longest, second, second * random.uniform(0.58, 0.82)};
}

double fullness(const Mesh& mesh) {
  return volume(mesh) / volume(convex_hull(mesh));
}

/// Fills or deepens, up to `deep`, the hollows of one drawn form until its fullness is `target`; empty if
/// that is out of its reach.
std::optional<Mesh> with_fullness(const Rubble& rubble, const Mesh& sphere, double target, double deep) {
  double shallow = 0.5;
  Mesh mesh = surface(rubble, sphere, deep);
  if (fullness(mesh) > target) return std::nullopt;
  for (int turn = 0; turn < 12; ++turn) {
    const double middle = (shallow + deep) / 2.0;
    mesh = surface(rubble, sphere, middle);
    const double full = fullness(mesh);
    if (std::abs(full - target) < 0.006) return mesh;
    (full > target ? shallow : deep) = middle;
  }
  return std::nullopt;
}

/// The first drawn form that comes to a fullness within the options.
std::optional<Mesh> draw_limestone(std::uint64_t seed, const LimestoneOptions& options, const Mesh& sphere,
                                   double deep) {
  for (std::uint64_t attempt = 0; attempt < kAttempts; ++attempt) {
    Random random = Random::stream(seed, attempt);
    const Eigen::Vector3d extents = draw_extents(random, options);
    const Rubble rubble = draw_rubble(random, extents);
    const double middle = (options.min_fullness + options.max_fullness) / 2.0;
    const double spread = (options.max_fullness - options.min_fullness) / 2.0 - 0.006;
    const double target = middle + spread * random.uniform(-0.6, 1.0);
    if (auto mesh = with_fullness(rubble, sphere, target, deep)) return mesh;
  }
  return std::nullopt;
}

}  // namespace

Mesh make_limestone(std::uint64_t seed, const LimestoneOptions& options) {
  check(options);
  const Mesh sphere = make_geodesic(static_cast<int>(std::sqrt(options.faces / 20.0)));
  for (const double deep : kDepths)
    if (const auto mesh = draw_limestone(seed, options, sphere, deep)) return *mesh;
  throw InvalidArgument(concat("no stone of ", options.faces, " faces with volume over hull in [",
                               options.min_fullness, ", ", options.max_fullness, "] after ", kAttempts,
                               " forms; widen the range or allow more faces"));
}

}  // namespace stonestack::stone
