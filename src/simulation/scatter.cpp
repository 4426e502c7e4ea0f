#include "simulation/scatter.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kDropHeight = 0.010;               // m under the lowest point
constexpr double kLongestFall = 5.0;                // s until a stone must rest
constexpr int kDraws = 400;                         // places tried for one stone
constexpr int kDrops = 40;                          // of them simulated
constexpr int kFields = 8;                          // begun anew before stones may lie closer together
constexpr std::array kTighter{1.0, 0.6, 0.3, 0.1};  // of the clearance, before the field counts as too small
constexpr std::size_t kOutline = 300;               // surface points that stand for an outline

using Outline = std::vector<Eigen::Vector2d>;

// Surface points seen from above; enough of them that the outline is known to a few millimetres.
Outline outline(const ContactShape& shape, const Pose& T_W_O) {
  Outline points;
  const std::size_t stride = std::max<std::size_t>(1, shape.samples.size() / kOutline);
  for (std::size_t i = 0; i < shape.samples.size(); i += stride)
    points.emplace_back((T_W_O * shape.samples[i].point).head<2>());
  return points;
}

double gap(const Outline& a, const Outline& b) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& p : a)
    for (const auto& q : b) nearest = std::min(nearest, (p - q).squaredNorm());
  return std::sqrt(nearest);
}

bool inside(const StoneField& field, const Eigen::Vector3d& p_W) {
  return ((p_W.head<2>() - field.centre).cwiseAbs().array() <= 0.5 * field.size.array()).all();
}

class Scatter {
 public:
  Scatter(TrueWorld& world, const StoneField& field) : world_(&world), field_(field) {}

  /// False when no free place is found for it.
  [[nodiscard]] bool drop(StoneIndex stone, Random random) {
    const auto& shape = *at(world_->shapes(), stone);
    for (int draw = 0, drops = 0; draw < kDraws && drops < kDrops; ++draw) {
      throw_if_interrupted();
      const Pose T_W_O = random_pose(shape, random);
      if (!free(outline(shape, T_W_O))) continue;
      ++drops;
      world_->place(stone, T_W_O);
      if (comes_to_rest(stone)) {
        outlines_.push_back(outline(shape, world_->pose(stone)));
        return true;
      }
    }
    return false;
  }

  /// Takes every stone out again; from now on they lie that far apart.
  void clear(double clearance) {
    field_.clearance = clearance;
    for (const StoneIndex stone : world_->present()) world_->put_away(stone);
    outlines_.clear();
  }

 private:
  [[nodiscard]] Pose random_pose(const ContactShape& shape, Random& random) const {
    Pose T_W_O = make_pose(Eigen::Vector3d::Zero(), random.rotation());
    double lowest = 0.0;
    for (const auto& sample : shape.samples) lowest = std::min(lowest, (T_W_O * sample.point).z());
    const double x = random.uniform(-0.5, 0.5), y = random.uniform(-0.5, 0.5);
    const Eigen::Vector3d p_W_M(field_.centre.x() + field_.size.x() * x,
                                field_.centre.y() + field_.size.y() * y, 0);
    T_W_O.translation() = p_W_M - T_W_O.linear() * shape.mass.p_O_M;
    T_W_O.translation().z() = kDropHeight - lowest + world_->table().height(p_W_M);
    return T_W_O;
  }

  [[nodiscard]] bool free(const Outline& candidate) const {
    return std::all_of(outlines_.begin(), outlines_.end(),
                       [&](const Outline& other) { return gap(candidate, other) >= field_.clearance; });
  }

  [[nodiscard]] bool comes_to_rest(StoneIndex stone) {
    constexpr double kCheckPeriod = 0.1;
    for (double t = 0; t < kLongestFall && !world_->rests(stone); t += kCheckPeriod) {
      (void)world_->wait(kCheckPeriod);
      if (!inside(field_, world_->centre_of_mass(stone))) return false;
    }
    const auto& shape = *at(world_->shapes(), stone);
    return world_->rests(stone) && free(outline(shape, world_->pose(stone)));
  }

  TrueWorld* world_;
  StoneField field_;
  std::vector<Outline> outlines_;
};

}  // namespace

void scatter_stones(TrueWorld& world, const StoneField& field, std::uint64_t seed) {
  Scatter scatter(world, field);
  const auto name = [&](StoneIndex stone) { return at(world.shapes(), stone)->name; };
  // The widest first: small ones fit between large ones, but not large ones between small ones.
  std::vector<StoneIndex> order = world.present();
  std::stable_sort(order.begin(), order.end(), [&](StoneIndex a, StoneIndex b) {
    return at(world.shapes(), a)->radius > at(world.shapes(), b)->radius;
  });
  StoneIndex homeless = kNoStone;
  // The first stones may lie so that the last does not fit, though the total area suffices.
  constexpr int kMax = kFields * static_cast<int>(kTighter.size());
  for (int k = 0; k < kMax; ++k) {
    const double clearance = kTighter[static_cast<std::size_t>(k / kFields)] * field.clearance;
    scatter.clear(clearance);
    const std::string stream = k == 0 ? "scatter " : concat("scatter anew ", k, " ");
    const auto left_over = std::find_if(order.begin(), order.end(), [&](StoneIndex stone) {
      return !scatter.drop(stone, Random::stream(seed, stream + name(stone)));
    });
    if (left_over == order.end()) {
      if (k >= kFields)
        log_info(concat("the field has no free places for the stones ", 1e3 * field.clearance,
                        " mm apart: they lie ", 1e3 * clearance, " mm apart"));
      return;
    }
    homeless = *left_over;
  }
  throw InvalidArgument(concat("no free place for stone ", name(homeless), " in a field of ", field.size.x(),
                               " x ", field.size.y(), " m with ", kTighter.back() * field.clearance,
                               " m between stones, scattered ", kMax,
                               " times; use fewer stones or a larger field"));
}

}  // namespace stonestack::simulation
