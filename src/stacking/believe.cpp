#include "stacking/believe.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "geometry/pose_json.hpp"
#include "stacking/steady.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/physics/settle.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kAboveTable = 0.012;  // m: lower than this, a stone lies on the table
constexpr int kSeatTries = 12;         // the measured pose, then displaced ones
constexpr double kFloats = 0.05;       // m above the table: higher, nothing loose can lie
constexpr double kWithin = 0.006;      // m
constexpr double kTouches = 0.003;     // m: a loose stone that near to the stack touches it
constexpr double kApart = 0.006;  // m: planned as far from loose stones, for poses err by as much as kTouches
constexpr double kBaseAtSite = 0.12;  // m: the first stone lies no further from the site

const ContactShape& shape_of(const ShapeList& shapes, int stone) {
  return *shapes[static_cast<std::size_t>(stone)];
}

/// Does a stone at that pose rest over `below`, by geometry alone: clear of the table, its centre over the
/// other's extent?
bool rests_over(const ShapeList& shapes, const PlacedStone& upper, const PlacedStone& below) {
  const auto& shape = shape_of(shapes, upper.stone);
  const auto& base = shape_of(shapes, below.stone);
  const Eigen::Vector3d com = upper.T_W_O * shape.mass.p_O_M;
  const Eigen::Vector3d com_below = below.T_W_O * base.mass.p_O_M;
  return lowest(shape, upper.T_W_O) > kAboveTable && com.z() > com_below.z() &&
         (com - com_below).head<2>().norm() < base.radius;
}

std::vector<Sighting>::iterator find(std::vector<Sighting>& sightings, int stone) {
  return std::find_if(sightings.begin(), sightings.end(),
                      [&](const Sighting& s) { return s.stone == stone; });
}

/// May a stone lie loose at that pose: on the table, and not within the stack? Deeper than kWithin into a
/// stone of the stack, what was seen is a part of the stack taken for another stone.
bool may_lie_loose(const ShapeList& shapes, const std::vector<PlacedStone>& stack, const Sighting& seen) {
  const auto& shape = shape_of(shapes, seen.stone);
  if (lowest(shape, seen.T_W_O) > kFloats) return false;
  return std::none_of(stack.begin(), stack.end(), [&](const PlacedStone& placed) {
    const auto& other = shape_of(shapes, placed.stone);
    const Pose T_P_O = placed.T_W_O.inverse() * seen.T_W_O;
    return std::any_of(shape.samples.begin(), shape.samples.end(), [&](const SurfaceSample& sample) {
      return other.distance.distance(T_P_O * sample.point) < -kWithin;
    });
  });
}

bool in_place(const Sighting& seen, const PlacedStone& expected) {
  const auto error = difference(seen.T_W_O, expected.T_W_O);
  return error.translation < kConsistent && error.angle < kConsistentTurn;
}

/// Is a stone that was expected higher still up there: in place, or moved but resting over the hidden one?
bool something_stands_on(const ShapeList& shapes, const std::vector<Sighting>& sightings,
                         const std::vector<PlacedStone>& expected, std::size_t hidden) {
  for (std::size_t i = hidden + 1; i < expected.size(); ++i)
    for (const auto& seen : sightings) {
      if (seen.stone != expected[i].stone) continue;
      if (in_place(seen, expected[i]) || rests_over(shapes, {seen.stone, seen.T_W_O}, expected[hidden]))
        return true;
    }
  return false;
}

/// The measured pose, seated on the stack below. It is seen to rest, so when the measured pose itself slides
/// off, poses as near as the camera may err are tried; the rest pose nearest to the measurement is believed,
/// if it is near at all.
Pose seated(const ShapeList& shapes, const Stack& below, const PlacedStone& measured) {
  SettleOptions options;
  options.world.friction =
      0.5;  // it is seen to rest, so let it: the low planning friction would make it slide
  Random random = Random::stream(static_cast<std::uint64_t>(measured.stone), "seated");
  Pose tried = measured.T_W_O, best = measured.T_W_O;
  double nearest = kBelievable;
  for (int k = 0; k < kSeatTries && nearest > kConsistent; ++k) {
    const Pose lifted = Eigen::Translation3d(0, 0, kSettleFrom) * tried;
    const SettleResult settled = settle(shapes, below, measured.stone, lifted, options);
    const double off = off_measured(settled.T_W_O, measured.T_W_O);
    if (settled.rests && off < nearest) {
      nearest = off;
      best = settled.T_W_O;
    }
    tried = displaced_as_measured(measured.T_W_O, random);
  }
  return best;
}

}  // namespace

