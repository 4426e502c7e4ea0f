#include <algorithm>
#include <cmath>

#include "stacking/builder.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kCertainEnough = 0.6;  // of a stone and its pose: likelier than all else together
constexpr double kLookHeight = 0.12;    // m: about the middle of a tower of three or four
constexpr double kLow = 0.90;           // cosine: more than 26 deg off the vertical, so that sides are seen
constexpr double kOtherSide = 0.5;      // cosine between two level directions that show different sides
constexpr double kOnTable = 0.015;      // m: a lowest stone higher than that stands on something unseen

Eigen::Vector2d level_direction(const Pose& T_W_C) {
  return T_W_C.linear().col(2).head<2>().normalized();
}

}  // namespace

void Builder::look_at_site(std::vector<Look>& looks) {
  const Eigen::Vector2d& site = cell_.layout.site;
  if (view_of_site(looks, site) == SiteView::kFree) return;
  std::vector<Pose> poses =
      look_poses(cell_.layout, {site.x(), site.y(), kLookHeight}, options_.look_distance);
  std::erase_if(poses, [](const Pose& T_W_C) { return -T_W_C.linear()(2, 2) > kLow; });
  std::vector<Look> of_site{look_from(poses, true)};
  site_ = view_of_site(of_site, site);
  if (site_ == SiteView::kTaken) {
    report("something stands at the site already");
    const Eigen::Vector2d seen_along = level_direction(of_site.front().T_W_C);
    std::erase_if(poses,
                  [&](const Pose& T_W_C) { return level_direction(T_W_C).dot(seen_along) > kOtherSide; });
    try {
      of_site.push_back(look_from(poses, true));
    } catch (const DeviceError&) {
      report("it is seen from one side only: the camera does not reach another");
    }
  }
  looks.insert(looks.end(), of_site.begin(), of_site.end());
}

void Builder::report_doubtful(const std::vector<Sighting>& sightings) {
  for (const Sighting& seen : sightings)
    if (seen.certainty < kCertainEnough && doubtful_.insert(seen.stone).second)
      report(concat(name(seen.stone),
                    " may be turned or another stone of like shape: it is seen with a certainty of ",
                    std::lround(100 * seen.certainty), " %"));
}

std::vector<PlacedStone> Builder::standing(const std::vector<Sighting>& sightings) const {
  std::vector<PlacedStone> seen;
  for (const Sighting& sighting : sightings) seen.push_back({sighting.stone, sighting.T_W_O});
  return sort_by_site(shapes_, cell_.layout.site, seen).stack;
}

std::string Builder::fault_of_site() const {
  if (site_ == SiteView::kFree) return "";
  if (site_ == SiteView::kUnseen)
    return "no look shows whether something stands at the site: check the camera, and that the site is on "
           "the table";
  if (belief_.stack.empty())
    return "something stands at the site that is none of the known stones: clear the site, or name another";
  const PlacedStone& base = belief_.stack.front();
  const double low = lowest(*shapes_[static_cast<std::size_t>(base.stone)], base.T_W_O);
  if (low > kOnTable)
    return concat(name(base.stone), " stands at the site, ", std::lround(1000 * low),
                  " mm above the table, on something that is not seen: clear the site, or name another");
  return "";
}

}  // namespace stonestack::stacking
