#include "physics/mesh_contact.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/mesh_edges.hpp"

namespace stonestack::physics {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kMotion = 5e-4;    // m: what any point may move before pairs are listed again
constexpr double kTilt = 0.01;      // rad: the same, turn
constexpr double kDepth = 1e-3;     // m: depth that is looked for, unless the bodies are deeper or faster
constexpr double kMaxDepth = 0.01;  // m: deeper they are taken for passed through each other
constexpr double kBeside = 1e-5;    // m: beside a face or beyond the end of an edge that still touches
constexpr double kAngle = 0.02;     // sine: how far a direction may be outside what a vertex or edge leads in
constexpr double kFlatEdge = 1e-3;  // sine: edges closer to flat do not count as convex
constexpr double kAlongside = 0.005;  // sine between edges: below it their ends carry
constexpr double kSure = 5e-5;        // m: shallower touches are taken as they are

constexpr int kVertexOfA = 0, kVertexOfB = 1, kEdges = 2;

std::size_t slot(int i) {
  return static_cast<std::size_t>(i);
}

/// The foot of the point on the face's plane lies on the face, or less than `beyond` beside it.
bool is_over(const ContactMesh& mesh, int face, const Vector& p, double beyond) {
  const Vector& n = mesh.normals[slot(face)];
  for (int k = 0; k < 3; ++k) {
    const Vector& from = mesh.vertices[slot(mesh.faces[slot(face)][k])];
    const Vector along = mesh.vertices[slot(mesh.faces[slot(face)][(k + 1) % 3])] - from;
    if (n.cross(along).dot(p - from) < -beyond * along.norm()) return false;
  }
  return true;
}

double height_over(const ContactMesh& mesh, int face, const Vector& p) {
  return mesh.normals[slot(face)].dot(p - mesh.vertices[slot(mesh.faces[slot(face)][0])]);
}

/// No neighbour of the vertex lies further in direction -n.
bool leads_against(const ContactMesh& mesh, int vertex, const Vector& n, double sine) {
  const Vector& p = mesh.vertices[slot(vertex)];
  return std::all_of(mesh.neighbours[slot(vertex)].begin(), mesh.neighbours[slot(vertex)].end(), [&](int k) {
    const Vector along = mesh.vertices[slot(k)] - p;
    return along.dot(n) >= -sine * along.norm();
  });
}

/// Height of a vertex of X over a face of Y, where it may be the first to touch it, within `slack` and
/// `turn`.
std::optional<double> gap_of(const ContactMesh& X, int vertex, const Pose& T_Y_X, const ContactMesh& Y,
                             int face, double max_gap, double max_depth, double slack, double turn) {
  const Vector p = T_Y_X * X.vertices[slot(vertex)];
  const double gap = height_over(Y, face, p);
  if (gap > max_gap + slack || gap < -max_depth - slack) return {};
  if (!is_over(Y, face, p, kBeside + slack + std::abs(gap))) return {};
  const Vector n_X = T_Y_X.linear().transpose() * Y.normals[slot(face)];
  if (!leads_against(X, vertex, n_X, kAngle + turn)) return {};
  return gap;
}

struct Foot {
  int face;
  double gap;
};

/// Below a ridge a point is below both of its faces, and the nearer one is what it came through. In a valley
/// it touches both. Several faces of one plane count once.
std::vector<Foot> true_feet(const ContactMesh& mesh, std::vector<Foot> feet) {
  std::sort(feet.begin(), feet.end(), [](const Foot& s, const Foot& t) {
    return std::pair(-s.gap, s.face) < std::pair(-t.gap, t.face);
  });
  std::vector<Foot> kept;
  for (const Foot& foot : feet) {
    const Vector& n = mesh.normals[slot(foot.face)];
    const bool false_depth = std::any_of(kept.begin(), kept.end(), [&](const Foot& other) {
      if (mesh.normals[slot(other.face)].dot(n) > 0.9999) return true;
      if (-foot.gap < kSure + 2.0 * std::abs(other.gap)) return false;
      const Eigen::Vector3i& f = mesh.faces[slot(foot.face)];
      const Vector middle =
          (mesh.vertices[slot(f[0])] + mesh.vertices[slot(f[1])] + mesh.vertices[slot(f[2])]) / 3.0;
      return height_over(mesh, other.face, middle) < 0.0;
    });
    if (!false_depth) kept.push_back(foot);
  }
  return kept;
}

struct PlacedEdge {
  Vector p, d;
};
PlacedEdge place(const ConvexEdge& edge, const Pose& T_B_A) {
  return {T_B_A * edge.p, T_B_A.linear() * edge.d};
}

/// Distance of two segments, about: at least half of it, and exact where they cross inside.
bool are_near(const PlacedEdge& a, double length_a, const ConvexEdge& b, double reach) {
  const Vector r = b.p - a.p;
  const double cosine = a.d.dot(b.d), along_a = a.d.dot(r), along_b = b.d.dot(r);
  const double sine2 = 1.0 - cosine * cosine;
  double s = sine2 > 1e-9 ? (along_a - cosine * along_b) / sine2 : 0.0;
  s = std::clamp(s, 0.0, length_a);
  const double t = std::clamp(s * cosine - along_b, 0.0, b.length);
  s = std::clamp(t * cosine + along_a, 0.0, length_a);
  return (a.p + s * a.d - b.p - t * b.d).squaredNorm() <= reach * reach;
}

/// The direction -n is one that the edge leads in.
bool edge_leads(const ConvexEdge& edge, const Vector& n, double sine) {
  return edge.into[0].dot(n) >= -sine && edge.into[1].dot(n) >= -sine;
}

/// Unit direction from b to a in which two crossing edges touch; zero if they are parallel.
Vector direction_between(const ContactMesh& A, const ConvexEdge& a, const Vector& d_B,
                         const Eigen::Matrix3d& R_B_A, const ContactMesh& B, const ConvexEdge& b) {
  const Vector across = d_B.cross(b.d);
  const double sine = across.norm();
  if (sine < kAlongside) return Vector::Zero();
  const Vector outward_b = B.normals[slot(b.faces[0])] + B.normals[slot(b.faces[1])];
  const Vector outward_a = R_B_A * (A.normals[slot(a.faces[0])] + A.normals[slot(a.faces[1])]);
  return across.dot(outward_b - outward_a) < 0.0 ? Vector(-across / sine) : Vector(across / sine);
}

/// A face of another plane than those at the edge is much nearer to the point: it did not come in through the
/// edge.
bool came_elsewhere(const ContactMesh& mesh, const ConvexEdge& edge, const Vector& p, double depth) {
  for (int f = 0; f < static_cast<int>(mesh.faces.size()); ++f) {
    const Vector& n = mesh.normals[slot(f)];
    if (std::abs(height_over(mesh, f, p)) > 0.5 * depth || n.isZero()) continue;
    const bool of_edge = std::any_of(edge.faces.begin(), edge.faces.end(),
                                     [&](int own) { return mesh.normals[slot(own)].dot(n) > 0.98; });
    if (!of_edge && is_over(mesh, f, p, kBeside)) return true;
  }
  return false;
}

/// Touch of edge a of A and edge b of B, in B; none if they do not cross as the first to touch.
std::optional<MeshTouch> cross_edges(const ContactMesh& A, int a, const PlacedEdge& placed, const Pose& T_B_A,
                                     const ContactMesh& B, int b, double max_gap, double max_depth) {
  const ConvexEdge& own = A.edges[slot(a)];
  const ConvexEdge& other = B.edges[slot(b)];
  const Vector r = other.p - placed.p;
  const Vector across = placed.d.cross(other.d);
  const double sine2 = across.squaredNorm();
  if (sine2 < kAlongside * kAlongside) return {};
  const double offset = across.dot(r);  // the gap times the sine, but for its sign
  const double limit = std::max(max_gap, max_depth);
  if (offset * offset > limit * limit * sine2) return {};
  const double s = r.cross(other.d).dot(across) / sine2;
  const double t = r.cross(placed.d).dot(across) / sine2;
  if (s < -kBeside || s > own.length + kBeside || t < -kBeside || t > other.length + kBeside) return {};
  const Vector n = direction_between(A, own, placed.d, T_B_A.linear(), B, other);
  const double gap = -n.dot(r);
  if (gap > max_gap || gap < -max_depth) return {};
  const Vector n_A = T_B_A.linear().transpose() * n;
  if (!edge_leads(own, n_A, kAngle) || !edge_leads(other, -n, kAngle)) return {};
  const Vector p_a = placed.p + s * placed.d, p_b = other.p + t * other.d;
  if (gap < -kSure &&
      (came_elsewhere(B, other, p_a, -gap) || came_elsewhere(A, own, T_B_A.inverse() * p_b, -gap)))
    return {};
  return MeshTouch{{kEdges, a, b}, 0.5 * (p_a + p_b), n, gap};
}

/// Largest shift of a point within `radius` of A's origin, and A's turn.
struct Motion {
  double shift, turn;
};
Motion motion_between(const Pose& before, const Pose& now, double radius) {
  const double turn = std::sqrt(std::max(0.0, 3.0 - (before.linear().transpose() * now.linear()).trace()));
  return {(now.translation() - before.translation()).norm() + turn * radius, turn};
}

struct FaceBox {
  Eigen::AlignedBox3d box;
  int face;
};

/// Boxes of the faces that reach into `region`, from the lowest x.
std::vector<FaceBox> faces_within(const ContactMesh& mesh, const std::vector<Vector>& vertices,
                                  const Eigen::AlignedBox3d& region) {
  std::vector<FaceBox> found;
  for (int f = 0; f < static_cast<int>(mesh.faces.size()); ++f) {
    if (mesh.normals[slot(f)].isZero()) continue;
    FaceBox entry{{}, f};
    for (int k = 0; k < 3; ++k) entry.box.extend(vertices[slot(mesh.faces[slot(f)][k])]);
    if (region.intersects(entry.box)) found.push_back(entry);
  }
  std::sort(found.begin(), found.end(), [](const FaceBox& s, const FaceBox& t) {
    return std::pair(s.box.min().x(), s.face) < std::pair(t.box.min().x(), t.face);
  });
  return found;
}

Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& box, double by) {
  return {box.min() - Vector::Constant(by), box.max() + Vector::Constant(by)};
}

