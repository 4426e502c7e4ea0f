#include <algorithm>

#include "physics/touch.hpp"

namespace stonestack::physics {
namespace {
bool same(const Touch& a, const Touch& b) {
  if (a.kind != b.kind) return false;
  switch (a.kind) {  // a vertex that crosses a seam is the same touch
    case TouchKind::kVertexOfA:
    case TouchKind::kDeepA:
      return a.a == b.a && a.n_W.dot(b.n_W) > 0.99;
    case TouchKind::kVertexOfB:
    case TouchKind::kDeepB:
      return a.b == b.b && a.n_W.dot(b.n_W) > 0.99;
    case TouchKind::kEdges:
      return a.a == b.a && a.b == b.b;
  }
  return false;
}
}  // namespace

void reduce(std::vector<Touch>& touches, const std::vector<Touch>& before, std::size_t max) {
  if (touches.size() <= max) return;
  const std::size_t count = touches.size();
  std::vector<double> bonus(count, 0.0), nearest(count, 1e9);
  for (std::size_t i = 0; i < count; ++i) {
    const bool kept =
        std::any_of(before.begin(), before.end(), [&](const Touch& o) { return same(touches[i], o); });
    bonus[i] = (kept ? 0.004 : 0.0) - 4.0 * std::max(touches[i].gap, 0.0);
  }
  std::vector<char> taken(count, 0);
  std::size_t next = 0;
  for (std::size_t i = 1; i < count; ++i)
    if (touches[i].gap < touches[next].gap) next = i;
  std::vector<std::size_t> chosen;
  while (chosen.size() < max) {
    chosen.push_back(next);
    taken[next] = 1;
    double best = -1e9;
    const Touch& last = touches[next];
    for (std::size_t i = 0; i < count; ++i) {
      if (taken[i]) continue;
      // Alike as a place and, by 20 mm, as a direction; the place alone is often too far to matter.
      const double square = (touches[i].p_A - last.p_A).squaredNorm();
      if (square < nearest[i] * nearest[i])
        nearest[i] = std::min(nearest[i], std::sqrt(square) + 0.02 * (touches[i].n_W - last.n_W).norm());
      if (nearest[i] + bonus[i] > best) {
        best = nearest[i] + bonus[i];
        next = i;
      }
    }
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<Touch> kept;
  for (const std::size_t i : chosen) kept.push_back(touches[i]);
  touches = std::move(kept);
}

void carry_over(std::vector<Touch>& touches, const std::vector<Touch>& before) {
  std::vector<char> used(before.size(), 0);
  std::vector<char> done(touches.size(), 0);
  const auto take = [&](std::size_t i, std::size_t j) {
    touches[i].impulse = before[j].impulse;
    touches[i].friction = before[j].friction;
    used[j] = done[i] = 1;
  };
  for (std::size_t i = 0; i < touches.size(); ++i)
    for (std::size_t j = 0; j < before.size() && !done[i]; ++j)
      if (!used[j] && same(touches[i], before[j])) take(i, j);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    if (done[i]) continue;
    std::size_t best = before.size();
    double nearest = 0.001;
    for (std::size_t j = 0; j < before.size(); ++j)
      if (!used[j] && touches[i].n_W.dot(before[j].n_W) > 0.95 &&
          (touches[i].p_A - before[j].p_A).norm() < nearest) {
        nearest = (touches[i].p_A - before[j].p_A).norm();
        best = j;
      }
    if (best < before.size()) take(i, best);
  }
}

}  // namespace stonestack::physics
