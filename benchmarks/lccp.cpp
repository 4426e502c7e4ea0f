#include "lccp.hpp"

#include <pcl/point_types.h>
#include <pcl/segmentation/lccp_segmentation.h>
#include <pcl/segmentation/supervoxel_clustering.h>

#include <map>

namespace stonestack::bench {
namespace {

using Point = pcl::PointXYZRGBA;

// PCL's example lccp_segmentation.
constexpr float kVoxelResolution = 0.0075F;  // m
constexpr float kSeedResolution = 0.03F;     // m
constexpr float kSpatialImportance = 1.0F, kNormalImportance = 4.0F;
constexpr float kConcavityTolerance = 10.0F;  // deg
constexpr float kSmoothness = 0.1F;
constexpr int kMinSegment = 3;  // supervoxels

}  // namespace

std::vector<int> lccp_labels(const DepthImage& image, const Plane& table_C, double lowest, int fewest) {
  std::vector<int> labels(image.z.size(), 0);
  const pcl::PointCloud<Point>::Ptr cloud(new pcl::PointCloud<Point>);
  std::vector<std::size_t> pixel;
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      const auto i = static_cast<std::size_t>(v * image.camera.width + u);
      if (!(image.z[i] > 0)) continue;
      const Eigen::Vector3d p = image.z[i] * deproject(image.camera, u, v);
      if (table_C.distance(p) < lowest) continue;
      Point point;
      point.getVector3fMap() = p.cast<float>();
      cloud->push_back(point);
      pixel.push_back(i);
    }
  if (cloud->empty()) return labels;
  pcl::SupervoxelClustering<Point> supervoxels(kVoxelResolution, kSeedResolution);
  supervoxels.setUseSingleCameraTransform(false);
  supervoxels.setInputCloud(cloud);
  supervoxels.setColorImportance(0.0F);
  supervoxels.setSpatialImportance(kSpatialImportance);
  supervoxels.setNormalImportance(kNormalImportance);
  std::map<std::uint32_t, pcl::Supervoxel<Point>::Ptr> clusters;
  supervoxels.extract(clusters);
  std::multimap<std::uint32_t, std::uint32_t> adjacent;
  supervoxels.getSupervoxelAdjacency(adjacent);
  pcl::LCCPSegmentation<Point> lccp;
  lccp.setConcavityToleranceThreshold(kConcavityTolerance);
  lccp.setSmoothnessCheck(true, kVoxelResolution, kSeedResolution, kSmoothness);
  lccp.setKFactor(0);
  lccp.setInputSupervoxels(clusters, adjacent);
  lccp.setMinSegmentSize(kMinSegment);
  lccp.segment();
  const auto labelled = supervoxels.getLabeledCloud();  // a point each of the input
  pcl::PointCloud<pcl::PointXYZL> relabelled = *labelled;
  lccp.relabelCloud(relabelled);
  std::map<std::uint32_t, int> size, name;
  for (const auto& point : relabelled)
    if (point.label > 0) ++size[point.label];
  for (std::size_t k = 0; k < relabelled.size(); ++k) {
    const std::uint32_t label = relabelled[k].label;
    if (label == 0 || size[label] < fewest) continue;
    labels[pixel[k]] = name.try_emplace(label, static_cast<int>(name.size()) + 1).first->second;
  }
  return labels;
}

}  // namespace stonestack::bench
