#include "stonestack/physics/shape.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "physics/shape_store.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {

std::shared_ptr<const ContactShape> make_contact_shape(const Mesh& scan, const MassProperties& mass,
                                                       const std::string& name, const ShapeOptions& options) {
  const std::string problem = check(mass);
  require(problem.empty(), "stone ", name, ": ", problem);
  double radius = 0.0;
  for (const auto& v : scan.vertices) radius = std::max(radius, (v - mass.p_O_M).norm());
  const auto geometry = shape_geometry(scan, options);
  return std::make_shared<const ContactShape>(
      ContactShape{name, geometry->distance, geometry->samples, mass, radius, scan, geometry->features});
}

std::vector<std::shared_ptr<const ContactShape>> make_contact_shapes(const std::vector<Stone>& stones,
                                                                     const ShapeOptions& options) {
  std::vector<std::shared_ptr<const ContactShape>> shapes(stones.size());
  tbb::parallel_for(std::size_t{0}, stones.size(), [&](std::size_t i) {
    throw_if_interrupted();
    shapes[i] = make_contact_shape(stones[i].scan, stones[i].mass, stones[i].name, options);
  });
  return shapes;
}

}  // namespace stonestack::physics