template <class T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// Pairs of faces whose boxes come within `reach`, in the frame of B.
template <class Visit>
void visit_near_faces(const ContactMesh& A, const ContactMesh& B, const Pose& T_B_A, double reach,
                      const Visit& visit) {
  std::vector<Vector> moved;
  Eigen::AlignedBox3d box_a, box_b;
  for (const Vector& v : A.vertices) box_a.extend(moved.emplace_back(T_B_A * v));
  for (const Vector& v : B.vertices) box_b.extend(v);
  const Eigen::AlignedBox3d shared = grown(box_a, reach).intersection(grown(box_b, reach));
  if (shared.isEmpty()) return;
  const std::vector<FaceBox> of_a = faces_within(A, moved, shared),
                             of_b = faces_within(B, B.vertices, shared);
  double widest = 0.0;
  for (const FaceBox& b : of_b) widest = std::max(widest, b.box.sizes().x());
  for (const FaceBox& a : of_a) {
    const Eigen::AlignedBox3d near = grown(a.box, reach);
    auto b = std::lower_bound(of_b.begin(), of_b.end(), near.min().x() - widest,
                              [](const FaceBox& s, double x) { return s.box.min().x() < x; });
    for (; b != of_b.end() && b->box.min().x() <= near.max().x(); ++b)
      if (near.intersects(b->box)) visit(a.face, b->face);
  }
}

