#include "physics/surface_shape.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <new>

namespace stonestack::physics {
namespace {

constexpr std::size_t kMaxTouches = 16;  // a pair
constexpr double kTableSpan = 1e3;       // m: half width of the table's bounding box

const SurfaceShape& shape_of(const btCollisionObject& object) {
  return static_cast<const SurfaceShape&>(*object.getCollisionShape());
}

Pose pose_of(const btCollisionObject& object) {
  return to_eigen(object.getWorldTransform()) * shape_of(object).T_P_O();
}

}  // namespace

SurfaceShape::SurfaceShape(const Surface& surface, const Pose& T_O_P)
    : surface_(surface), T_P_O_(T_O_P.inverse()) {
  m_shapeType = CUSTOM_CONCAVE_SHAPE_TYPE;
}

SurfaceShape::SurfaceShape() {
  m_shapeType = CUSTOM_CONCAVE_SHAPE_TYPE;
}

void SurfaceShape::getAabb(const btTransform& t, btVector3& low, btVector3& high) const {
  if (is_table()) {
    low = btVector3(-kTableSpan, -kTableSpan, -kTableSpan);
    high = btVector3(kTableSpan, kTableSpan, 0.0);
    return;
  }
  const Pose T_W_O = to_eigen(t) * T_P_O_;
  const Eigen::Vector3d centre = T_W_O * surface_.features->box.center();
  const Eigen::Vector3d half = T_W_O.linear().cwiseAbs() * (0.5 * surface_.features->box.sizes());
  low = to_bullet(Eigen::Vector3d(centre - half));
  high = to_bullet(Eigen::Vector3d(centre + half));
}

TouchAlgorithm::TouchAlgorithm(btDispatcher* dispatcher, const btCollisionObject* first,
                               const btCollisionObject* second, const PairRules* rules)
    : rules_(rules), state_(std::make_unique<State>()) {
  m_dispatcher = dispatcher;
  if (first->getUserIndex() < second->getUserIndex()) std::swap(first, second);
  a_ = btRigidBody::upcast(first);
  b_ = btRigidBody::upcast(second);
}

void TouchAlgorithm::processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*,
                                      const btDispatcherInfo&, btManifoldResult*) {
  const PairRule rule = rules_->of(a_->getUserIndex(), b_->getUserIndex());
  friction_ = rule.friction;
  stiffness_ = rule.stiffness;
  if (!rule.touches || (a_->isStaticOrKinematicObject() && b_->isStaticOrKinematicObject())) {
    state_->touches.clear();
    return;
  }
  std::vector<Touch> touches = shape_of(*b_).is_table()
                                   ? state_->table.touches(shape_of(*a_).surface(), pose_of(*a_))
                                   : state_->pairs.touches(shape_of(*a_).surface(), shape_of(*b_).surface(),
                                                           pose_of(*a_), pose_of(*b_));
  reduce(touches, state_->touches, kMaxTouches);
  carry_over(touches, state_->touches);
  state_->touches = std::move(touches);
}

btCollisionAlgorithm* TouchAlgorithm::Factory::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
    const btCollisionObjectWrapper* second) {
  void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(TouchAlgorithm));
  return new (memory)
      TouchAlgorithm(info.m_dispatcher1, first->getCollisionObject(), second->getCollisionObject(), rules_);
}

}  // namespace stonestack::physics
