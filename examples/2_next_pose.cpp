// Proposes where the next stone can rest: one stone stands at the site, two lie loose.
#include <cstdio>

#include "stonestack/stonestack.hpp"

int main() try {
  const stonestack::Catalogue catalogue = stonestack::read_catalogue(stonestack::data_path("stones"));
  const stonestack::ShapeList shapes = stonestack::make_contact_shapes(catalogue.stones);

  stonestack::SearchProblem problem;
  problem.shapes = &shapes;
  problem.site = {0.70, 0.28};  // m, in W
  for (const int number : {0, 1, 2})
    problem.available.push_back({stonestack::StoneIndex(number), stonestack::Pose::Identity()});

  stonestack::SearchOptions options;
  options.max_tilt = 3.14;  // no arm is asked: a stone may be turned any way up
  const stonestack::SearchResult first = stonestack::find_next_pose(problem, options);
  if (first.best.empty()) {
    std::printf("no stable pose: %s\n", first.reason.c_str());
    return 5;
  }
  const auto& best = first.best.front();
  const Eigen::Vector3d p_W = best.T_W_O.translation();
  std::printf("%s at %.3f %.3f %.3f m, predicted success %.2f, %zu more stones planned on it\n",
              catalogue[best.stone].name.c_str(), p_W.x(), p_W.y(), p_W.z(), best.predicted_success,
              best.then.size());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
