#include "stonestack/geometry/mesh.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::geometry {

// A closed surface is a signed sum of tetrahedra (o, a, b, c). With s = a + b + c and volume v, the first
// moment of one is v s / 4 and the second v (aa' + bb' + cc' + ss') / 20.
MassProperties mass_properties(const Mesh& mesh, double density) {
  require(density > 0.0 && std::isfinite(density), "density must be positive, got ", density, " kg/m^3");
  require(!mesh.faces.empty(), "a mesh without faces has no mass");
  const Eigen::Vector3d o = bounds(mesh).center();  // near the body, so that few digits cancel
  double total_volume = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3i& face : mesh.faces) {
    const Eigen::Vector3d a = mesh.vertices[static_cast<std::size_t>(face[0])] - o;
    const Eigen::Vector3d b = mesh.vertices[static_cast<std::size_t>(face[1])] - o;
    const Eigen::Vector3d c = mesh.vertices[static_cast<std::size_t>(face[2])] - o;
    const Eigen::Vector3d s = a + b + c;
    const double v = a.dot(b.cross(c)) / 6.0;
    total_volume += v;
    first += v / 4.0 * s;
    second += v / 20.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }
  require(total_volume > 0.0, "the volume of a body must be positive, got ", total_volume,
          " m^3 (faces inside out, or not closed)");
  const Eigen::Vector3d centre = first / total_volume;
  const Eigen::Matrix3d about_centre = second - total_volume * centre * centre.transpose();
  MassProperties result;
  result.mass = density * total_volume;
  result.p_O_M = o + centre;
  result.I_M = density * (about_centre.trace() * Eigen::Matrix3d::Identity() - about_centre);
  return result;
}

std::string check(const MassProperties& properties) {
  const Eigen::Matrix3d& inertia = properties.I_M;
  if (!std::isfinite(properties.mass) || !properties.p_O_M.allFinite() || !inertia.allFinite())
    return "a mass property is not finite";
  if (properties.mass <= 0.0) return concat("mass must be positive, got ", properties.mass, " kg");
  const double scale = inertia.cwiseAbs().maxCoeff();
  if ((inertia - inertia.transpose()).cwiseAbs().maxCoeff() > 1e-9 * scale) return "inertia is not symmetric";
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  if (moments[0] <= 0.0)
    return concat("inertia is not positive definite: principal moments ", moments.transpose(), " kg m^2");
  if (moments[0] + moments[1] < moments[2] * (1.0 - 1e-9))
    return concat("inertia breaks the triangle inequality: principal moments ", moments.transpose(),
                  " kg m^2");
  return "";
}

}  // namespace stonestack::geometry
