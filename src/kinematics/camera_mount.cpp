#include "kinematics/camera_mount.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <map>

#include "kinematics/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

constexpr int kRounds = 4;  // Gauss-Newton steps; the problem is nearly linear
constexpr double kMountBeside =
    0.15;  // m: the table is represented by three points so far from the view's middle
constexpr Eigen::Index kMount = 6;    // translation, rotation
constexpr Eigen::Index kTableAt = 6;  // height at the middle, slopes along x and y
constexpr Eigen::Index kMarksAt = 9;  // three unknowns a mark

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// T * exp(t, w), a small motion in T's own frame.
Pose moved(const Pose& T, const Eigen::Vector3d& t, const Eigen::Vector3d& w) {
  Pose out = T * Eigen::Translation3d(t);
  if (w.norm() > 1e-15) out = out * Eigen::AngleAxisd(w.norm(), w.normalized());
  return out;
}

/// Points of the plane, about where the optical axis meets it; none if it does not.
std::vector<Eigen::Vector3d> points_of(const Plane& table_C) {
  const double slope = table_C.normal.z();
  if (std::abs(slope) < 0.1) return {};
  const Eigen::Vector3d middle(0, 0, table_C.offset / slope);
  const Eigen::Vector3d u = table_C.normal.unitOrthogonal(), v = table_C.normal.cross(u);
  std::vector<Eigen::Vector3d> points;
  for (const double angle : {0.0, 2.0943951023931953, 4.1887902047863905})
    points.emplace_back(middle + kMountBeside * (std::cos(angle) * u + std::sin(angle) * v));
  return points;
}

/// Normal equations of one Gauss-Newton step.
class Equations {
 public:
  explicit Equations(Eigen::Index unknowns)
      : A_(Eigen::MatrixXd::Zero(unknowns, unknowns)), b_(Eigen::VectorXd::Zero(unknowns)) {}

  /// residual + row * x = 0, with weight 1 / sigma.
  void add(const Eigen::VectorXd& row, double residual, double sigma) {
    const double weight = 1.0 / (sigma * sigma);
    A_ += weight * row * row.transpose();
    b_ -= weight * residual * row;
  }
  [[nodiscard]] Eigen::VectorXd solve() const { return A_.ldlt().solve(b_); }

 private:
  Eigen::MatrixXd A_;
  Eigen::VectorXd b_;
};

class MountProblem {
 public:
  MountProblem(std::span<const MountView> views, const Pose& T_T_C)
      : views_(views), given_(T_T_C), T_T_C_(T_T_C) {
    std::map<int, int> seen;
    for (const MountView& view : views)
      for (const SeenMark& mark : view.marks) ++seen[mark.mark];
    for (const auto& [mark, count] : seen)
      if (count > 1) index_.emplace(mark, static_cast<int>(index_.size()));
    place_marks();
    for (const MountView& view : views)
      middle_ += view.T_W_T.translation().head<2>() / static_cast<double>(views.size());
  }

