#include "physics/block_assembly.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "geometry/json_file.hpp"

namespace stonestack::physics {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxBlocks = 10000;
constexpr std::size_t kMaxCorners = 20000;  // of a block
constexpr double kFacing = 0.9986;          // cos 3 deg: normals of faces that lie in one plane
constexpr double kMinArea = 1e-5;           // of the square of the smaller block's size: less is no interface

[[noreturn]] void fail(const std::string& path, const std::string& block, const std::string& problem,
                       const std::string& remedy) {
  throw FileError(path, concat("block ", block, ": ", problem), remedy);
}

/// The object that holds `node`, wherever an assembly's version puts it.
const json* graph_of(const json& document) {
  const json* at = &document;
  for (int depth = 0; depth < 6 && at->is_object(); ++depth) {
    if (at->contains("node") && at->at("node").is_object()) return at;
    if (at->contains("graph"))
      at = &at->at("graph");
    else if (at->contains("data"))
      at = &at->at("data");
    else
      break;
  }
  return nullptr;
}

/// The value under data, as often as values are wrapped.
const json& unwrapped(const json& value) {
  const json* at = &value;
  for (int depth = 0; depth < 4 && at->is_object() && at->contains("data"); ++depth) at = &at->at("data");
  return *at;
}

double coordinate(const std::string& path, const std::string& block, const json& vertex, const char* key) {
  if (!vertex.is_object() || !vertex.contains(key) || !vertex.at(key).is_number())
    fail(path, block, concat("a vertex has no number ", key), "give every vertex x, y and z");
  const double value = vertex.at(key).get<double>();
  if (!(std::abs(value) < 1e6)) fail(path, block, concat("a vertex has ", key, " = ", value), "correct it");
  return value;
}

/// Fan over a plane polygon from a corner from which no triangle turns over.
void triangulate(const std::vector<int>& corners, Mesh& mesh) {
  const auto n = corners.size();
  const auto p = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(corners[i % n])]; };
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i) normal += p(i).cross(p(i + 1));
  std::size_t first = 0;
  double best = -1e300;
  for (std::size_t s = 0; s < n; ++s) {
    double lowest = 1e300;
    for (std::size_t i = 1; i + 1 < n; ++i)
      lowest = std::min(lowest, (p(s + i) - p(s)).cross(p(s + i + 1) - p(s)).dot(normal));
    if (lowest > best * (1.0 + 1e-9) + 1e-300) best = lowest, first = s;
    if (n > 64) break;
  }
  for (std::size_t i = 1; i + 1 < n; ++i)
    mesh.faces.emplace_back(corners[first], corners[(first + i) % n], corners[(first + i + 1) % n]);
}

Mesh read_block_mesh(const std::string& path, const std::string& name, const json& node) {
  if (!node.is_object() || !node.contains("block") || !node.at("block").is_object())
    fail(path, name, "block is missing", "store the geometry of each block in the file");
  const json& data = unwrapped(node.at("block"));
  if (!data.is_object() || !data.contains("vertex") || !data.at("vertex").is_object() ||
      !data.contains("face") || !data.at("face").is_object())
    fail(path, name, "vertex or face is missing", "store the block as a COMPAS mesh");
  if (data.at("vertex").size() > kMaxCorners || data.at("face").size() > 2 * kMaxCorners)
    fail(path, name, concat("has ", data.at("vertex").size(), " vertices"),
         concat("simplify it to at most ", kMaxCorners));
  Mesh mesh;
  std::map<std::string, int> index;
  std::map<std::array<double, 3>, int> known;
  for (const auto& [key, vertex] : data.at("vertex").items()) {
    const std::array<double, 3> p{coordinate(path, name, vertex, "x"), coordinate(path, name, vertex, "y"),
                                  coordinate(path, name, vertex, "z")};
    const auto [at, fresh] = known.try_emplace(p, static_cast<int>(mesh.vertices.size()));
    if (fresh) mesh.vertices.emplace_back(p[0], p[1], p[2]);
    index[key] = at->second;
  }
  for (const auto& [key, face] : data.at("face").items()) {
    if (!face.is_array() || face.size() < 3)
      fail(path, name, concat("face ", key, " has no three corners"), "correct it");
    std::vector<int> corners;
    for (const json& corner : face) {
      const auto at = index.find(corner.is_string() ? corner.get<std::string>() : corner.dump());
      if (at == index.end())
        fail(path, name,
             concat("face ", key, " names vertex ", corner.dump().substr(0, 40), ", which is missing"),
             "correct it");
      if (corners.empty() || (corners.back() != at->second && corners.front() != at->second))
        corners.push_back(at->second);
    }
    if (corners.size() >= 3) triangulate(corners, mesh);
  }
  return mesh;
}

