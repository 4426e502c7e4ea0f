#include "modelling/surface_known.hpp"

#include <algorithm>

namespace stonestack::modelling {
namespace {

/// Are the vertices of the scan those of the model, one after the other?
bool same_vertices(const Stone& stone, const Mesh& model) {
  constexpr double kSame = 1e-6;  // m
  return std::equal(stone.scan.vertices.begin(), stone.scan.vertices.end(), model.vertices.begin(),
                    model.vertices.end(), [&](const Eigen::Vector3d& p_O, const Eigen::Vector3d& p) {
                      return (p_O - stone.T_O_file * p).norm() < kSame;
                    });
}

}  // namespace

std::optional<SurfaceKnowledge> surface_known(const Stone& stone, const ObjectModel& model,
                                              const std::vector<Eigen::Vector3d>& up_at_rest) {
  if (!same_vertices(stone, model.mesh)) return std::nullopt;
  SurfaceKnowledge known{model.sigma, model.seen, {}};
  for (const Eigen::Vector3d& up : up_at_rest)
    known.up_O_at_rest.push_back((stone.T_O_file.linear() * up).normalized());
  return known;
}

}  // namespace stonestack::modelling
