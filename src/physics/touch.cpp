#include "physics/touch.hpp"

#include <algorithm>
#include <optional>

#include "physics/first_touch.hpp"

namespace stonestack::physics {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kDeep = 0.0025;      // m: vertices at least as deep touch by the signed distance too
constexpr double kNearSlack = 2e-4;   // m: motion after which those that may touch soon are chosen again
constexpr double kNearTurn = 0.002;   // rad: the same
constexpr double kSecondOrder = 1.5;  // what crossing edges may move and turn more than the bodies
constexpr double kParallel = 0.02;    // sine between edges: below it their ends touch, not they
constexpr std::size_t kMaxDeep = 8;   // deep touches a body

void add_deep(const Surface& X, const Surface& Y, const Pose& T_W_X, const Pose& T_Y_X, const Pose& T_W_Y,
              const std::vector<int>& deep, bool swapped, std::vector<Touch>& out) {
  std::vector<Touch> found;
  for (const int v : deep) {
    const Vector& p_X = X.features->vertices[static_cast<std::size_t>(v)];
    Vector n_Y;
    const double gap = signed_distance(Y, T_Y_X * p_X, &n_Y);
    if (gap > -kDeep) continue;
    if (n_Y.isZero()) n_Y = (T_Y_X * p_X - Y.features->box.center()).normalized();  // too deep to tell
    Touch t;
    t.kind = swapped ? TouchKind::kDeepB : TouchKind::kDeepA;
    (swapped ? t.b : t.a) = v;
    t.gap = gap;
    const Vector n_W = T_W_Y.linear() * n_Y;
    t.n_W = swapped ? Vector(-n_W) : n_W;
    t.p_W = T_W_X * p_X;
    if (!swapped) t.p_W -= gap * t.n_W;
    found.push_back(t);
  }
  std::stable_sort(found.begin(), found.end(), [](const Touch& a, const Touch& b) { return a.gap < b.gap; });
  if (found.size() > kMaxDeep) found.resize(kMaxDeep);
  out.insert(out.end(), found.begin(), found.end());
}

/// Near a rim a point just below one face may be read as far below another. The signed distance tells: such
/// a touch is dropped where a shallower one of another direction lies close by.
void drop_false_depths(std::vector<Touch>& touches, const Surface& B, const Pose& T_W_B) {
  const auto is_false = [&](const Touch& t) {
    if (t.gap > -5e-5 || t.kind == TouchKind::kDeepA || t.kind == TouchKind::kDeepB) return false;
    const bool rival = std::any_of(touches.begin(), touches.end(), [&](const Touch& o) {
      return o.gap > 0.5 * t.gap && o.n_W.dot(t.n_W) < 0.9 && (o.p_W - t.p_W).squaredNorm() < 1.6e-5;
    });
    return rival && signed_distance(B, T_W_B.inverse() * (t.p_W + t.gap * t.n_W), nullptr) > 0.5 * t.gap;
  };
  std::vector<Touch> kept;
  for (const Touch& t : touches)
    if (!is_false(t)) kept.push_back(t);
  touches = std::move(kept);
}

/// A vertex on the seam of two faces of one plane touches once.
void drop_twins(std::vector<Touch>& touches) {
  std::vector<Touch> kept;
  for (const Touch& t : touches) {
    const bool twin = std::any_of(kept.begin(), kept.end(), [&](const Touch& o) {
      return o.n_W.dot(t.n_W) > 0.9999 && (o.p_W - t.p_W).squaredNorm() < 1e-10;
    });
    if (!twin) kept.push_back(t);
  }
  touches = std::move(kept);
}

}  // namespace

double signed_distance(const Surface& surface, const Vector& p, Vector* gradient) {
  if (surface.distance) {
    return gradient ? surface.distance->distance(p, gradient) : surface.distance->distance(p);
  }
  const Vector q = p.cwiseAbs() - surface.half;
  const Vector outside = q.cwiseMax(0.0);
  if (outside.squaredNorm() > 0) {
    if (gradient) *gradient = (outside.array() * p.array().sign()).matrix().normalized();
    return outside.norm();
  }
  int axis = 0;
  const double depth = q.maxCoeff(&axis);
  if (gradient) *gradient = Vector::Unit(axis) * (p[axis] < 0 ? -1.0 : 1.0);
  return depth;
}

