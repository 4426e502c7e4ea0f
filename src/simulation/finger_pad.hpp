#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "physics/shape.hpp"
#include "physics/world.hpp"

namespace stonestack::simulation {

/// A rubber pad as an elastic foundation: normal pressure proportional to how deep a surface lies in it,
/// bristle friction sideways. Elastic constants of 5 mm of soft rubber (E about 0.75 MPa): at 60 N on 4 cm^2
/// it yields by 1 mm. A design choice, as is the friction: rubber on dry stone.
struct PadOptions {
  double width = 0.031;      ///< along y of P [m]
  double length = 0.040;     ///< along x of P [m]
  double thickness = 0.005;  ///< thickness of rubber [m]; behind it lies the rigid finger
  double stiffness = 1.5e8;  ///< N/m^3, normal
  double shear = 5e7;        ///< N/m^3, sideways: a third of it, as for rubber
  double damping = 4e-4;     ///< viscous part of both [s]: stress = stiffness (d + damping d')
  double friction = 0.5;     ///< rubber on stone
  double entry_depth =
      5e-4;  ///< what appears deeper than this came in from the side, and starts unstressed [m]
};

/// Load of a pad on a stone; world axes.
struct PadLoad {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< about the world's origin [Nm]
  double normal = 0.0;                               ///< elastic, along the pad's normal [N]
  int samples = 0;                                   ///< of the stone's surface in the pad
  /// Moment about another point.
  [[nodiscard]] Eigen::Vector3d moment_about(const Eigen::Vector3d& p_W) const {
    return moment - p_W.cross(force);
  }
};

/// A frame in motion, world axes.
struct MovingFrame {
  Pose T_W_A = Pose::Identity();
  Eigen::Vector3d p_W_reference = Eigen::Vector3d::Zero();  ///< the point whose velocity is `twist.v`
  Twist twist;
  [[nodiscard]] Eigen::Vector3d velocity_at(const Eigen::Vector3d& p_W) const {
    return twist.v + twist.w.cross(p_W - p_W_reference);
  }
};

/// One pad against one stone, with the memory of its bristles. Frame P: origin in the middle of the pad's
/// face, z towards what is gripped.
class PadContact {
 public:
  PadContact(const ContactShape& shape, const PadOptions& options) : shape_(&shape), options_(options) {}

  /// True if the stone's surface may be in the pad or within `kReach` of it. Looks for the surface samples
  /// nearby only when the two have moved against each other.
  bool near(const Pose& T_W_P, const Pose& T_W_O);
  /// Force on the stone now, and the bristles' next state. After `near` was true.
  PadLoad press(const MovingFrame& pad, const MovingFrame& stone);
  /// True if the last `press` found the stone in the pad.
  [[nodiscard]] bool touching() const { return touching_; }
  /// Damping of the whole pad against a stone, N s/m.
  [[nodiscard]] double damping() const {
    return options_.length * options_.width * options_.stiffness * options_.damping;
  }
  /// The bristles that hold the stone, to be restored in another process.
  [[nodiscard]] nlohmann::json kept() const;
  void restore(const nlohmann::json& kept);

  static constexpr double kReach = 0.006;  ///< [m]

 private:
  struct Bristle {
    int sample = -1;
    bool active = false;
    double rest = 0.0;                                 // m, depth without pressure
    Eigen::Vector2d anchor = Eigen::Vector2d::Zero();  // in P
  };
  void collect(const Pose& T_P_O);
  void note_points();

  const ContactShape* shape_;
  PadOptions options_;
  std::vector<Bristle> bristles_;        // samples within reach, ascending
  std::vector<double> x_O_, y_O_, z_O_;  // m: their points
  std::vector<double> depth_;            // m: how deep each lies in the pad
  Pose T_P_O_collected_ = Pose::Identity();
  bool collected_ = false;
  bool touching_ = false;
};

}  // namespace stonestack::simulation
