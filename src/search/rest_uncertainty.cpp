#include "search/rest_uncertainty.hpp"

#include <cmath>

#include "physics/shape.hpp"

namespace stonestack::search {
namespace {

constexpr double kNarrowest = 0.005;  // m: contacts nearer to each other carry as if they were so far apart

/// Distance of a point from a shape that a stone may have instead of its model; 0 where it has none.
double gap_to(const ShapeList& possible, const PlacedStone& placed, const Eigen::Vector3d& p_W) {
  const auto& shape = at(possible, placed.stone);
  return shape ? shape->distance.distance(placed.T_W_O.inverse() * p_W) : 0.0;
}

/// Slope of the plane through the gaps over the contacts, by least squares.
double slope_of(std::span<const Contact> contacts, const std::vector<double>& gaps) {
  const auto count = static_cast<double>(contacts.size());
  Eigen::Vector2d p_W_mean = Eigen::Vector2d::Zero();
  double gap_mean = 0.0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    p_W_mean += contacts[k].p_W.head<2>() / count;
    gap_mean += gaps[k] / count;
  }
  Eigen::Matrix2d spread = count * kNarrowest * kNarrowest * Eigen::Matrix2d::Identity();
  Eigen::Vector2d skew = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Eigen::Vector2d off = contacts[k].p_W.head<2>() - p_W_mean;
    spread += off * off.transpose();
    skew += (gaps[k] - gap_mean) * off;
  }
  return (spread.inverse() * skew).norm();
}

}  // namespace

double rest_uncertainty(const SearchContext& context, const Stack& below, const PlacedStone& placed,
                        std::span<const Contact> contacts) {
  const auto* draws = context.problem->possible_shapes;
  if (draws == nullptr || draws->empty() || contacts.size() < 2) return 0.0;
  double squares = 0.0;
  std::vector<double> gaps(contacts.size());
  for (const ShapeList& possible : *draws) {
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const Contact& contact = contacts[k];
      gaps[k] = gap_to(possible, placed, contact.p_W);
      if (contact.below != kTable)
        gaps[k] += gap_to(possible, below.stones[static_cast<std::size_t>(contact.below)], contact.p_W);
    }
    const double slope = slope_of(contacts, gaps);
    squares += slope * slope;
  }
  return std::sqrt(squares / static_cast<double>(draws->size()));
}

}  // namespace stonestack::search