void add_vertex_touches(const ContactMesh& X, const ContactMesh& Y, int vertex, const Pose& T_W_X,
                        const Pose& T_W_Y, const std::vector<Foot>& feet, bool of_a,
                        std::vector<MeshTouch>& out) {
  for (const Foot& foot : true_feet(Y, feet)) {
    const Vector n_W = T_W_Y.linear() * Y.normals[slot(foot.face)];
    const std::array<int, 3> features =
        of_a ? std::array{kVertexOfA, vertex, foot.face} : std::array{kVertexOfB, foot.face, vertex};
    out.push_back({features, T_W_X * X.vertices[slot(vertex)], of_a ? n_W : Vector(-n_W), foot.gap});
  }
}

}  // namespace

ContactMesh make_contact_mesh(const Mesh& mesh) {
  ContactMesh out;
  out.vertices = mesh.vertices;
  out.faces = mesh.faces;
  out.normals = face_normals(mesh);
  out.neighbours.resize(mesh.vertices.size());
  for (const Vector& v : mesh.vertices) out.radius = std::max(out.radius, v.norm());
  const MeshEdges edges = make_mesh_edges(mesh);
  std::vector<ConvexEdge> all(edges.edges.size());
  for (std::size_t e = 0; e < all.size(); ++e) {
    const auto [a, b] = std::pair(edges.edges[e].a, edges.edges[e].b);
    out.neighbours[slot(a)].push_back(b);
    out.neighbours[slot(b)].push_back(a);
    all[e].p = mesh.vertices[slot(a)];
    all[e].d = mesh.vertices[slot(b)] - all[e].p;
    all[e].length = all[e].d.norm();
    all[e].d /= all[e].length;
  }
  for (int f = 0; f < static_cast<int>(mesh.faces.size()); ++f)
    for (int k = 0; k < 3; ++k) {
      ConvexEdge& edge = all[slot(edges.of_face[slot(f)][slot(k)])];
      const bool forward = mesh.faces[slot(f)][k] < mesh.faces[slot(f)][(k + 1) % 3];
      const Vector& n = out.normals[slot(f)];
      const int side = edge.faces[0] < 0 ? 0 : 1;
      edge.faces[slot(side)] = f;
      edge.into[slot(side)] = forward ? n.cross(edge.d) : edge.d.cross(n);
    }
  std::vector<int> number(all.size(), -1);
  for (std::size_t e = 0; e < all.size(); ++e) {
    const ConvexEdge& edge = all[e];
    if (edge.faces[1] < 0 || out.normals[slot(edge.faces[0])].dot(edge.into[1]) > -kFlatEdge) continue;
    number[e] = static_cast<int>(out.edges.size());
    out.edges.push_back(edge);
  }
  out.edges_of_face.resize(mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) out.edges_of_face[f][k] = number[slot(edges.of_face[f][k])];
  return out;
}

