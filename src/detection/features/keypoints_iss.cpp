#include <pcl/keypoints/iss_3d.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>

#include "detection/features/keypoints.hpp"
#include "detection/features/pcl_clouds.hpp"

namespace stonestack::detection {

std::vector<int> iss_keypoints(const SurfacePoints& surface, const IssOptions& options) {
  if (surface.points.empty()) return {};
  pcl::ISSKeypoint3D<pcl::PointXYZ, pcl::PointXYZ> detector;
  const auto cloud = to_pcl(surface.points);
  detector.setInputCloud(cloud);
  detector.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>(false));
  detector.setSalientRadius(options.salient_radius);
  detector.setNonMaxRadius(options.non_max_radius);
  detector.setThreshold21(options.gamma_21);
  detector.setThreshold32(options.gamma_32);
  detector.setMinNeighbors(options.fewest_neighbours);
  detector.setNumberOfThreads(1);  // 0 crashes (PCL #4860); more threads change the order
  pcl::PointCloud<pcl::PointXYZ> unused;
  detector.compute(unused);
  const auto& found = detector.getKeypointsIndices()->indices;
  std::vector<int> indices(found.begin(), found.end());
  std::sort(indices.begin(), indices.end());
  return indices;
}

}  // namespace stonestack::detection
