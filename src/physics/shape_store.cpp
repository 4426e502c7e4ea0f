#include "physics/shape_store.hpp"

#include <bit>
#include <cstdint>

#include "core/recently_used.hpp"
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

}  // namespace

std::shared_ptr<const ShapeGeometry> make_geometry(const Mesh& scan, const ShapeOptions& options) {
  return std::make_shared<const ShapeGeometry>(
      ShapeGeometry{SignedDistance(scan, options.cell, options.band), sample_surface(scan, options.spacing),
                    std::make_shared<const SurfaceFeatures>(surface_features(scan))});
}

std::shared_ptr<const ShapeGeometry> shape_geometry(const Mesh& scan, const ShapeOptions& options) {
  static RecentlyUsed<ShapeGeometry> made(kMaxKept);
  const std::uint64_t key = key_of(scan, options);
  if (auto known = made.find(key)) return known;
  return made.keep(key, make_geometry(scan, options));
}

}  // namespace stonestack::physics
