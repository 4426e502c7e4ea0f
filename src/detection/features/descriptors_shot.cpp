#include <pcl/console/print.h>
#include <pcl/features/shot.h>
#include <pcl/search/kdtree.h>
#include <tbb/parallel_for.h>

#include "detection/features/descriptors.hpp"
#include "detection/features/pcl_clouds.hpp"

namespace stonestack::detection {
namespace {

constexpr std::size_t kShotChunk = 64;  // keypoints a task

}  // namespace

Features shot_features(const SurfacePoints& surface, std::span<const int> keypoints, double radius) {
  Eigen::MatrixXf rows(static_cast<Eigen::Index>(keypoints.size()), 352);
  if (keypoints.empty()) return finite_features(surface, keypoints, rows);
  const auto cloud = to_pcl(surface.points);
  const auto normals = to_pcl_normals(surface.normals);
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // it prints every keypoint that it drops
  const auto tree = pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>(false);
  tree->setInputCloud(cloud);  // once; the estimators find it in place
  tbb::parallel_for(std::size_t{0}, (keypoints.size() + kShotChunk - 1) / kShotChunk, [&](std::size_t chunk) {
    const auto some =
        keypoints.subspan(chunk * kShotChunk, std::min(kShotChunk, keypoints.size() - chunk * kShotChunk));
    pcl::SHOTEstimation<pcl::PointXYZ, pcl::Normal, pcl::SHOT352> estimator;
    estimator.setInputCloud(cloud);
    estimator.setInputNormals(normals);
    estimator.setSearchMethod(tree);
    estimator.setIndices(pcl::make_shared<pcl::Indices>(some.begin(), some.end()));
    estimator.setRadiusSearch(radius);
    pcl::PointCloud<pcl::SHOT352> result;
    estimator.compute(result);
    for (std::size_t k = 0; k < some.size(); ++k)
      rows.row(static_cast<Eigen::Index>(chunk * kShotChunk + k)) =
          Eigen::Map<const Eigen::RowVectorXf>(result[k].descriptor, 352);
  });
  return finite_features(surface, keypoints, rows);
}

}  // namespace stonestack::detection
