#include "detection/segment/part_tree.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <numeric>
#include <queue>
#include <tuple>

#include "detection/constants.hpp"
#include "detection/segment/grooves.hpp"

namespace stonestack::detection {
namespace {

constexpr int kMarkerCell = 8;          // px
constexpr float kMarkerDepth = 0.25F;   // no marker lies in a groove
constexpr float kMarkerCentre = 1e-4F;  // groove depth that a pixel off the cell's centre is worth

/// Surface with its groove depths, and which pixels are neighbours.
struct Relief {
  const ObjectSurface& surface;
  std::vector<float> groove;
  int width, height;

  [[nodiscard]] float strength(std::size_t a, std::size_t b) const {
    return std::max({groove[a], groove[b], step_between(surface, a, b)});
  }
  /// Calls visit(neighbour) for the shown pixels right of and below, and with `all` left of and above, too.
  template <class Visit>
  void for_each_neighbour(std::size_t i, bool all, Visit&& visit) const {
    const auto w = static_cast<std::size_t>(width);
    const std::size_t u = i % w, v = i / w;
    const auto consider = [&](bool inside, std::size_t k) {
      if (inside && surface.shown[k] != 0) visit(k);
    };
    consider(u + 1 < w, i + 1);
    consider(v + 1 < static_cast<std::size_t>(height), i + w);
    if (!all) return;
    consider(u > 0, i - 1);
    consider(v > 0, i - w);
  }
};

/// Pixel of the cell that lies least deep in a groove; the number of pixels if all do.
std::size_t marker_in(const Relief& relief, int u0, int v0) {
  std::size_t best = relief.groove.size();
  float lowest = kMarkerDepth;
  for (int v = v0; v < std::min(relief.height, v0 + kMarkerCell); ++v)
    for (int u = u0; u < std::min(relief.width, u0 + kMarkerCell); ++u) {
      const auto i = static_cast<std::size_t>(v * relief.width + u);
      const int off = std::abs(v - v0 - kMarkerCell / 2) + std::abs(u - u0 - kMarkerCell / 2);
      const float depth = relief.groove[i] + kMarkerCentre * static_cast<float>(off);
      if (relief.surface.shown[i] != 0 && depth < lowest) lowest = depth, best = i;
    }
  return best;
}

/// Watershed: a basin for each marker, and one for each island that has none.
struct Basins {
  std::vector<int> label;
  int count = 0;
};

Basins flood(const Relief& relief) {
  using Entry = std::tuple<float, int, std::size_t>;  // strength, order of arrival, pixel
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  Basins basins{std::vector<int>(relief.groove.size(), -1)};
  int order = 0;
  const auto start = [&](std::size_t i) {
    basins.label[i] = basins.count++;
    open.emplace(0.0F, order++, i);
  };
  const auto spread = [&] {
    while (!open.empty()) {
      const auto [level, arrived, i] = open.top();
      open.pop();
      relief.for_each_neighbour(i, true, [&, level = level, i = i](std::size_t k) {
        if (basins.label[k] >= 0) return;
        basins.label[k] = basins.label[i];
        open.emplace(std::max(level, relief.strength(i, k)), order++, k);
      });
    }
  };
  for (int v = 0; v < relief.height; v += kMarkerCell)
    for (int u = 0; u < relief.width; u += kMarkerCell)
      if (const std::size_t i = marker_in(relief, u, v); i < relief.groove.size()) start(i);
  spread();
  for (std::size_t i = 0; i < relief.groove.size(); ++i)
    if (relief.surface.shown[i] != 0 && basins.label[i] < 0) start(i), spread();
  return basins;
}

/// Boundary between two parts.
struct Boundary {
  double sum = 0.0;  ///< of strengths
  int count = 0;     ///< pairs of pixels
};

/// Region adjacency graph that is merged from the weakest boundary on.
class PartGraph {
 public:
  PartGraph(const Relief& relief, const Basins& basins) {
    const auto count = static_cast<std::size_t>(basins.count);
    beside_.resize(count);
    pixels_.assign(count, 0);
    version_.assign(count, 0);
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0);
    for (std::size_t i = 0; i < basins.label.size(); ++i) {
      if (basins.label[i] < 0) continue;
      ++pixels_[static_cast<std::size_t>(basins.label[i])];
      relief.for_each_neighbour(i, false, [&](std::size_t k) {
        if (basins.label[i] != basins.label[k])
          touch(basins.label[i], basins.label[k], relief.strength(i, k));
      });
    }
    for (int a = 0; a < basins.count; ++a) offer(a);
  }

