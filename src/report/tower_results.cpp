#include <algorithm>
#include <cmath>

#include "report/picture.hpp"
#include "report/text.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

constexpr double kDrawnContact = 0.0005;  // m between stones that are drawn as touching

/// Of a stone of the stack, or the table.
std::string level_name(const TowerCheck& check, const Catalogue& catalogue, int level) {
  if (level == kTable) return "the table";
  return name_of(catalogue, check.stack.stones[static_cast<std::size_t>(level)].stone);
}

/// The contact that gives way first, if there is one.
const Contact* weakest_contact(const TowerCheck& check) {
  const int index = check.equilibrium.weakest_contact;
  return index < 0 ? nullptr : &check.statics.contacts[static_cast<std::size_t>(index)];
}

double degrees(const Eigen::Vector2d& direction) {
  return std::atan2(direction.y(), direction.x()) * 180.0 / M_PI;
}

/// Red points where stones touch each other, as they are drawn.
void draw_contacts(const Catalogue& catalogue, const std::vector<PlacedStone>& stones,
                   std::vector<DrawnMesh>& meshes) {
  std::vector<Stone> used;
  Stack stack;
  for (const PlacedStone& placed : stones) {
    stack.stones.push_back({StoneIndex(static_cast<int>(used.size())), placed.T_W_O});
    used.push_back(catalogue[placed.stone]);
  }
  for (const Contact& contact : geometric_contacts(shapes_for_output(used), stack, kDrawnContact))
    if (contact.below != kTable)
      meshes.push_back(
          {make_sphere(0.004, 1), Pose(Eigen::Translation3d(contact.p_W)), {0.85, 0.15, 0.10}, false});
}

}  // namespace

std::string tower_json(const TowerCheck& check, const Catalogue& catalogue) {
  const Equilibrium& e = check.equilibrium;
  nlohmann::json out = {{"schema", "stonestack.check/1"},
                        {"friction", check.friction},
                        {"seconds", check.seconds},
                        {"stands", check.verdict.stands},
                        {"wall", check.wall},
                        {"clean", check.verdict.clean},
                        {"standing", check.verdict.standing},
                        {"shift_m", check.verdict.shift},
                        {"turn_rad", check.verdict.turn},
                        {"reason", check.verdict.reason},
                        {"in_equilibrium", e.stands},
                        {"margin_g", e.margin},
                        {"margin_direction", {e.direction.x(), e.direction.y()}},
                        {"min_friction", nullptr},
                        {"weakest_contact", nullptr},
                        {"coupled", nullptr}};
  const BlockBalance& b = check.balance;
  out["coupled"] = {{"stands", b.stands},
                    {"margin_g", b.margin},
                    {"margin_direction", {b.direction.x(), b.direction.y()}},
                    {"min_friction", nullptr}};
  if (std::isfinite(b.min_friction)) out["coupled"]["min_friction"] = b.min_friction;
  if (std::isfinite(e.min_friction)) out["min_friction"] = e.min_friction;
  if (const Contact* c = weakest_contact(check))
    out["weakest_contact"] = {{"above", level_name(check, catalogue, c->above)},
                              {"below", level_name(check, catalogue, c->below)},
                              {"p_W", {c->p_W.x(), c->p_W.y(), c->p_W.z()}},
                              {"n_W", {c->n_W.x(), c->n_W.y(), c->n_W.z()}}};
  return document(out);
}

std::string tower_text(const TowerCheck& check, const Catalogue& catalogue) {
  const StandVerdict& verdict = check.verdict;
  const Equilibrium& e = check.equilibrium;
  std::string text = format("simulation   %s%s; moved %.3f mm and turned %.3f deg in %g s at friction %g\n",
                            verdict.stands ? "stands" : "does not stand",
                            check.wall        ? ", a wall"
                            : !verdict.stands ? ""
                            : verdict.clean   ? ", clean"
                                              : ", not clean",
                            1e3 * verdict.shift, verdict.turn * 180 / M_PI, check.seconds, check.friction);
  if (!verdict.reason.empty() && !(check.wall && verdict.stands))
    text += "             " + verdict.reason + "\n";
  text += e.stands ? format(
                         "equilibrium  holds; bears %.3f g sideways, least when pushed towards %.0f deg (x "
                         "is 0, y is 90)\n",
                         e.margin, degrees(e.direction))
                   : "equilibrium  no contact forces hold it\n";
  text += std::isfinite(e.min_friction)
              ? format("friction     contact forces balance down to %.3f (forces alone)\n", e.min_friction)
              : "friction     none up to 2 holds it\n";
  const BlockBalance& b = check.balance;
  text +=
      b.stands
          ? format("coupled      forces and motions agree; bears %.3f g towards %.0f deg\n", b.margin,
                   degrees(b.direction))
          : format("coupled      falls: no motion produces the forces; %.3g of a stone's weight unbalanced\n",
                   b.unbalanced);
  if (const Contact* c = weakest_contact(check))
    text += format("weakest      %s on %s at (%.3f, %.3f, %.3f) m\n",
                   level_name(check, catalogue, c->above).c_str(),
                   level_name(check, catalogue, c->below).c_str(), c->p_W.x(), c->p_W.y(), c->p_W.z());
  return text;
}

void draw_tower(const std::string& path, const Catalogue& catalogue, const std::vector<PlacedStone>& stones,
                const Eigen::Vector2d& site, double radius) {
  auto meshes = drawn_stones(catalogue, stones);
  double top = 0.0;
  for (const auto& item : meshes) {
    const auto box = bounds(transformed(item.mesh, item.T_W_A));
    if ((box.center().head<2>() - site).norm() < radius) top = std::max(top, box.max().z());
  }
  draw_contacts(catalogue, stones, meshes);
  write_png(path, draw(meshes, view_of_site(site, top)));
}

ExitCode exit_code(const RunResult& result) {
  switch (result.end) {
    case RunResult::End::kAllPlaced:
    case RunResult::End::kHeightReached:
    case RunResult::End::kPlanned:
      return ExitCode::kDone;
    case RunResult::End::kNothingSeen:
      return ExitCode::kNothingDetected;
    case RunResult::End::kNoPose:
      return result.height > 1 ? ExitCode::kDone : ExitCode::kNoStablePose;
    case RunResult::End::kNoPlan:
    case RunResult::End::kPlacementFailed:
      return ExitCode::kExecutionFailed;
    case RunResult::End::kStopped:
      return ExitCode::kSafetyStop;
    case RunResult::End::kInterrupted:
      return ExitCode::kInterrupted;
    case RunResult::End::kFailed:
      return ExitCode::kInternal;
  }
  return ExitCode::kInternal;
}

}  // namespace stonestack::report
