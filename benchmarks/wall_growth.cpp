#include "wall_growth.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

constexpr int kCourses = 3;
constexpr double kPieceLength = 0.5;    // m of the piece that is repeated
constexpr double kPieceGap = 0.004;     // m between pieces, as between neighbours of a course
constexpr int kPlannedStones = 2;       // of which a row is the mean
constexpr int kMissing = 4;             // stones that the wall lacks, more than are planned
constexpr std::size_t kAvailable = 12;  // stones to choose from

/// A planned piece of wall, in its own frame, and the stones that it left over.
struct WallPiece {
  std::vector<WallPlacement> placements;  ///< poses in the piece's frame
  std::vector<PlacedStone> left;
  double length = 0.0;
};

WallPiece plan_piece(const StructureBenchOptions& options, const StonePool& pool) {
  const SearchProblem problem = draw_problem(pool, options.seed, 0, options.stones);
  WallTarget target;
  target.length = kPieceLength;
  target.levels = kCourses;
  const WallPlan plan = plan_wall(problem, target, options.search);
  throw_if_interrupted();
  WallPiece piece{plan.placements, problem.available, plan.metrics.length};
  for (WallPlacement& placement : piece.placements) {
    placement.placement.T_W_O = plan.T_W_V.inverse() * placement.placement.T_W_O;
    std::erase_if(piece.left, [&](const PlacedStone& s) { return s.stone == placement.placement.stone; });
  }
  require(piece.placements.size() > kMissing && piece.left.size() >= kAvailable, "a piece of wall took ",
          piece.placements.size(), " of ", problem.available.size(), " stones; give more with --stones");
  piece.left.resize(kAvailable);
  return piece;
}

/// A wall of which `standing` stones stand, with copies of the shapes of a piece.
struct LongWall {
  ShapeList shapes;
  SearchProblem problem;  ///< its shapes are to be set
  WallBegun begun;
  WallTarget target;
};

LongWall long_wall(const StonePool& pool, const WallPiece& piece, int standing) {
  LongWall wall;
  wall.shapes = pool.shapes;
  wall.problem.available = piece.left;
  const auto per_piece = static_cast<int>(piece.placements.size());
  const int pieces = (standing + kMissing + per_piece - 1) / per_piece;
  struct Copy {
    PlacedStone stone;
    int course;
  };
  std::vector<Copy> copies;
  for (int k = 0; k < pieces; ++k) {
    const Pose T_V_piece(Eigen::Translation3d(k * (piece.length + kPieceGap), 0, 0));
    for (const WallPlacement& placed : piece.placements) {
      const StoneIndex stone(static_cast<int>(wall.shapes.size()));
      wall.shapes.push_back(at(pool.shapes, placed.placement.stone));
      copies.push_back({{stone, T_V_piece * placed.placement.T_W_O}, placed.course});
    }
  }
  std::stable_sort(copies.begin(), copies.end(), [](const Copy& p, const Copy& q) {
    return p.course != q.course ? p.course < q.course
                                : p.stone.T_W_O.translation().x() < q.stone.T_W_O.translation().x();
  });
  copies.resize(static_cast<std::size_t>(standing));
  for (const Copy& copy : copies) {
    wall.problem.stack.stones.push_back(copy.stone);
    wall.begun.courses.push_back(copy.course);
  }
  wall.target.length = pieces * (piece.length + kPieceGap) - kPieceGap;
  wall.target.levels = kCourses;
  return wall;
}

/// Ends a plan from its listener.
struct EnoughPlanned {};

GrowthPoint measure_point(const StructureBenchOptions& options, const StonePool& pool, const WallPiece& piece,
                          int standing) {
  LongWall wall = long_wall(pool, piece, standing);
  wall.problem.shapes = &wall.shapes;
  GrowthPoint point{standing, -1};  // the listener hears of the stones that stand first
  const double start = processor_seconds();
  double begun = start, last = start;
  try {
    (void)plan_wall(
        wall.problem, wall.target, options.search,
        [&](const std::string&) {
          last = processor_seconds();
          if (++point.planned == 0) begun = last;
          if (point.planned == kPlannedStones) throw EnoughPlanned();
        },
        wall.begun);
  } catch (const EnoughPlanned&) {
    // what is measured has been done
  }
  point.set_up = begun - start;
  point.each = (last - begun) / std::max(1, point.planned);
  std::fprintf(stderr, "%d stones stand: %d more, %.1f CPU s each, %.1f to begin\n", standing, point.planned,
               point.each, point.set_up);
  return point;
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GrowthPoint, standing, planned, set_up, each)

std::vector<GrowthPoint> measure_wall_growth(const StructureBenchOptions& options, const StonePool& pool,
                                             const std::vector<int>& standing, Draws& draws) {
  std::optional<WallPiece> piece;
  std::vector<GrowthPoint> points =
      draws.outcomes(pool.name + " growth", static_cast<int>(standing.size()), [&](int k) {
        if (!piece) piece = plan_piece(options, pool);
        return measure_point(options, pool, *piece, standing[static_cast<std::size_t>(k)]);
      });
  std::erase_if(points, [](const GrowthPoint& point) { return point.planned <= 0; });
  return points;
}

}  // namespace stonestack::bench