Belief believe(const ShapeList& shapes, const CellLayout& layout, const std::vector<PlacedStone>& expected,
               const std::vector<Sighting>& sightings) {
  std::vector<Sighting> left = sightings;
  Belief belief;
  for (std::size_t i = 0; i < expected.size(); ++i) {  // from the table up
    const auto found = find(left, expected[i].stone);
    if (found == left.end()) {
      // Hidden by what stands on it, or gone: it is there if something still stands on it.
      if (!something_stands_on(shapes, left, expected, i)) break;
      belief.stack.push_back(expected[i]);
      continue;
    }
    const PlacedStone measured{found->stone, found->T_W_O};
    const bool first = belief.stack.empty();
    const bool at_site = (measured.T_W_O.translation().head<2>() - layout.site).norm() < kBaseAtSite;
    if (first ? !at_site : !rests_over(shapes, measured, belief.stack.back())) break;
    const bool newest = i + 1 == expected.size();
    // Keeping what was measured when it was on top: no random walk of the base, and no doubt about what is
    // half hidden while the stone upon it has not moved.
    const auto above = newest ? left.end() : find(left, expected[i + 1].stone);
    const bool carries = above != left.end() && in_place(*above, expected[i + 1]);
    const bool unmoved = !newest && (carries || in_place(*found, expected[i]));
    belief.stack.push_back(
        {measured.stone, unmoved ? expected[i].T_W_O : seated(shapes, Stack{belief.stack}, measured)});
    left.erase(found);
  }
  for (const auto& sighting : left)
    if (may_lie_loose(shapes, belief.stack, sighting))
      belief.loose.push_back({sighting.stone, sighting.T_W_O});
  std::sort(belief.loose.begin(), belief.loose.end(),
            [](const auto& a, const auto& b) { return a.stone < b.stone; });
  return belief;
}

Belief sort_by_site(const ShapeList& shapes, const Eigen::Vector2d& site,
                    const std::vector<PlacedStone>& stones) {
  Belief belief{{}, stones};
  std::sort(belief.loose.begin(), belief.loose.end(), [&](const PlacedStone& a, const PlacedStone& b) {
    const double za = (a.T_W_O * shape_of(shapes, a.stone).mass.p_O_M).z();
    const double zb = (b.T_W_O * shape_of(shapes, b.stone).mass.p_O_M).z();
    return za != zb ? za < zb : a.stone < b.stone;
  });
  for (auto it = belief.loose.begin(); it != belief.loose.end();) {
    const bool near = (it->T_W_O.translation().head<2>() - site).norm() < kBaseAtSite;
    const bool stacked = belief.stack.empty() ? near : rests_over(shapes, *it, belief.stack.back());
    if (stacked) belief.stack.push_back(*it);
    it = stacked ? belief.loose.erase(it) : it + 1;
  }
  std::sort(belief.loose.begin(), belief.loose.end(),
            [](const auto& a, const auto& b) { return a.stone < b.stone; });
  return belief;
}

bool lie_within(const ShapeList& shapes, const PlacedStone& a, const PlacedStone& b, double gap) {
  const ContactShape &A = shape_of(shapes, a.stone), &B = shape_of(shapes, b.stone);
  if ((a.T_W_O * A.mass.p_O_M - b.T_W_O * B.mass.p_O_M).norm() > A.radius + B.radius + gap) return false;
  const auto reaches = [gap](const ContactShape& from, const ContactShape& to, const Pose& T_to_from) {
    return std::any_of(from.samples.begin(), from.samples.end(), [&](const SurfaceSample& s) {
      return to.distance.distance(T_to_from * s.point) < gap;
    });
  };
  const Pose T_B_A = b.T_W_O.inverse() * a.T_W_O;
  return reaches(A, B, T_B_A) || reaches(B, A, T_B_A.inverse());
}

bool leans_on_loose(const ShapeList& shapes, const std::vector<PlacedStone>& loose, const PlacedStone& placed,
                    const std::vector<PlacedStone>& below) {
  const auto is_placed = [&](int stone) {
    return stone == placed.stone || std::any_of(below.begin(), below.end(), [&](const PlacedStone& lower) {
             return lower.stone == stone;
           });
  };
  return std::any_of(loose.begin(), loose.end(), [&](const PlacedStone& other) {
    return !is_placed(other.stone) && lie_within(shapes, other, placed, kApart);
  });
}

std::optional<Stray> stray_at_stack(const ShapeList& shapes, const Belief& belief) {
  for (std::size_t level = 0; level < belief.stack.size(); ++level)
    for (const PlacedStone& loose : belief.loose)
      if (lie_within(shapes, loose, belief.stack[level], kTouches)) return Stray{level, loose};
  return std::nullopt;
}

SceneObject unseen_field(const CellLayout& layout) {
  constexpr double kHeight = 0.25;  // m: the highest a stone of the field may reach
  const Eigen::Vector3d size(layout.field_size.x() + 0.2, layout.field_size.y() + 0.2, kHeight);
  return {"unseen field",
          {make_box(size)},
          make_pose({layout.field_centre.x(), layout.field_centre.y(), kHeight / 2})};
}

