#include "physics/touch.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kDeepest = 0.003;    // m: features tell depths down to here, below it the signed distance
constexpr double kDeep = 0.0025;      // m: vertices at least as deep touch by the signed distance too
constexpr double kSlack = 0.002;      // m: motion after which candidates are looked for again
constexpr double kTurn = 0.02;        // rad: the same
constexpr double kNearSlack = 2e-4;   // m: motion after which those that may touch soon are chosen again
constexpr double kNearTurn = 0.002;   // rad: the same
constexpr double kSecondOrder = 1.5;  // what crossing edges may move and turn more than the bodies
constexpr double kCone = 0.02;        // sine: how far out of a normal cone still counts
constexpr double kRim = 1e-5;         // m: how far beside a face or beyond an edge's end still counts
constexpr double kParallel = 0.02;    // sine between edges: below it their ends touch, not they
constexpr std::size_t kMostDeep = 8;  // deep touches a body
constexpr double kReach = kTouchGap + kSlack;

bool in_face(const FaceFeature& face, const Vector& p, double beyond) {
  for (int i = 0; i < 3; ++i)
    if (face.side[i].dot(p) < face.side_offset[i] - beyond) return false;
  return true;
}

/// True if vertex `v` is the first of its surroundings to meet a plane with normal `n` from above.
bool leads(const SurfaceFeatures& features, int v, const Vector& n, double tolerance) {
  const auto i = static_cast<std::size_t>(v);
  for (int k = features.fan_begin[i]; k < features.fan_begin[i + 1]; ++k)
    if (features.fan[static_cast<std::size_t>(k)].dot(n) < -tolerance) return false;
  return true;
}

bool in_cone(const EdgeFeature& edge, const Vector& n, double tolerance) {
  return edge.into0.dot(n) <= tolerance && edge.into1.dot(n) <= tolerance;
}

EdgeFeature moved(const EdgeFeature& e, const Pose& T) {
  const Eigen::Matrix3d R = T.linear();
  return {T * e.p0, T * e.p1, R * e.d, R * e.into0, R * e.into1, R * e.n_mean, e.length};
}

/// Where two edges cross, seen along their common normal.
struct Crossing {
  bool valid = false;
  double gap = 0.0;
  Vector n, p_a, p_b;  ///< n from b to a
};
Crossing cross(const EdgeFeature& a, const EdgeFeature& b, double beyond, double cone, double parallel) {
  Crossing out;
  const Vector c = a.d.cross(b.d);
  const double sine = c.norm();
  if (sine < parallel) return out;
  out.n = c / sine;
  if (out.n.dot(b.n_mean - a.n_mean) < 0.0) out.n = -out.n;
  const Vector r = b.p0 - a.p0;
  out.gap = -out.n.dot(r);
  if (out.gap > kReach || out.gap < -kDeepest - kSlack) return out;
  if (!in_cone(b, out.n, cone) || !in_cone(a, -out.n, cone)) return out;
  const double s = r.cross(b.d).dot(c) / (sine * sine);
  const double t = r.cross(a.d).dot(c) / (sine * sine);
  if (s < -beyond || s > a.length + beyond || t < -beyond || t > b.length + beyond) return out;
  out.p_a = a.p0 + s * a.d;
  out.p_b = b.p0 + t * b.d;
  out.valid = true;
  return out;
}

/// The point lies within `reach` of the edge.
bool near_edge(const Vector& p, const EdgeFeature& e, double reach) {
  const double s = std::clamp((p - e.p0).dot(e.d), 0.0, e.length);
  return (p - e.p0 - s * e.d).squaredNorm() <= reach * reach;
}

/// Touch of vertex x of X on face y of Y, all in Y; false if they cannot be the first to touch, even after
/// some motion and turn.
bool vertex_on_face(const SurfaceFeatures& X, int x, const Pose& T_Y_X, const FaceFeature& face, Vector* p,
                    double* gap, double motion = 0.0, double turn = 0.0) {
  *p = T_Y_X * X.vertices[static_cast<std::size_t>(x)];
  *gap = face.n.dot(*p) - face.offset;
  return *gap <= kTouchGap + motion && *gap >= -kDeepest - motion && in_face(face, *p, kRim + motion) &&
         leads(X, x, T_Y_X.linear().transpose() * face.n, kCone + turn);
}

