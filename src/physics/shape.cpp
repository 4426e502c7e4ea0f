#include "physics/shape.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "physics/shape_store.hpp"
#include "stone/possible_stone.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {

namespace {

constexpr ShapeOptions kPossible{0.003, 0.012, 0.006};  // a tenth of the time; contact is between features

/// The shape holds the whole geometry, so that as long as it lives others find that.
std::shared_ptr<const ContactShape> shape_of(const Mesh& scan, const MassProperties& mass,
                                             const std::string& name,
                                             const std::shared_ptr<const ShapeGeometry>& geometry) {
  double radius = 0.0;
  for (const auto& v : scan.vertices) radius = std::max(radius, (v - mass.p_O_M).norm());
  return std::make_shared<const ContactShape>(
      ContactShape{name, geometry->distance, geometry->samples, mass, radius, scan,
                   std::shared_ptr<const SurfaceFeatures>(geometry, geometry->features.get())});
}

void require_possible(const MassProperties& mass, const std::string& name) {
  const std::string problem = check(mass);
  require(problem.empty(), "stone ", name, ": ", problem);
}

}  // namespace

std::shared_ptr<const ContactShape> make_contact_shape(const Mesh& scan, const MassProperties& mass,
                                                       const std::string& name, const ShapeOptions& options) {
  require_possible(mass, name);
  return shape_of(scan, mass, name, shape_geometry(scan, options));
}

ShapeList make_contact_shapes(const std::vector<Stone>& stones) {
  return make_contact_shapes(stones, ShapeOptions{});
}

ShapeList make_contact_shapes(const std::vector<Stone>& stones, const ShapeOptions& options) {
  std::vector<std::shared_ptr<const ContactShape>> shapes(stones.size());
  tbb::parallel_for(std::size_t{0}, stones.size(), [&](std::size_t i) {
    throw_if_interrupted();
    shapes[i] = make_contact_shape(stones[i].scan, stones[i].mass, stones[i].name, options);
  });
  return shapes;
}

std::vector<std::shared_ptr<const ContactShape>> make_passing_shapes(const std::vector<Stone>& stones,
                                                                     const ShapeOptions& options) {
  std::vector<std::shared_ptr<const ContactShape>> shapes(stones.size());
  tbb::parallel_for(std::size_t{0}, stones.size(), [&](std::size_t i) {
    throw_if_interrupted();
    const Stone& stone = stones[i];
    require_possible(stone.mass, stone.name);
    shapes[i] = shape_of(stone.scan, stone.mass, stone.name, make_geometry(stone.scan, options));
  });
  return shapes;
}

std::vector<ShapeList> make_possible_shapes(const std::vector<Stone>& stones, int count) {
  if (std::none_of(stones.begin(), stones.end(), [](const Stone& s) { return s.surface.has_value(); }))
    return {};
  std::vector<ShapeList> draws(static_cast<std::size_t>(std::max(0, count)), ShapeList(stones.size()));
  tbb::parallel_for(std::size_t{0}, draws.size() * stones.size(), [&](std::size_t task) {
    throw_if_interrupted();
    const std::size_t draw = task / stones.size(), i = task % stones.size();
    if (!stones[i].surface) return;
    const Stone stone = stone::possible_stone(stones[i], static_cast<int>(draw));
    require_possible(stone.mass, stone.name);
    draws[draw][i] = shape_of(stone.scan, stone.mass, stone.name, make_geometry(stone.scan, kPossible));
  });
  return draws;
}

}  // namespace stonestack::physics
