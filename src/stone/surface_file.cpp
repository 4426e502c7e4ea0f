#include "stone/surface_file.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

using nlohmann::json;

constexpr const char* kSurfaceSchema = "stonestack.surface/1";
constexpr double kMaxSigma = 1.0;  // m
constexpr std::size_t kMaxAttitudes = 64;

Eigen::Vector3d unit_of(const json& j) {
  require(j.is_array() && j.size() == 3, "a direction needs three numbers");
  const Eigen::Vector3d up(j[0].get<double>(), j[1].get<double>(), j[2].get<double>());
  require(std::abs(up.norm() - 1.0) < 1e-3, "a direction has the length ", up.norm(), ", not 1");
  return up.normalized();
}

SurfaceKnowledge knowledge_of(const json& j, std::size_t vertices) {
  require(j.at("schema").get<std::string>() == kSurfaceSchema, "its schema is not ", kSurfaceSchema);
  SurfaceKnowledge surface;
  surface.sigma = j.at("sigma_m").get<std::vector<double>>();
  for (const json& seen : j.at("seen")) surface.seen.push_back(seen.get<double>() != 0.0 ? 1 : 0);
  require(surface.sigma.size() == vertices && surface.seen.size() == vertices, "it has ",
          surface.sigma.size(), " standard deviations and ", surface.seen.size(), " marks, scan.ply has ",
          vertices, " vertices");
  for (const double sigma : surface.sigma)
    require(sigma >= 0.0 && sigma <= kMaxSigma, "a standard deviation is ", sigma, " m");
  require(j.at("up_at_rest").size() <= kMaxAttitudes, "it has more than ", kMaxAttitudes, " attitudes");
  for (const json& up : j.at("up_at_rest")) surface.up_O_at_rest.push_back(unit_of(up));
  return surface;
}

}  // namespace

std::string surface_json(const SurfaceKnowledge& surface) {
  json j{{"schema", kSurfaceSchema}, {"sigma_m", json::array()}, {"seen", json::array()}};
  for (const double sigma : surface.sigma) j["sigma_m"].push_back(sigma);
  for (const char seen : surface.seen) j["seen"].push_back(seen != 0 ? 1 : 0);
  j["up_at_rest"] = json::array();
  for (const Eigen::Vector3d& up : surface.up_O_at_rest) j["up_at_rest"].push_back({up.x(), up.y(), up.z()});
  return j.dump() + "\n";
}

SurfaceKnowledge surface_of(const std::string& text, const std::string& path, std::size_t vertices) {
  std::string problem;
  try {
    return knowledge_of(json::parse(text), vertices);
  } catch (const json::exception& wrong) {
    problem = wrong.what();
  } catch (const InvalidArgument& wrong) {
    problem = wrong.what();
  }
  throw FileError(path, "does not say how well scan.ply is known: " + problem,
                  "model the stone anew, or remove the file: then all of the scan counts as seen");
}

}  // namespace stonestack::stone
