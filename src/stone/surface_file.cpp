#include "stone/surface_file.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/json_file.hpp"

namespace stonestack::stone {
namespace {

using nlohmann::json;

constexpr const char* kSurfaceSchema = "stonestack.surface/1";
constexpr const char* kModelAnew =
    "model the stone anew, or remove the file: then all of the scan counts as seen";
constexpr double kMaxSigma = 1.0;  // m
constexpr std::size_t kMaxAttitudes = 64;

Eigen::Vector3d unit_of(const json& direction, const std::string& path) {
  const std::vector<double> p = numbers_of({{"up_at_rest", direction}}, "up_at_rest", 3, path);
  const Eigen::Vector3d up(p[0], p[1], p[2]);
  if (!(std::abs(up.norm() - 1.0) < 1e-3))
    throw FileError(path, concat("up_at_rest has a direction of the length ", up.norm(), ", not 1"),
                    kModelAnew);
  return up.normalized();
}

}  // namespace

std::string surface_json(const SurfaceKnowledge& surface) {
  json j{{"schema", kSurfaceSchema}, {"sigma_m", surface.sigma}, {"seen", json::array()}};
  for (const char seen : surface.seen) j["seen"].push_back(seen != 0 ? 1 : 0);
  j["up_at_rest"] = json::array();
  for (const Eigen::Vector3d& up : surface.up_O_at_rest) j["up_at_rest"].push_back({up.x(), up.y(), up.z()});
  return j.dump() + "\n";
}

SurfaceKnowledge read_surface(const std::string& path, std::size_t vertices) {
  const json j = read_json(path);
  if (!j.is_object() || !j.contains("schema") || j["schema"] != kSurfaceSchema)
    throw FileError(path, concat("its schema is not ", kSurfaceSchema), kModelAnew);
  SurfaceKnowledge surface;
  surface.sigma = numbers_of(j, "sigma_m", vertices, path);
  for (const double sigma : surface.sigma)
    if (sigma < 0.0 || sigma > kMaxSigma)
      throw FileError(path, concat("a standard deviation is ", sigma, " m"), kModelAnew);
  const std::vector<double> seen = numbers_of(j, "seen", vertices, path);
  std::transform(seen.begin(), seen.end(), std::back_inserter(surface.seen),
                 [](double mark) { return static_cast<char>(mark != 0.0 ? 1 : 0); });
  if (!j.contains("up_at_rest") || !j["up_at_rest"].is_array() || j["up_at_rest"].size() > kMaxAttitudes)
    throw FileError(path, concat("up_at_rest is no list of at most ", kMaxAttitudes, " directions"),
                    kModelAnew);
  for (const json& up : j["up_at_rest"]) surface.up_O_at_rest.push_back(unit_of(up, path));
  return surface;
}

}  // namespace stonestack::stone