std::vector<Touch> FeaturePairs::touches(const Surface& A, const Surface& B, const Pose& T_W_A,
                                         const Pose& T_W_B) {
  const Pose T_B_A = T_W_B.inverse() * T_W_A;
  const double radius = radius_about_origin(*A.features);
  const bool stale = !fresh_ || moved_enough(T_B_A_, T_B_A, radius, kSlack, kTurn);
  if (stale) refresh(A, B, T_B_A);
  if (stale || moved_enough(T_near_, T_B_A, radius, kNearSlack, kNearTurn)) choose_near(A, B, T_B_A);
  const Pose T_A_B = T_B_A.inverse();
  std::vector<Touch> out;
  Vector p;
  double gap = 0.0;
  for (const Pair& pair : near_.vertices_of_a) {
    const FaceFeature& face = B.features->faces[static_cast<std::size_t>(pair.b)];
    if (!vertex_on_face(*A.features, pair.a, T_B_A, face, &p, &gap)) continue;
    out.push_back({TouchKind::kVertexOfA, pair.a, pair.b, T_W_B * (p - gap * face.n), T_W_B.linear() * face.n,
                   gap, Vector::Zero()});
  }
  for (const Pair& pair : near_.vertices_of_b) {
    const FaceFeature& face = A.features->faces[static_cast<std::size_t>(pair.a)];
    if (!vertex_on_face(*B.features, pair.b, T_A_B, face, &p, &gap)) continue;
    out.push_back(
        {TouchKind::kVertexOfB, pair.a, pair.b, T_W_A * p, -(T_W_A.linear() * face.n), gap, Vector::Zero()});
  }
  for (const Pair& pair : near_.edges) {
    const EdgeFeature a = moved(A.features->edges[static_cast<std::size_t>(pair.a)], T_B_A);
    const Crossing c = cross(a, B.features->edges[static_cast<std::size_t>(pair.b)], kRim, kCone, kParallel);
    if (!c.valid || c.gap > kTouchGap || c.gap < -kDeepest) continue;
    out.push_back(
        {TouchKind::kEdges, pair.a, pair.b, T_W_B * c.p_b, T_W_B.linear() * c.n, c.gap, Vector::Zero()});
  }
  add_deep(A, B, T_W_A, T_B_A, T_W_B, deep_a_, false, out);
  add_deep(B, A, T_W_B, T_A_B, T_W_A, deep_b_, true, out);
  drop_false_depths(out, B, T_W_B);
  drop_twins(out);
  const Pose T_A_W = T_W_A.inverse();
  for (Touch& t : out) t.p_A = T_A_W * t.p_W;
  return out;
}