/// Makes the mesh point outwards.
void check_block(const std::string& path, const std::string& name, Mesh& mesh) {
  if (mesh.faces.empty() || !is_closed(mesh))
    fail(path, name, "is not closed: an edge has not exactly two faces with opposite directions",
         "repair the block");
  double enclosed = volume(mesh);
  if (enclosed < 0.0)
    for (Eigen::Vector3i& face : mesh.faces) std::swap(face[1], face[2]);
  enclosed = std::abs(enclosed);
  const double size = bounds(mesh).sizes().norm();
  if (!(enclosed > 1e-9 * size * size * size))
    fail(path, name, concat("its volume is ", enclosed), "give it one");
}

/// Nearest face of a block whose normal is along or against `n`: its outward normal.
Eigen::Vector3d outward_near(const Mesh& mesh, const std::vector<Eigen::Vector3d>& normals,
                             const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  double best = 1e300;
  Eigen::Vector3d out = n;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const double along = std::abs(normals[f].dot(n));
    if (along < 0.5) continue;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) centre += mesh.vertices[static_cast<std::size_t>(mesh.faces[f][i])] / 3.0;
    const double off = std::abs(normals[f].dot(p - centre));
    const double distance = (p - centre).norm() * (2.0 - along) + 10.0 * off;
    if (distance < best) best = distance, out = normals[f];
  }
  return out;
}

Eigen::Vector3d polygon_normal(const std::vector<Eigen::Vector3d>& corners) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  return 0.5 * sum;  // its length is the area
}

std::vector<Eigen::Vector3d> read_corners(const std::string& path, const std::string& edge,
                                          const json& interface) {
  const json& data = unwrapped(interface);
  std::vector<Eigen::Vector3d> corners;
  if (data.is_object() && data.contains("points") && data.at("points").is_array())
    for (const json& point : data.at("points")) {
      const json& p = unwrapped(point);
      if (!p.is_array() || p.size() != 3 || !p[0].is_number() || !p[1].is_number() || !p[2].is_number())
        throw FileError(path, concat("a point of interface ", edge, " is not three numbers"), "correct it");
      corners.emplace_back(p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
      if (!(corners.back().cwiseAbs().maxCoeff() < 1e6))
        throw FileError(path, concat("a point of interface ", edge, " is not finite"), "correct it");
    }
  if (corners.size() < 3 || corners.size() > 1000)
    throw FileError(path, concat("interface ", edge, " has ", corners.size(), " points"),
                    "give it three or more");
  return corners;
}

void read_interfaces(const std::string& path, const json& graph, const std::map<std::string, int>& index,
                     BlockAssembly& assembly) {
  if (!graph.contains("edge") || !graph.at("edge").is_object()) return;
  std::vector<std::vector<Eigen::Vector3d>> normals(assembly.blocks.size());
  for (const auto& [u, row] : graph.at("edge").items()) {
    if (!row.is_object()) continue;
    for (const auto& [v, edge] : row.items()) {
      if (!edge.is_object() || !edge.contains("interfaces") || !edge.at("interfaces").is_array()) continue;
      const std::string name = u + "-" + v;
      const auto a = index.find(u), b = index.find(v);
      if (a == index.end() || b == index.end() || a == b)
        throw FileError(path, concat("edge ", name, " names a block that is missing"), "correct it");
      for (const json& item : edge.at("interfaces")) {
        AssemblyInterface out;
        out.below = a->second;
        out.above = b->second;
        out.corners_W = read_corners(path, name, item);
        Eigen::Vector3d normal = polygon_normal(out.corners_W);
        if (!(normal.norm() > 1e-15)) continue;
        normal.normalize();
        const auto below = static_cast<std::size_t>(out.below);
        if (normals[below].empty()) normals[below] = face_normals(assembly.blocks[below].mesh);
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        for (const auto& c : out.corners_W) middle += c / static_cast<double>(out.corners_W.size());
        const Eigen::Vector3d outward =
            outward_near(assembly.blocks[below].mesh, normals[below], middle, normal);
        const auto box = bounds(assembly.blocks[below].mesh);
        if (box.exteriorDistance(middle) > 0.1 * box.sizes().norm())
          throw FileError(path, concat("interface ", name, " lies away from its blocks"), "correct it");
        out.n_W = outward.dot(normal) < 0.0 ? Eigen::Vector3d(-normal) : normal;
        assembly.interfaces.push_back(std::move(out));
      }
    }
  }
}

/// Part of a convex polygon inside a half plane n . p <= offset (Sutherland and Hodgman).
std::vector<Eigen::Vector3d> clipped(const std::vector<Eigen::Vector3d>& polygon, const Eigen::Vector3d& n,
                                     double offset) {
  std::vector<Eigen::Vector3d> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double a = n.dot(p) - offset, b = n.dot(q) - offset;
    if (a <= 0.0) out.push_back(p);
    if ((a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0)) out.push_back(p + a / (a - b) * (q - p));
  }
  return out;
}

