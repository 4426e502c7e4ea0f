#pragma once
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <span>

#include <Eigen/Core>

#include "stonestack/core/rooms.hpp"

namespace stonestack::detection {

/// Our points as PCL wants them.
inline pcl::PointCloud<pcl::PointXYZ>::Ptr to_pcl(std::span<const Eigen::Vector3f> points) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(points.size());
  for (const auto& p : points) cloud->emplace_back(p.x(), p.y(), p.z());
  return cloud;
}

inline pcl::PointCloud<pcl::Normal>::Ptr to_pcl_normals(std::span<const Eigen::Vector3f> normals) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  cloud->reserve(normals.size());
  for (const auto& n : normals) cloud->emplace_back(n.x(), n.y(), n.z());
  return cloud;
}

}  // namespace stonestack::detection
