#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>

#include "detection/features/matching.hpp"

namespace stonestack::detection {
namespace {

/// PCL's trees take points of a type; here points are rows of a matrix, so the point is only the row's
/// number.
class RowOf : public pcl::PointRepresentation<pcl::PointXYZ> {
 public:
  explicit RowOf(Eigen::MatrixXf rows) : rows_(std::move(rows)) {
    nr_dimensions_ = static_cast<int>(rows_.cols());
  }
  void copyToFloatArray(const pcl::PointXYZ& point, float* out) const override {
    Eigen::Map<Eigen::RowVectorXf>(out, rows_.cols()) = rows_.row(static_cast<Eigen::Index>(point.x));
  }

 private:
  Eigen::MatrixXf rows_;
};

pcl::PointXYZ number(Eigen::Index row) {
  return {static_cast<float>(row), 0.0F, 0.0F};  // exact up to 16 million
}

}  // namespace

std::vector<Correspondence> match_features_kdtree(const Features& scene, const Features& model,
                                                  int neighbours) {
  std::vector<Correspondence> matches;
  const Eigen::Index count = model.descriptors.rows();
  if (scene.descriptors.rows() == 0 || count == 0 || neighbours < 1) return matches;
  Eigen::MatrixXf rows(count + scene.descriptors.rows(), model.descriptors.cols());
  rows << model.descriptors, scene.descriptors;
  const auto numbers = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (Eigen::Index m = 0; m < count; ++m) numbers->push_back(number(m));
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setPointRepresentation(pcl::make_shared<const RowOf>(std::move(rows)));
  tree.setInputCloud(numbers);
  pcl::Indices found;
  std::vector<float> squared;
  for (Eigen::Index s = 0; s < scene.descriptors.rows(); ++s) {
    const auto k = static_cast<unsigned int>(std::min<Eigen::Index>(neighbours, count));
    tree.nearestKSearch(number(count + s), static_cast<int>(k), found, squared);
    for (std::size_t i = 0; i < found.size(); ++i)
      matches.push_back({static_cast<int>(s), found[i], squared[i]});
  }
  nearest_first(matches);
  return matches;
}

}  // namespace stonestack::detection
