#include <pcl/console/print.h>
#include <pcl/features/rops_estimation.h>
#include <pcl/search/kdtree.h>
#include <tbb/parallel_for.h>

#include "detection/features/descriptors.hpp"
#include "detection/features/pcl_clouds.hpp"
#include "detection/features/triangulate.hpp"

namespace stonestack::detection {
namespace {

constexpr std::size_t kRopsChunk = 128;  // keypoints a task; every estimator indexes all triangles anew
constexpr int kLength = 135;             // 5 x 5 bins and 3 rotations: PCL's output type holds no other

}  // namespace

Features rops_features(const TriangulatedSurface& mesh, std::span<const int> keypoints, double radius) {
  Eigen::MatrixXf rows(static_cast<Eigen::Index>(keypoints.size()), kLength);
  if (keypoints.empty() || mesh.triangles.empty())
    return {};  // without triangles PCL returns nothing, silently
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  const auto cloud = to_pcl(mesh.surface.points);
  const auto tree = pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>(false);
  tree->setInputCloud(cloud);
  std::vector<pcl::Vertices> triangles(mesh.triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    triangles[t].vertices.assign(mesh.triangles[t].data(), mesh.triangles[t].data() + 3);
  tbb::parallel_for(std::size_t{0}, (keypoints.size() + kRopsChunk - 1) / kRopsChunk, [&](std::size_t chunk) {
    const auto some =
        keypoints.subspan(chunk * kRopsChunk, std::min(kRopsChunk, keypoints.size() - chunk * kRopsChunk));
    pcl::ROPSEstimation<pcl::PointXYZ, pcl::Histogram<kLength>> estimator;
    estimator.setInputCloud(cloud);
    estimator.setSearchMethod(tree);
    estimator.setIndices(pcl::make_shared<pcl::Indices>(some.begin(), some.end()));
    estimator.setRadiusSearch(radius);
    estimator.setSupportRadius(static_cast<float>(radius));
    estimator.setTriangles(triangles);
    pcl::PointCloud<pcl::Histogram<kLength>> result;
    estimator.compute(result);
    for (std::size_t k = 0; k < some.size(); ++k) {
      auto row = rows.row(static_cast<Eigen::Index>(chunk * kRopsChunk + k));
      if (k < result.size())
        row = Eigen::Map<const Eigen::RowVectorXf>(result[k].histogram, kLength);
      else
        row.setConstant(std::nanf(""));
    }
  });
  return finite_features(mesh.surface, keypoints, rows);
}

}  // namespace stonestack::detection