void FeaturePairs::refresh(const Surface& A, const Surface& B, const Pose& T_B_A) {
  fresh_ = true;
  T_B_A_ = T_B_A;
  for (auto* list : {&all_.vertices_of_a, &all_.vertices_of_b, &all_.edges}) list->clear();
  deep_a_.clear();
  deep_b_.clear();
  look_up(A, B, T_B_A, false);
  look_up(B, A, T_B_A.inverse(), true);
  for (auto* list : {&all_.vertices_of_a, &all_.vertices_of_b, &all_.edges}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
}

void FeaturePairs::choose_near(const Surface& A, const Surface& B, const Pose& T_B_A) {
  T_near_ = T_B_A;
  const Pose T_A_B = T_B_A.inverse();
  Vector p;
  double gap = 0.0;
  near_ = {};
  for (const Pair& pair : all_.vertices_of_a)
    if (vertex_on_face(*A.features, pair.a, T_B_A, B.features->faces[static_cast<std::size_t>(pair.b)], &p,
                       &gap, kNearSlack, kNearTurn))
      near_.vertices_of_a.push_back(pair);
  for (const Pair& pair : all_.vertices_of_b)
    if (vertex_on_face(*B.features, pair.b, T_A_B, A.features->faces[static_cast<std::size_t>(pair.a)], &p,
                       &gap, kNearSlack, kNearTurn))
      near_.vertices_of_b.push_back(pair);
  for (const Pair& pair : all_.edges)
    if (may_cross(moved(A.features->edges[static_cast<std::size_t>(pair.a)], T_B_A),
                  B.features->edges[static_cast<std::size_t>(pair.b)], kSecondOrder * kNearSlack,
                  kSecondOrder * kNearTurn))
      near_.edges.push_back(pair);
}

void FeaturePairs::look_up(const Surface& X, const Surface& Y, const Pose& T_Y_X, bool swapped) {
  const double band = Y.distance ? Y.distance->band() : 1e9;
  for (const SampleBall& group : X.features->groups) {
    if (Y.features->box.exteriorDistance(T_Y_X * group.centre) > group.radius + kLookup) continue;
    for (int i = group.begin; i < group.end; ++i) {
      const SampleBall& ball = X.features->balls[static_cast<std::size_t>(i)];
      const double far = ball.radius + kLookup + 0.0005;  // the grid's interpolation is not exact
      if (far < band && signed_distance(Y, T_Y_X * ball.centre, nullptr) > far) continue;
      look_up_ball(X, Y, T_Y_X, ball, swapped);
    }
  }
}

void FeaturePairs::look_up_ball(const Surface& X, const Surface& Y, const Pose& T_Y_X, const SampleBall& ball,
                                bool swapped) {
  const SurfaceFeatures& x = *X.features;
  const SurfaceFeatures& y = *Y.features;
  for (int i = ball.begin; i < ball.end; ++i) {
    const FeatureSample& sample = x.samples[static_cast<std::size_t>(i)];
    const Vector p = T_Y_X * sample.p;
    if (sample.vertex >= 0) {
      const auto cell = y.near(p);
      for (const int* f = cell.face_begin; f != cell.face_end; ++f) {
        const FaceFeature& face = y.faces[static_cast<std::size_t>(*f)];
        const double gap = face.n.dot(p) - face.offset;
        if (gap > kReach || gap < -kDeepest - kSlack || !in_face(face, p, kSlack) ||
            !leads(x, sample.vertex, T_Y_X.linear().transpose() * face.n, kCone + kTurn))
          continue;
        if (swapped)
          all_.vertices_of_b.push_back({*f, sample.vertex});
        else
          all_.vertices_of_a.push_back({sample.vertex, *f});
      }
      if (y.box.contains(p) && signed_distance(Y, p, nullptr) < kSlack - kDeep)
        (swapped ? deep_b_ : deep_a_).push_back(sample.vertex);
    } else if (!swapped) {  // samples of A's edges find every edge of B that may cross them
      look_up_edges(x.edges[static_cast<std::size_t>(sample.edge)], sample, p, y, T_Y_X);
    }
  }
}

void FeaturePairs::look_up_edges(const EdgeFeature& own, const FeatureSample& sample,
                                 const Eigen::Vector3d& p, const SurfaceFeatures& y, const Pose& T_Y_X) {
  const auto cell = y.near(p);
  std::optional<EdgeFeature> edge;  // own, in Y: most have no neighbour and need none
  for (const int* e = cell.edge_begin; e != cell.edge_end; ++e) {
    const EdgeFeature& other = y.edges[static_cast<std::size_t>(*e)];
    if (!near_edge(p, other, kReach + 0.5 * kEdgeSpacing)) continue;
    if (!edge) edge = moved(own, T_Y_X);
    const double sine = edge->d.cross(other.d).norm();
    if (sine > 0.2 && !cross(*edge, other, kSlack / sine, kCone + 1.5 * kTurn / sine, 0.0).valid) continue;
    all_.edges.push_back({sample.edge, *e});
  }
}

}  // namespace stonestack::physics
