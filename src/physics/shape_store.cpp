#include "physics/shape_store.hpp"

#include <bit>
#include <cstdint>
#include <list>
#include <mutex>

#include "physics/features.hpp"

namespace stonestack::physics {
namespace {

/// Everything that decides the geometry, as one 64 bit number (splitmix64's finaliser).
std::uint64_t key_of(const Mesh& scan, const ShapeOptions& options) {
  std::uint64_t key = scan.vertices.size();
  const auto add = [&key](std::uint64_t word) {
    key ^= word + 0x9e3779b97f4a7c15u;
    key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9u;
    key = (key ^ (key >> 27)) * 0x94d049bb133111ebu;
    key ^= key >> 31;
  };
  for (const Eigen::Vector3d& v : scan.vertices)
    for (int k = 0; k < 3; ++k) add(std::bit_cast<std::uint64_t>(v[k]));
  for (const Eigen::Vector3i& face : scan.faces)
    for (int k = 0; k < 3; ++k) add(static_cast<std::uint64_t>(face[k]));
  for (const double value : {options.cell, options.band, options.spacing})
    add(std::bit_cast<std::uint64_t>(value));
  return key;
}

struct Kept {
  std::uint64_t key = 0;
  std::shared_ptr<const ShapeGeometry> geometry;
};

}  // namespace

std::shared_ptr<const ShapeGeometry> shape_geometry(const Mesh& scan, const ShapeOptions& options) {
  static std::mutex mutex;
  static std::list<Kept> kept;  // the last used first
  const std::uint64_t key = key_of(scan, options);
  const auto find = [key]() -> std::shared_ptr<const ShapeGeometry> {
    for (auto it = kept.begin(); it != kept.end(); ++it) {
      if (it->key != key) continue;
      kept.splice(kept.begin(), kept, it);
      return kept.front().geometry;
    }
    return nullptr;
  };
  {
    const std::scoped_lock lock(mutex);
    if (auto known = find()) return known;
  }
  auto made = std::make_shared<const ShapeGeometry>(
      ShapeGeometry{SignedDistance(scan, options.cell, options.band), sample_surface(scan, options.spacing),
                    std::make_shared<const SurfaceFeatures>(surface_features(scan))});
  const std::scoped_lock lock(mutex);
  if (auto known = find()) return known;  // another thread was faster
  kept.push_front({key, made});
  if (kept.size() > kMostKept) kept.pop_back();
  return made;
}

}  // namespace stonestack::physics
