#include "search/contact_search.hpp"

#include <algorithm>

#include "physics/world.hpp"
#include "search/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

constexpr int kPathEvery = 8;  ///< steps between poses of the path

/// Contacts of the new stone; empty if it touches something else than the top of the stack.
std::optional<std::vector<Contact>> contacts_with_top(const World& world, int body, int top) {
  std::vector<Contact> contacts;
  for (const Contact& contact : world.contacts()) {
    if (contact.above != body && contact.below != body) continue;
    const int other = contact.above == body ? contact.below : contact.above;
    if (other != top) return std::nullopt;
    contacts.push_back(contact);
  }
  return contacts;
}

World world_with_stack(const SearchContext& context) {
  WorldOptions options;
  options.friction = context.options->friction;
  World world(options);
  world.set_gravity(Eigen::Vector3d::Zero());
  for (const PlacedStone& placed : context.stack.stones)
    world.add_stone(at(context.shapes(), placed.stone), placed.T_W_O, true);
  return world;
}

/// Draws on while contacts are collected: `result` with polygon and cost, or why it is not valid.
ContactSearch collected(const SearchContext& context, const Target& target, StoneIndex stone, World& world,
                        std::vector<Contact> contacts, ContactSearch result) {
  const int body = world.bodies() - 1, top = body - 1;  // kTable is -1
  const Eigen::Vector3d& p_O_M = at(context.geometry, stone).p_O_M;
  for (int k = 1; k < kContactSteps; ++k) {
    const Eigen::Vector3d p_W_com = world.pose(body) * p_O_M;
    world.apply(body, kAttraction * (target.p_W_centroid - p_W_com).normalized());
    world.step();
    const auto of_step = contacts_with_top(world, body, top);
    if (!of_step) {
      result.outcome = "touches more than the top of the stack";
      return result;
    }
    contacts.insert(contacts.end(), of_step->begin(), of_step->end());
  }
  result.T_W_O = world.pose(body);
  result.path_W_O.push_back(result.T_W_O);
  result.pose.p_W_com = result.T_W_O * p_O_M;
  result.pose.support = support_polygon(contacts, result.pose.p_W_com);
  result.pose.v_W = (target.p_W_centroid - result.pose.p_W_com).normalized();
  result.cost = pose_cost(result.pose, *context.options);
  const SupportPolygon& support = result.pose.support;
  if (support.corners_W.size() < 3 || support.margin <= 0.0)
    result.outcome = "the centre of mass left the polygon while contacts were collected";
  else if (support.area < context.options->area_min)
    result.outcome = "the support polygon is smaller than area_min";
  else
    result.valid = true;
  return result;
}

}  // namespace

ContactSearch search_contact(const SearchContext& context, const Target& target, StoneIndex stone,
                             const Pose& T_W_O_init) {
  const SearchOptions& o = *context.options;
  World world = world_with_stack(context);
  const int body = world.add_stone(at(context.shapes(), stone), T_W_O_init);
  const int top = body - 1;  // kTable is -1
  const Eigen::Vector3d p_O_M = at(context.geometry, stone).p_O_M;
  ContactSearch result;
  result.pose.p_W_previous_com = target.p_W_previous_com;
  const int steps = static_cast<int>(o.contact_seconds / world.options().step);
  for (int k = 0; k < steps; ++k) {
    const Pose T_W_O = world.pose(body);
    const Eigen::Vector3d p_W_com = T_W_O * p_O_M;
    if (k % kPathEvery == 0) result.path_W_O.push_back(T_W_O);
    if ((p_W_com - T_W_O_init * p_O_M).norm() > kSlidOff) {
      result.outcome = "slid off the stack";
      return result;
    }
    world.apply(body, kAttraction * (target.p_W_centroid - p_W_com).normalized());
    world.step();
    const auto contacts = contacts_with_top(world, body, top);
    if (!contacts) {
      result.outcome = "touches more than the top of the stack";
      return result;
    }
    if (contacts->size() < 3 || world.kinetic_energy(body) >= kStableKineticEnergy) continue;
    const SupportPolygon polygon = support_polygon(*contacts, world.pose(body) * p_O_M);
    if (polygon.corners_W.size() < 3 || polygon.margin <= 0.0) continue;
    result.pose.kinetic_energy = world.kinetic_energy(body);
    return collected(context, target, stone, world, *contacts, std::move(result));
  }
  result.outcome = "no three contacts around the centre of mass at low kinetic energy";
  return result;
}

}  // namespace stonestack::search