struct Facet {
  Eigen::Vector3d corner[3], normal;
  Eigen::AlignedBox3d box;
};

struct FacetedBlock {
  std::vector<Facet> facets;
  Eigen::AlignedBox3d box;
  double size;
};

FacetedBlock faceted(const Mesh& mesh) {
  FacetedBlock out;
  const auto normals = face_normals(mesh);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    Facet facet;
    facet.normal = normals[f];
    if (facet.normal.norm() < 0.5) continue;
    for (int i = 0; i < 3; ++i) {
      facet.corner[i] = mesh.vertices[static_cast<std::size_t>(mesh.faces[f][i])];
      facet.box.extend(facet.corner[i]);
    }
    out.box.extend(facet.box);
    out.facets.push_back(facet);
  }
  out.size = std::cbrt(std::abs(volume(mesh)));
  return out;
}

bool near(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b, double gap) {
  return ((a.min() - b.max()).array() < gap).all() && ((b.min() - a.max()).array() < gap).all();
}

/// Intersection of two facets that face each other within `gap`, in the plane of the first.
std::vector<Eigen::Vector3d> overlap_of(const Facet& a, const Facet& b, double gap) {
  if (a.normal.dot(b.normal) > -kFacing || !near(a.box, b.box, gap)) return {};
  const double offset = a.normal.dot(a.corner[0]);
  std::vector<Eigen::Vector3d> polygon;
  for (const auto& corner : b.corner) {
    const double off = a.normal.dot(corner) - offset;
    if (std::abs(off) > gap) return {};
    polygon.push_back(corner - 0.5 * off * a.normal);
  }
  for (int i = 0; i < 3 && polygon.size() >= 3; ++i) {
    const Eigen::Vector3d out = (a.corner[(i + 1) % 3] - a.corner[i]).cross(a.normal);
    polygon = clipped(polygon, out.normalized(), out.normalized().dot(a.corner[i]));
  }
  return polygon;
}