SceneObject unseen_site(const CellLayout& layout) {
  constexpr double kHeight = 0.45, kWidth = 0.20;  // m
  return {"unseen site",
          {make_box({kWidth, kWidth, kHeight})},
          make_pose({layout.site.x(), layout.site.y(), kHeight / 2})};
}

SiteView view_of_site(const std::vector<Look>& looks, const Eigen::Vector2d& site) {
  constexpr double kRadius = 0.10;     // m about the site
  constexpr double kOnTable = 0.015;   // m: higher is something
  constexpr double kSomething = 8e-4;  // m^2 of it that count, seen along the camera's rays
  constexpr double kEnough = 0.6;      // of the circle, in one look
  constexpr int kStride = 2;
  bool free = false;
  for (const Look& look : looks) {
    const CameraIntrinsics& camera = look.image.camera;
    double table = 0.0, above = 0.0;
    for (int v = 0; v < camera.height; v += kStride)
      for (int u = 0; u < camera.width; u += kStride) {
        const double z = look.image.at(u, v);
        if (!(z > 0.0)) continue;
        const Eigen::Vector3d p_W = look.T_W_C * Eigen::Vector3d(z * deproject(camera, u, v));
        if ((p_W.head<2>() - site).norm() > kRadius) continue;
        (p_W.z() > kOnTable ? above : table) += kStride * kStride * z * z / (camera.fx * camera.fy);
      }
    if (above > kSomething) return SiteView::kTaken;
    free = free || table > kEnough * M_PI * kRadius * kRadius;
  }
  return free ? SiteView::kFree : SiteView::kUnseen;
}

bool same_place(const ShapeList& shapes, const PlacedStone& a, const PlacedStone& b, double shift,
                double turn) {
  if (a.stone != b.stone) return false;
  const Eigen::Vector3d& p_O_M = shape_of(shapes, a.stone).mass.p_O_M;
  return (a.T_W_O * p_O_M - b.T_W_O * p_O_M).norm() <= shift && difference(a.T_W_O, b.T_W_O).angle <= turn;
}

double lowest(const ContactShape& shape, const Pose& T_W_O) {
  double z = 1e9;
  for (const auto& sample : shape.samples) z = std::min(z, (T_W_O * sample.point).z());
  return z;
}

double top_height(const ShapeList& shapes, const std::vector<PlacedStone>& stones) {
  double top = 0.0;
  for (const auto& placed : stones)
    for (const auto& sample : shape_of(shapes, placed.stone).samples)
      top = std::max(top, (placed.T_W_O * sample.point).z());
  return top;
}

PickAndPlaceTask make_task(const Catalogue& catalogue, const Belief& belief, int stone, const Pose& T_W_O,
                           const Joints& q_start) {
  PickAndPlaceTask task;
  task.stone = &catalogue.stones[static_cast<std::size_t>(stone)];
  task.T_W_O_place = T_W_O;
  task.q_start = q_start;
  task.support = static_cast<int>(belief.stack.size()) - 1;
  for (std::size_t i = 0; i < belief.loose.size(); ++i) {
    if (belief.loose[i].stone != stone) continue;
    task.object = static_cast<int>(belief.stack.size() + i);
    task.T_W_O_pick = belief.loose[i].T_W_O;
    return task;
  }
  throw InvalidArgument(concat(task.stone->name, " is not among the loose stones"));
}

std::string describe(const Catalogue& catalogue, const Belief& belief) {
  const auto names = [&](const std::vector<PlacedStone>& stones) {
    std::string text;
    for (const auto& placed : stones)
      text += (text.empty() ? "" : ", ") + catalogue.stones[static_cast<std::size_t>(placed.stone)].name;
    return text.empty() ? std::string("none") : text;
  };
  return concat("stack: ", names(belief.stack), "; loose: ", names(belief.loose));
}

std::string belief_json(const Catalogue& catalogue, const Belief& belief) {
  const auto list = [&](const std::vector<PlacedStone>& stones) {
    nlohmann::json array = nlohmann::json::array();
    for (const auto& placed : stones)
      array.push_back({{"stone", catalogue.stones[static_cast<std::size_t>(placed.stone)].name},
                       {"T_W_O", pose_json(placed.T_W_O)}});
    return array;
  };
  return nlohmann::json{{"stack", list(belief.stack)}, {"loose", list(belief.loose)}}.dump();
}

std::string placement_json(const Catalogue& catalogue, const Placement& placement) {
  return nlohmann::json{{"stone", catalogue.stones[static_cast<std::size_t>(placement.stone)].name},
                        {"T_W_O", pose_json(placement.T_W_O)},
                        {"cost", placement.cost}}
      .dump();
}

}  // namespace stonestack::stacking
