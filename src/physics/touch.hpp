#pragma once
#include <vector>

#include "geometry/signed_distance.hpp"
#include "physics/features.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::physics {

/// A body's surface, as contact needs it: the features of a stone or a box, and its signed distance.
struct Surface {
  const SurfaceFeatures* features = nullptr;
  const SignedDistance* distance = nullptr;        ///< null: a box of half sides `half`
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< [m]
};
/// Negative inside; the gradient has unit length.
[[nodiscard]] double signed_distance(const Surface& surface, const Eigen::Vector3d& p,
                                     Eigen::Vector3d* gradient);

/// Kind of a touch. A and B are the two bodies of a pair, in the order of their indices.
enum class TouchKind { kVertexOfA, kVertexOfB, kEdges, kDeepA, kDeepB };

/// One point where A and B touch or nearly do.
struct Touch {
  TouchKind kind = TouchKind::kVertexOfA;
  int a = -1;                                      ///< vertex or edge of A, else face
  int b = -1;                                      ///< vertex or edge of B, else face
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();   ///< on B
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();  ///< from B to A
  double gap = 0.0;                                ///< negative [m]: penetration
  Eigen::Vector3d p_A =
      Eigen::Vector3d::Zero();  ///< the same point in A: what a touch is known by from step to step
  double impulse = 0.0;         ///< normal impulse [N s]
  Eigen::Vector3d friction = Eigen::Vector3d::Zero();  ///< impulse [N s] on A, world axes
};

/// touches are reported up to this gap [m].
inline constexpr double kTouchGap = 0.001;

/// Exact touches between two concave surfaces: vertices of one on faces of the other, and crossing edges,
/// each where the features can really be the first to touch (normal in the normal cones). Pairs of features
/// near each other are kept, and looked for again only when the bodies have moved against each other.
class FeaturePairs {
 public:
  /// Touches of A and B with a gap of at most kTouchGap, in the order of their features.
  [[nodiscard]] std::vector<Touch> touches(const Surface& A, const Surface& B, const Pose& T_W_A,
                                           const Pose& T_W_B);

 private:
  struct Pair {
    int a, b;
    bool operator<(const Pair& o) const { return a != o.a ? a < o.a : b < o.b; }
    bool operator==(const Pair& o) const { return a == o.a && b == o.b; }
  };
  struct Lists {
    std::vector<Pair> vertices_of_a;  ///< (vertex of A, face of B)
    std::vector<Pair> vertices_of_b;  ///< (face of A, vertex of B)
    std::vector<Pair> edges;
  };
  void refresh(const Surface& A, const Surface& B, const Pose& T_B_A);
  /// Of all pairs those that may touch after a motion too small to matter for a stone at rest.
  void choose_near(const Surface& A, const Surface& B, const Pose& T_B_A);
  /// Candidates from the samples of X near Y; `swapped`: X is B.
  void look_up(const Surface& X, const Surface& Y, const Pose& T_Y_X, bool swapped);
  void look_up_ball(const Surface& X, const Surface& Y, const Pose& T_Y_X, const SampleBall& ball,
                    bool swapped);
  void look_up_edges(const EdgeFeature& own, const FeatureSample& sample, const Eigen::Vector3d& p,
                     const SurfaceFeatures& y, const Pose& T_Y_X);

  bool fresh_ = false;
  Pose T_B_A_ = Pose::Identity(), T_near_ = Pose::Identity();  ///< when all and near were chosen
  Lists all_, near_;
  std::vector<int> deep_a_, deep_b_;  ///< vertices far inside the other body
};

/// Finds touches against the table, z = 0: vertices of A on the plane. B is the table.
class TablePairs {
 public:
  [[nodiscard]] std::vector<Touch> touches(const Surface& A, const Pose& T_W_A);

 private:
  bool fresh_ = false;
  Pose T_W_A_ = Pose::Identity();
  std::vector<int> vertices_;
};

/// Keeps at most `max` touches: all that were kept before if possible, the deepest, then the most spread.
void reduce(std::vector<Touch>& touches, const std::vector<Touch>& before, std::size_t max);
/// Takes the impulses over from the last step's touches: the same features, else the nearest within 1 mm with
/// the same normal.
void carry_over(std::vector<Touch>& touches, const std::vector<Touch>& before);

}  // namespace stonestack::physics
