#include "physics/settle.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

constexpr int kStepsASample = 4;

WorldOptions damped(const SettleOptions& options) {
  WorldOptions world = options.world;
  world.linear_damping = world.angular_damping = options.damping;
  return world;
}

/// Names what the stone touches beside its support; empty if nothing.
std::string wrong_touch(const std::vector<Contact>& contacts, int body, int support) {
  for (const Contact& c : contacts)
    if (c.above == body && c.below != support)
      return c.below == kTable ? "touches the table" : concat("touches stone ", c.below, " of the stack");
  return "";
}

}  // namespace

SettleResult settle(const ShapeList& shapes, const Stack& stack, StoneIndex stone, const Pose& T_W_O,
                    const SettleOptions& options) {
  World world(damped(options));
  for (const PlacedStone& placed : stack.stones)
    world.add_stone(at(shapes, placed.stone), placed.T_W_O, options.fixed_stack);
  const auto& shape = at(shapes, stone);
  const int body = world.add_stone(shape, T_W_O);
  world.set_weight_offset(body, options.com_error_O);
  const Eigen::Vector3d start = T_W_O * shape->mass.p_O_M;

  SettleResult result;
  int calm = 0;
  while (result.reason.empty() && calm < options.calm_samples && world.time() < options.seconds) {
    throw_if_interrupted();
    for (int i = 0; i < kStepsASample; ++i) world.step();
    const std::vector<Contact> contacts = world.contacts();
    const Twist twist = world.twist(body);
    result.travel = (world.pose(body) * shape->mass.p_O_M - start).norm();
    if (result.travel > options.max_travel) result.reason = concat("travelled ", result.travel, " m");
    if (result.reason.empty() && !options.any_support) result.reason = wrong_touch(contacts, body, body - 1);
    const bool slow = twist.v.norm() + shape->radius * twist.w.norm() < options.calm_speed;
    const auto touches = [&](const Contact& c) { return c.above == body; };
    if (!slow || std::none_of(contacts.begin(), contacts.end(), touches)) {
      calm = 0;
      result.contacts.clear();
      continue;
    }
    ++calm;
    std::copy_if(contacts.begin(), contacts.end(), std::back_inserter(result.contacts), touches);
  }
  result.T_W_O = world.pose(body);
  result.kinetic_energy = world.kinetic_energy(body);
  if (result.reason.empty() && calm < options.calm_samples) result.reason = "does not come to rest";
  result.rests = result.reason.empty();
  return result;
}

}  // namespace stonestack::physics