void MeshPair::refresh(const ContactMesh& A, const ContactMesh& B, const Pose& T_B_A, double depth) {
  fresh_ = true;
  T_listed_ = T_B_A;
  listed_depth_ = depth;
  vertices_of_a_.clear();
  vertices_of_b_.clear();
  edges_.clear();
  const Pose T_A_B = T_B_A.inverse();
  std::vector<Pair> of_a, of_b, of_edges;
  visit_near_faces(A, B, T_B_A, depth + kMotion, [&](int a, int b) {
    for (std::size_t k = 0; k < 3; ++k) {
      of_a.push_back({A.faces[slot(a)][static_cast<int>(k)], b});
      of_b.push_back({B.faces[slot(b)][static_cast<int>(k)], a});
      if (A.edges_of_face[slot(a)][k] < 0) continue;
      for (const int e : B.edges_of_face[slot(b)])
        if (e >= 0) of_edges.push_back({A.edges_of_face[slot(a)][k], e});
    }
  });
  for (auto* list : {&of_a, &of_b, &of_edges}) sort_unique(*list);
  for (const Pair& p : of_a)
    if (gap_of(A, p.a, T_B_A, B, p.b, 0.0, depth, kMotion, kTilt)) vertices_of_a_.push_back(p);
  for (const Pair& p : of_b)
    if (gap_of(B, p.a, T_A_B, A, p.b, 0.0, depth, kMotion, kTilt)) vertices_of_b_.push_back(p);
  for (const Pair& p : of_edges) {
    const ConvexEdge& a = A.edges[slot(p.a)];
    if (are_near(place(a, T_B_A), a.length, B.edges[slot(p.b)], depth + kMotion)) edges_.push_back(p);
  }
}

std::vector<MeshTouch> MeshPair::touches(const ContactMesh& A, const ContactMesh& B, const Pose& T_W_A,
                                         const Pose& T_W_B, double max_gap) {
  const Pose T_B_A = T_W_B.inverse() * T_W_A, T_A_B = T_B_A.inverse();
  const double step = fresh_ ? motion_between(T_last_, T_B_A, A.radius).shift : 0.0;
  const double depth = std::min(kMaxDepth, std::max({kDepth, 2.0 * step, 2.0 * deepest_}));
  const Motion since = motion_between(T_listed_, T_B_A, A.radius);
  if (!fresh_ || since.shift > kMotion - max_gap || since.turn > kTilt || depth > listed_depth_)
    refresh(A, B, T_B_A, depth);
  T_last_ = T_B_A;
  std::vector<MeshTouch> out;
  std::vector<Foot> feet;
  const auto stand = [&](const ContactMesh& X, const ContactMesh& Y, const Pose& T_Y_X,
                         const std::vector<Pair>& pairs, bool of_a) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (const auto gap = gap_of(X, pairs[i].a, T_Y_X, Y, pairs[i].b, max_gap, depth, 0.0, 0.0))
        feet.push_back({pairs[i].b, *gap});
      if (i + 1 < pairs.size() && pairs[i + 1].a == pairs[i].a) continue;
      add_vertex_touches(X, Y, pairs[i].a, of_a ? T_W_A : T_W_B, of_a ? T_W_B : T_W_A, feet, of_a, out);
      feet.clear();
    }
  };
  stand(A, B, T_B_A, vertices_of_a_, true);
  stand(B, A, T_A_B, vertices_of_b_, false);
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const PlacedEdge placed = place(A.edges[slot(edges_[i].a)], T_B_A);
    if (auto touch = cross_edges(A, edges_[i].a, placed, T_B_A, B, edges_[i].b, max_gap, depth)) {
      touch->p = T_W_B * touch->p;
      touch->n = T_W_B.linear() * touch->n;
      out.push_back(*touch);
    }
  }
  deepest_ = 0.0;
  for (const MeshTouch& touch : out) deepest_ = std::max(deepest_, -touch.gap);
  return out;
}

std::vector<MeshTouch> plane_touches(const ContactMesh& mesh, const Pose& T_W_A, const Vector& n_W,
                                     double offset, double max_gap) {
  const Vector n_A = T_W_A.linear().transpose() * n_W;
  const double up = n_W.dot(T_W_A.translation()) - offset;
  std::vector<MeshTouch> out;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double gap = n_A.dot(mesh.vertices[v]) + up;
    if (gap <= max_gap)
      out.push_back({{kVertexOfA, static_cast<int>(v), 0}, T_W_A * mesh.vertices[v], n_W, gap});
  }
  return out;
}

}  // namespace stonestack::physics