/// Edges that may touch after some motion and turn; those that are nearly parallel always may.
bool may_cross(const EdgeFeature& a, const EdgeFeature& b, double motion, double turn) {
  const double sine = a.d.cross(b.d).norm();
  if (sine < 0.05) return true;
  const Crossing c = cross(a, b, kRim + motion / sine, kCone + turn / sine, 0.0);
  return c.valid && c.gap <= kTouchGap + motion && c.gap >= -kDeepest - motion;
}

void add_deep(const Surface& X, const Surface& Y, const Pose& T_W_X, const Pose& T_Y_X, const Pose& T_W_Y,
              const std::vector<int>& deep, bool swapped, std::vector<Touch>& out) {
  std::vector<Touch> found;
  for (const int v : deep) {
    const Vector& p_X = X.features->vertices[static_cast<std::size_t>(v)];
    Vector n_Y;
    const double gap = signed_distance(Y, T_Y_X * p_X, &n_Y);
    if (gap > -kDeep) continue;
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
  if (found.size() > kMostDeep) found.resize(kMostDeep);
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

bool moved_enough(const Pose& before, const Pose& now, double radius, double motion, double turn_limit) {
  const Eigen::Matrix3d turn = before.linear().transpose() * now.linear();
  const double angle = std::sqrt(std::max(0.0, 3.0 - turn.trace()));  // 2 sin(angle / 2) to first order
  return angle > turn_limit || (now.translation() - before.translation()).norm() + angle * radius > motion;
}

double radius_about_origin(const SurfaceFeatures& features) {
  return features.box.min().cwiseAbs().cwiseMax(features.box.max().cwiseAbs()).norm();
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
  EdgeFeature edge;
  for (const int* e = cell.edge_begin; e != cell.edge_end; ++e) {
    const EdgeFeature& other = y.edges[static_cast<std::size_t>(*e)];
    if (!near_edge(p, other, kReach + 0.5 * kEdgeSpacing)) continue;
    if (edge.length == 0.0) edge = moved(own, T_Y_X);
    const double sine = edge.d.cross(other.d).norm();
    if (sine > 0.2 && !cross(edge, other, kSlack / sine, kCone + 1.5 * kTurn / sine, 0.0).valid) continue;
    all_.edges.push_back({sample.edge, *e});
  }
}

std::vector<Touch> TablePairs::touches(const Surface& A, const Pose& T_W_A) {
  const SurfaceFeatures& x = *A.features;
  if (!fresh_ || moved_enough(T_W_A_, T_W_A, radius_about_origin(x), kSlack, kTurn)) {
    fresh_ = true;
    T_W_A_ = T_W_A;
    vertices_.clear();
    const Vector up_A = T_W_A.linear().transpose() * Vector::UnitZ();
    for (const SampleBall& group : x.groups) {
      if ((T_W_A * group.centre).z() > group.radius + kReach) continue;
      for (int b = group.begin; b < group.end; ++b) {
        const SampleBall& ball = x.balls[static_cast<std::size_t>(b)];
        if ((T_W_A * ball.centre).z() > ball.radius + kReach) continue;
        for (int i = ball.begin; i < ball.end; ++i) {
          const FeatureSample& s = x.samples[static_cast<std::size_t>(i)];
          if (s.vertex >= 0 && (T_W_A * s.p).z() <= kReach && leads(x, s.vertex, up_A, kCone + kTurn))
            vertices_.push_back(s.vertex);
        }
      }
    }
    std::sort(vertices_.begin(), vertices_.end());
  }
  std::vector<Touch> out;
  const Vector up_A = T_W_A.linear().transpose() * Vector::UnitZ();
  for (const int v : vertices_) {
    const Vector& p_A = x.vertices[static_cast<std::size_t>(v)];
    const Vector p = T_W_A * p_A;
    if (p.z() > kTouchGap || !leads(x, v, up_A, kCone)) continue;
    out.push_back({TouchKind::kVertexOfA, v, -1, {p.x(), p.y(), 0.0}, Vector::UnitZ(), p.z(), p_A});
  }
  return out;
}

}  // namespace stonestack
