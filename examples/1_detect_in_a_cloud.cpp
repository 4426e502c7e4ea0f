// Finds stones in a point cloud: 1_detect_in_a_cloud [CLOUD.ply]. Without a file a scene is simulated.
#include <cstdio>

#include "stonestack/stonestack.hpp"

int main(int argc, char** argv) try {
  const stonestack::Catalogue catalogue = stonestack::read_catalogue(stonestack::data_path("stones"));

  stonestack::DepthImage image;
  if (argc > 1) {
    const stonestack::Cloud cloud_C = stonestack::geometry::read_cloud(argv[1]);
    const auto camera = stonestack::geometry::fit_camera(cloud_C);  // empty if the cloud has no rows
    image = stonestack::geometry::to_depth_image(
        cloud_C, camera ? *camera : stonestack::geometry::camera_for(cloud_C));
  } else {
    image = stonestack::simulation::render_scene(catalogue.stones, stonestack::first_stones(3), {}).depth;
  }

  const stonestack::DetectionModels models(catalogue.stones);
  const stonestack::DetectionResult result = stonestack::detect_stones(image, models);
  for (const auto& found : result.detections) {
    const Eigen::Vector3d p_C = found.T_C_O.translation();
    std::printf("%-12s at %.3f %.3f %.3f m, score %.2f, certainty %.2f\n",
                catalogue[found.stone].name.c_str(), p_C.x(), p_C.y(), p_C.z(), found.score, found.certainty);
  }
  if (result.detections.empty()) std::printf("nothing found: %s\n", result.note.c_str());
  return result.detections.empty() ? 4 : 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
