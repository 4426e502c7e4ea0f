#pragma once
#include <map>
#include <memory>
#include <utility>

#include "physics/bullet.hpp"
#include "physics/shape.hpp"
#include "physics/touch.hpp"

namespace stonestack::physics {

/// A surface as Bullet's collision shape: Bullet asks for its bounding box only; this library computes the
/// contacts. Body frame P: principal axes at the centre of mass.
class SurfaceShape : public btCollisionShape {
 public:
  SurfaceShape(const Surface& surface, const Pose& T_O_P);
  /// The table, z = 0.
  SurfaceShape();

  [[nodiscard]] const Surface& surface() const { return surface_; }
  [[nodiscard]] const Pose& T_P_O() const { return T_P_O_; }
  [[nodiscard]] bool is_table() const { return surface_.features == nullptr; }

  void getAabb(const btTransform& t, btVector3& low, btVector3& high) const override;
  void setLocalScaling(const btVector3&) override {}
  [[nodiscard]] const btVector3& getLocalScaling() const override { return scaling_; }
  void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
  [[nodiscard]] const char* getName() const override { return "surface"; }
  void setMargin(btScalar) override {}
  [[nodiscard]] btScalar getMargin() const override { return 0.0; }

 private:
  Surface surface_;
  Pose T_P_O_ = Pose::Identity();
  btVector3 scaling_{1, 1, 1};
};

/// Contact rule of two bodies.
struct PairRule {
  double friction = 0.1;
  bool touches = true;
  double stiffness = 0.0;  ///< [N/m] of each touch; 0: rigid
};
struct PairRules {
  double friction = 0.1;  ///< of pairs without a rule
  std::map<std::pair<int, int>, PairRule> rules;
  [[nodiscard]] PairRule of(int a, int b) const {
    const auto found = rules.find({std::min(a, b), std::max(a, b)});
    return found == rules.end() ? PairRule{friction, true, 0.0} : found->second;
  }
};

/// Bullet's collision algorithm of two surfaces, or of a surface and the table: keeps their touches and the
/// impulses of the last step. Body A has the higher index, so that normals point up a stack built upwards.
class TouchAlgorithm : public btCollisionAlgorithm {
 public:
  TouchAlgorithm(btDispatcher* dispatcher, const btCollisionObject* first, const btCollisionObject* second,
                 const PairRules* rules);

  void processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*,
                        const btDispatcherInfo&, btManifoldResult*) override;
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1.0;
  }
  void getAllContactManifolds(btManifoldArray&) override {}

  [[nodiscard]] const btRigidBody* a() const { return a_; }
  [[nodiscard]] const btRigidBody* b() const { return b_; }
  [[nodiscard]] double friction() const { return friction_; }
  [[nodiscard]] double stiffness() const { return stiffness_; }
  [[nodiscard]] std::vector<Touch>& touches() { return state_->touches; }

  /// Makes these algorithms; one a world.
  class Factory : public btCollisionAlgorithmCreateFunc {
   public:
    explicit Factory(const PairRules* rules) : rules_(rules) {}
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;

   private:
    const PairRules* rules_;
  };

 private:
  struct State {
    FeaturePairs pairs;
    TablePairs table;
    std::vector<Touch> touches;
  };
  const btRigidBody* a_;
  const btRigidBody* b_;
  const PairRules* rules_;
  double friction_ = 0.0;
  double stiffness_ = 0.0;
  std::unique_ptr<State> state_;
};

}  // namespace stonestack::physics
