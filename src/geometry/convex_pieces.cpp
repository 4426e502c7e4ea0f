#include "stonestack/geometry/convex_pieces.hpp"

#include <HACD/hacdHACD.h>

#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kMaxFaces = 4000;  // the cost grows faster than linearly: 1 s for 1000
constexpr double kMaxConcavity = 4000.0;

std::vector<Mesh> decompose(const Mesh& mesh, double concavity, int max_vertices) {
  std::vector<HACD::Vec3<HACD::Real>> points;
  std::vector<HACD::Vec3<long>> triangles;
  for (const Eigen::Vector3d& p : mesh.vertices) points.emplace_back(p.x(), p.y(), p.z());
  for (const Eigen::Vector3i& f : mesh.faces) triangles.emplace_back(f[0], f[1], f[2]);
  HACD::HACD hacd;
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetCompacityWeight(0.1);
  hacd.SetVolumeWeight(0.0);
  hacd.SetNClusters(1);
  hacd.SetConcavity(concavity);
  hacd.SetNVerticesPerCH(static_cast<std::size_t>(max_vertices));
  hacd.SetAddExtraDistPoints(true);
  hacd.SetAddNeighboursDistPoints(false);
  hacd.SetAddFacesPoints(true);
  hacd.Compute();
  std::vector<Mesh> pieces;
  for (std::size_t c = 0; c < hacd.GetNClusters(); ++c) {
    std::vector<HACD::Vec3<HACD::Real>> corners(hacd.GetNPointsCH(c));
    std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(c));
    if (corners.size() < 4) continue;
    hacd.GetCH(c, corners.data(), faces.data());
    Mesh cloud;
    for (const auto& p : corners) cloud.vertices.emplace_back(p.X(), p.Y(), p.Z());
    try {
      pieces.push_back(convex_hull(cloud));
    } catch (const InvalidArgument&) {
      continue;  // flat: it encloses nothing
    }
  }
  return pieces;
}

}  // namespace

std::vector<Mesh> convex_pieces(const Mesh& mesh, const ConvexPiecesOptions& options) {
  require(options.max_pieces >= 1, "convex pieces: at least one, got ", options.max_pieces);
  require(options.max_vertices >= 4, "a convex piece has at least 4 vertices, got ", options.max_vertices);
  require(options.concavity > 0.0, "concavity must be positive, got ", options.concavity);
  require(is_closed(mesh), "convex pieces need a closed mesh");
  require(mesh.faces.size() <= kMaxFaces, "convex pieces take at most ", kMaxFaces, " faces, got ",
          mesh.faces.size(), "; reduce the mesh first");
  // HACD measures concavity in thousandths of the size; it sees a mesh of about 1 m best.
  const Eigen::AlignedBox3d box = bounds(mesh);
  const double size = box.diagonal().norm();
  const Mesh unit = scaled(transformed(mesh, make_pose(-box.center())), 1.0 / size);
  for (double concavity = options.concavity; concavity <= kMaxConcavity; concavity *= 2.0) {
    throw_if_interrupted();
    std::vector<Mesh> pieces = decompose(unit, concavity, options.max_vertices);
    if (pieces.empty() || pieces.size() > static_cast<std::size_t>(options.max_pieces)) continue;
    for (Mesh& piece : pieces) piece = transformed(scaled(piece, size), make_pose(box.center()));
    return pieces;
  }
  return {convex_hull(mesh)};
}

}  // namespace stonestack::geometry