  void merge_all() {
    while (!merges_.empty()) {
      const Merge next = merges_.top();
      merges_.pop();
      const bool stale = at(parent_, next.a) != next.a || at(parent_, next.b) != next.b ||
                         at(version_, next.a) != next.version_a || at(version_, next.b) != next.version_b;
      if (stale) continue;
      if (next.cost > kPartCost) break;
      merge(next);
    }
  }

  [[nodiscard]] int root(int a) const {
    while (at(parent_, a) != a) a = at(parent_, a);
    return a;
  }
  [[nodiscard]] int pixels(int a) const { return at(pixels_, a); }

 private:
  struct Merge {
    double cost;
    int a, b, version_a, version_b;
    bool operator<(const Merge& other) const {  // the cheapest on top
      return std::tie(cost, a, b) > std::tie(other.cost, other.a, other.b);
    }
  };

  template <class T>
  static T& at(std::vector<T>& list, int i) {
    return list[static_cast<std::size_t>(i)];
  }
  template <class T>
  static const T& at(const std::vector<T>& list, int i) {
    return list[static_cast<std::size_t>(i)];
  }

  void touch(int a, int b, double strength) {
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
      Boundary& boundary = at(beside_, from)[to];
      boundary.sum += strength;
      ++boundary.count;
    }
  }

  [[nodiscard]] double cost(int a, int b, const Boundary& boundary) const {
    const int smaller = std::min(at(pixels_, a), at(pixels_, b));
    return boundary.sum / boundary.count - kPartAllowance / std::sqrt(static_cast<double>(smaller));
  }

  void offer(int a) {
    for (const auto& [b, boundary] : at(beside_, a)) {
      const auto [low, high] = std::minmax(a, b);
      merges_.push({cost(a, b, boundary), low, high, at(version_, low), at(version_, high)});
    }
  }

  void merge(const Merge& next) {
    int a = next.a, b = next.b;
    if (at(beside_, a).size() < at(beside_, b).size()) std::swap(a, b);
    at(parent_, b) = a;
    at(pixels_, a) += at(pixels_, b);
    ++at(version_, a);
    at(beside_, a).erase(b);
    for (const auto& [k, boundary] : at(beside_, b)) {
      if (k == a) continue;
      at(beside_, k).erase(b);
      Boundary& both = at(beside_, a)[k];
      both.sum += boundary.sum;
      both.count += boundary.count;
      at(beside_, k)[a] = both;
    }
    at(beside_, b).clear();
    offer(a);
  }

  std::vector<std::map<int, Boundary>> beside_;
  std::vector<int> pixels_, version_, parent_;
  std::priority_queue<Merge> merges_;
};

}  // namespace

SurfaceParts split_surface(const ObjectSurface& surface, int fewest) {
  const Relief relief{surface, groove_depths(surface), surface.depth.camera.width,
                      surface.depth.camera.height};
  const Basins basins = flood(relief);
  PartGraph graph(relief, basins);
  graph.merge_all();
  SurfaceParts parts;
  parts.label.assign(basins.label.size(), -1);
  std::map<int, int> name_of;
  for (std::size_t i = 0; i < basins.label.size(); ++i) {
    if (basins.label[i] < 0) continue;
    const int root = graph.root(basins.label[i]);
    if (graph.pixels(root) < fewest) continue;
    const auto [entry, fresh] = name_of.try_emplace(root, static_cast<int>(name_of.size()));
    if (fresh) parts.pixels.push_back(graph.pixels(root));
    parts.label[i] = entry->second;
  }
  return parts;
}

}  // namespace stonestack::detection