/// Corners of the convex hull of points in a plane with normal `n`, in order, without those on its sides
/// (Andrew's monotone chain).
std::vector<Eigen::Vector3d> plane_hull(std::vector<Eigen::Vector3d> points, const Eigen::Vector3d& n,
                                        double size) {
  const Eigen::Vector3d u = n.unitOrthogonal(), v = n.cross(u);
  const double same = 1e-6 * size;
  std::sort(points.begin(), points.end(), [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    const double a = u.dot(p) - u.dot(q);
    return std::abs(a) > same ? a < 0.0 : v.dot(p) < v.dot(q);
  });
  std::vector<Eigen::Vector3d> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = hull.size();
    for (const Eigen::Vector3d& p : points) {
      while (hull.size() >= begin + 2) {
        const Eigen::Vector3d &a = hull[hull.size() - 2], &b = hull.back();
        if ((b - a).cross(p - b).dot(n) > same * (b - a).norm() && (p - b).norm() > same) break;
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// Joins the triangles of a pair of blocks in each plane to one polygon where they fill a convex one; the
/// share of a corner would else depend on how a face was cut into triangles.
void join_planes(std::vector<AssemblyInterface>& pair, double size, double gap) {
  std::vector<AssemblyInterface> out;
  std::vector<bool> used(pair.size(), false);
  for (std::size_t i = 0; i < pair.size(); ++i) {
    if (used[i]) continue;
    std::vector<std::size_t> group;
    std::vector<Eigen::Vector3d> points;
    double area = 0.0;
    for (std::size_t j = i; j < pair.size(); ++j) {
      const AssemblyInterface& other = pair[j];
      const Eigen::Vector3d off = other.corners_W.front() - pair[i].corners_W.front();
      if (used[j] || other.n_W.dot(pair[i].n_W) < 0.99999 || std::abs(off.dot(pair[i].n_W)) > gap) continue;
      group.push_back(j);
      area += polygon_normal(other.corners_W).norm();
      points.insert(points.end(), other.corners_W.begin(), other.corners_W.end());
    }
    AssemblyInterface whole = pair[i];
    whole.corners_W = plane_hull(points, whole.n_W, size);
    const double hull = whole.corners_W.size() < 3 ? 0.0 : polygon_normal(whole.corners_W).norm();
    if (!(std::abs(hull - area) < 1e-4 * area)) {
      out.push_back(pair[i]);
      continue;
    }
    for (const std::size_t j : group) used[j] = true;
    out.push_back(std::move(whole));
  }
  pair = std::move(out);
}

}  // namespace

BlockAssembly read_assembly(const std::string& path) {
  const json document = geometry::read_json(path);
  const json* graph = graph_of(document);
  if (!graph)
    throw FileError(path, "is no COMPAS assembly: it has no graph with nodes",
                    "write it with assembly.to_json() of compas_assembly");
  const json& nodes = graph->at("node");
  if (nodes.empty() || nodes.size() > kMaxBlocks)
    throw FileError(path, concat("has ", nodes.size(), " blocks"), concat("give it 1 to ", kMaxBlocks));
  BlockAssembly out;
  std::map<std::string, int> index;
  for (const auto& [name, node] : nodes.items()) {
    AssemblyBlock block;
    block.name = name.substr(0, 40);
    block.mesh = read_block_mesh(path, block.name, node);
    check_block(path, block.name, block.mesh);
    if (node.contains("is_support")) {
      if (!node.at("is_support").is_boolean())
        fail(path, block.name, "is_support is not true or false", "correct it");
      block.support = node.at("is_support").get<bool>();
    }
    index[name] = static_cast<int>(out.blocks.size());
    out.blocks.push_back(std::move(block));
  }
  read_interfaces(path, *graph, index, out);
  return out;
}

std::vector<AssemblyInterface> find_interfaces(const std::vector<AssemblyBlock>& blocks, double tolerance) {
  std::vector<FacetedBlock> faceted_blocks;
  for (const AssemblyBlock& block : blocks) faceted_blocks.push_back(faceted(block.mesh));
  std::vector<std::size_t> order(blocks.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return faceted_blocks[i].box.min().x() < faceted_blocks[j].box.min().x();
  });
  std::vector<AssemblyInterface> out;
  for (std::size_t p = 0; p < order.size(); ++p)
    for (std::size_t q = p + 1; q < order.size(); ++q) {
      const std::size_t i = std::min(order[p], order[q]), j = std::max(order[p], order[q]);
      const FacetedBlock &A = faceted_blocks[i], &B = faceted_blocks[j];
      const double size = std::min(A.size, B.size), gap = tolerance * size;
      if (faceted_blocks[order[q]].box.min().x() > faceted_blocks[order[p]].box.max().x() + gap) break;
      if (!near(A.box, B.box, gap)) continue;
      std::vector<AssemblyInterface> pair;
      for (const Facet& a : A.facets) {
        if (!near(a.box, B.box, gap)) continue;
        for (const Facet& b : B.facets) {
          auto corners = overlap_of(a, b, gap);
          if (corners.size() < 3 || polygon_normal(corners).norm() < kMinArea * size * size) continue;
          pair.push_back({static_cast<int>(i), static_cast<int>(j), std::move(corners), a.normal});
        }
      }
      join_planes(pair, size, gap);
      for (AssemblyInterface& face : pair) out.push_back(std::move(face));
    }
  return out;
}

AssemblyStatics statics_of(const BlockAssembly& assembly) {
  AssemblyStatics out;
  std::vector<int> body(assembly.blocks.size(), kTable);
  std::vector<double> size;
  for (std::size_t i = 0; i < assembly.blocks.size(); ++i) {
    const AssemblyBlock& block = assembly.blocks[i];
    size.push_back(bounds(block.mesh).sizes().norm());
    if (block.support) continue;
    const MassProperties mass = mass_properties(block.mesh, block.density);
    body[i] = static_cast<int>(out.bodies.size());
    out.bodies.push_back({mass.mass, mass.p_O_M});
    out.blocks.push_back(static_cast<int>(i));
  }
  double largest = 0.0;
  for (const AssemblyInterface& face : assembly.interfaces)
    largest = std::max(largest, polygon_normal(face.corners_W).norm());
  std::map<std::pair<int, int>, std::vector<std::size_t>> known;
  for (const AssemblyInterface& face : assembly.interfaces) {
    int below = body[static_cast<std::size_t>(face.below)],
        above = body[static_cast<std::size_t>(face.above)];
    if (below == above) continue;  // two supports
    Eigen::Vector3d n = face.n_W;
    if (above == kTable) std::swap(below, above), n = -n;
    const double area = std::max(polygon_normal(face.corners_W).norm(), 1e-4 * largest);
    const double merge = 1e-5 * std::min(size[static_cast<std::size_t>(face.below)],
                                         size[static_cast<std::size_t>(face.above)]);
    auto& mine = known[{face.below, face.above}];
    for (const Eigen::Vector3d& corner : face.corners_W) {
      const double share = area / static_cast<double>(face.corners_W.size());
      const auto same = std::find_if(mine.begin(), mine.end(), [&](std::size_t k) {
        const Contact& c = out.contacts[k].contact;
        return (c.p_W - corner).norm() < merge && c.n_W.dot(n) > kFacing;
      });
      if (same != mine.end()) {
        out.contacts[*same].stiffness += share;
        continue;
      }
      mine.push_back(out.contacts.size());
      out.contacts.push_back({{below, above, corner, n, 0.0, 0.0}, share});
    }
  }
  return out;
}

}  // namespace stonestack::physics