  void step() {
    const auto unknowns = kMarksAt + 3 * static_cast<Eigen::Index>(index_.size());
    Equations equations(unknowns);
    add_prior(equations, unknowns);
    for (const MountView& view : views_) {
      const Pose T_W_C = view.T_W_T * T_T_C_;
      if (view.table_C)
        for (const Eigen::Vector3d& p_C : points_of(*view.table_C))
          add_table_point(equations, T_W_C, p_C, unknowns);
      for (const SeenMark& mark : view.marks) {
        const auto known = index_.find(mark.mark);
        if (known == index_.end()) continue;
        const Eigen::Vector3d residual = T_W_C * mark.p_C - p_W_[static_cast<std::size_t>(known->second)];
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
          Eigen::VectorXd row = row_of(T_W_C, mark.p_C, axis, unknowns);
          row[kMarksAt + 3 * known->second + axis] = -1.0;
          equations.add(row, residual[axis], kMarkSigma);
        }
      }
    }
    const Eigen::VectorXd x = equations.solve();
    T_T_C_ = moved(T_T_C_, x.head<3>(), x.segment<3>(3));
    table_ += x.segment<3>(kTableAt);
    for (std::size_t k = 0; k < p_W_.size(); ++k)
      p_W_[k] += x.segment<3>(kMarksAt + 3 * static_cast<Eigen::Index>(k));
  }

  /// Root mean square distance of the shared marks from their means over the views.
  [[nodiscard]] double disagreement() const {
    double sum = 0.0;
    int count = 0;
    for (const auto& [mark, k] : index_) {
      const std::vector<Eigen::Vector3d> places = places_of(mark);
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const auto& p : places) mean += p / static_cast<double>(places.size());
      for (const auto& p : places) sum += (p - mean).squaredNorm();
      count += static_cast<int>(places.size());
    }
    return count == 0 ? 0.0 : std::sqrt(sum / count);
  }

  [[nodiscard]] const Pose& T_T_C() const { return T_T_C_; }
  [[nodiscard]] Plane table_W() const {
    const Eigen::Vector3d n_W = Eigen::Vector3d(-table_[1], -table_[2], 1.0).normalized();
    return {n_W, n_W.dot(Eigen::Vector3d(middle_.x(), middle_.y(), table_[0]))};
  }
  [[nodiscard]] int marks() const { return static_cast<int>(index_.size()); }

 private:
  [[nodiscard]] std::vector<Eigen::Vector3d> places_of(int mark) const {
    std::vector<Eigen::Vector3d> places;
    for (const MountView& view : views_)
      for (const SeenMark& seen : view.marks)
        if (seen.mark == mark) places.emplace_back(view.T_W_T * (T_T_C_ * seen.p_C));
    return places;
  }

  void place_marks() {
    p_W_.resize(index_.size());
    for (const auto& [mark, k] : index_) {
      const auto places = places_of(mark);
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const auto& p : places) mean += p / static_cast<double>(places.size());
      p_W_[static_cast<std::size_t>(k)] = mean;
    }
  }

  /// A point that was seen on the table lies on its plane.
  void add_table_point(Equations& equations, const Pose& T_W_C, const Eigen::Vector3d& p_C,
                       Eigen::Index unknowns) const {
    const Eigen::Vector3d p_W = T_W_C * p_C;
    const Eigen::Vector2d beside = p_W.head<2>() - middle_;
    Eigen::VectorXd row = row_of(T_W_C, p_C, 2, unknowns) - table_[1] * row_of(T_W_C, p_C, 0, unknowns) -
                          table_[2] * row_of(T_W_C, p_C, 1, unknowns);
    row.segment<3>(kTableAt) << -1.0, -beside.x(), -beside.y();
    equations.add(row, p_W.z() - table_[0] - table_.tail<2>().dot(beside), kTableSigma);
  }

  /// Mount and table stay near what was given.
  void add_prior(Equations& equations, Eigen::Index unknowns) const {
    const Pose off = given_.inverse() * T_T_C_;
    const Eigen::AngleAxisd turn(off.rotation());
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      equations.add(Eigen::VectorXd::Unit(unknowns, axis), off.translation()[axis], kPriorTranslation);
      equations.add(Eigen::VectorXd::Unit(unknowns, 3 + axis), turn.angle() * turn.axis()[axis],
                    kPriorRotation);
      equations.add(Eigen::VectorXd::Unit(unknowns, kTableAt + axis), table_[axis],
                    axis == 0 ? kPriorTableHeight : kPriorTableTilt);
    }
  }

  /// How coordinate `axis` of a point's place in W changes with the mount.
  static Eigen::VectorXd row_of(const Pose& T_W_C, const Eigen::Vector3d& p_C, Eigen::Index axis,
                                Eigen::Index unknowns) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(unknowns);
    row.head<3>() = T_W_C.linear().row(axis).transpose();
    row.segment<3>(3) = -(T_W_C.linear().row(axis) * cross_matrix(p_C)).transpose();
    return row;
  }

  std::span<const MountView> views_;
  Pose given_;
  Pose T_T_C_;
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();  ///< below the views [m in W]
  Eigen::Vector3d table_ = Eigen::Vector3d::Zero();   ///< height at the middle [m], slopes
  std::map<int, int> index_;                          ///< of marks that more than one view saw
  std::vector<Eigen::Vector3d> p_W_;
};

}  // namespace

MountRefinement refine_camera_mount(std::span<const MountView> views, const Pose& T_T_C) {
  require(!views.empty(), "a camera mount cannot be refined without a view");
  require(is_valid(T_T_C), "the camera mount is not a rigid transform");
  MountProblem problem(views, T_T_C);
  MountRefinement out;
  out.shared_marks = problem.marks();
  out.before = problem.disagreement();
  for (int round = 0; round < kRounds; ++round) problem.step();
  out.T_T_C = problem.T_T_C();
  out.table_W = problem.table_W();
  out.after = problem.disagreement();
  const auto off = difference(out.T_T_C, T_T_C);
  out.shift = off.translation;
  out.turn = off.angle;
  return out;
}

}  // namespace stonestack::kinematics
