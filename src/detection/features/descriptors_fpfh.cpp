#include <pcl/console/print.h>
#include <pcl/features/fpfh.h>
#include <pcl/search/kdtree.h>
#include <tbb/parallel_for.h>

#include "detection/features/descriptors.hpp"
#include "detection/features/pcl_clouds.hpp"

namespace stonestack::detection {
namespace {

constexpr std::size_t kChunk = 128;  // keypoints a task; neighbouring ones share their simplified histograms

}  // namespace

Features fpfh_features(const SurfacePoints& surface, std::span<const int> keypoints, double radius) {
  Eigen::MatrixXf rows(static_cast<Eigen::Index>(keypoints.size()), 33);
  if (keypoints.empty()) return finite_features(surface, keypoints, rows);
  const auto cloud = to_pcl(surface.points);
  const auto normals = to_pcl_normals(surface.normals);
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // it prints every keypoint that it drops
  const auto tree = pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>(false);
  tree->setInputCloud(cloud);
  tbb::parallel_for(std::size_t{0}, (keypoints.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    const auto some = keypoints.subspan(chunk * kChunk, std::min(kChunk, keypoints.size() - chunk * kChunk));
    pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimator;
    estimator.setInputCloud(cloud);
    estimator.setInputNormals(normals);
    estimator.setSearchMethod(tree);
    estimator.setIndices(pcl::make_shared<pcl::Indices>(some.begin(), some.end()));
    estimator.setRadiusSearch(radius);
    pcl::PointCloud<pcl::FPFHSignature33> result;
    estimator.compute(result);
    for (std::size_t k = 0; k < some.size(); ++k)
      rows.row(static_cast<Eigen::Index>(chunk * kChunk + k)) =
          Eigen::Map<const Eigen::RowVectorXf>(result[k].histogram, 33);
  });
  return finite_features(surface, keypoints, rows);
}

}  // namespace stonestack::detection
