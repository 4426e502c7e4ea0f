#include "geometry/depth_render.hpp"

#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/camera_check.hpp"

namespace stonestack::geometry {
namespace {

/// A mesh in the world; Embree holds its own copy in floats.
struct Instance {
  std::vector<Eigen::Vector3d> face_corner;
  std::vector<Eigen::Vector3d> face_normal;
};

struct Hit {
  double t = 0.0;  ///< in lengths of the given direction
  int instance = -1, face = -1;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

}  // namespace

struct RayScene::Scene {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = nullptr;
  bool committed = false;
  std::vector<Instance> instances;

  Scene() {
    require(device != nullptr, "Embree cannot start, error ", static_cast<int>(rtcGetDeviceError(nullptr)));
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // no light between two faces of an edge
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  [[nodiscard]] Hit first_hit(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const;
};

/// Embree finds the face; where the ray meets its plane is computed again in doubles.
Hit RayScene::Scene::first_hit(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
  RTCRayHit query{};
  query.ray.org_x = static_cast<float>(from.x());
  query.ray.org_y = static_cast<float>(from.y());
  query.ray.org_z = static_cast<float>(from.z());
  query.ray.dir_x = static_cast<float>(direction.x());
  query.ray.dir_y = static_cast<float>(direction.y());
  query.ray.dir_z = static_cast<float>(direction.z());
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.mask = ~0U;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const Instance& instance = instances[query.hit.geomID];
  const Eigen::Vector3d& normal = instance.face_normal[query.hit.primID];
  const double towards = normal.dot(direction);
  double t = static_cast<double>(query.ray.tfar);
  if (std::abs(towards) > 1e-3 * direction.norm())
    t = std::max(0.0, normal.dot(instance.face_corner[query.hit.primID] - from) / towards);
  return {t, static_cast<int>(query.hit.geomID), static_cast<int>(query.hit.primID), normal};
}

RayScene::RayScene() : scene_(std::make_unique<Scene>()) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

int RayScene::add(const Mesh& mesh_A, const Pose& T_W_A) {
  require(!scene_->committed, "a ray scene takes no mesh after commit");
  require(!mesh_A.faces.empty(), "a mesh without faces cannot be rendered");
  const Mesh mesh_W = transformed(mesh_A, T_W_A);
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh_W.vertices.size()));
  auto* faces = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh_W.faces.size()));
  if (vertices == nullptr || faces == nullptr) {
    rtcReleaseGeometry(geometry);
    throw std::bad_alloc();
  }
  for (const Eigen::Vector3d& vertex : mesh_W.vertices)
    for (int k = 0; k < 3; ++k) *vertices++ = static_cast<float>(vertex[k]);
  Instance instance;
  instance.face_normal = face_normals(mesh_W);
  for (const Eigen::Vector3i& face : mesh_W.faces) {
    instance.face_corner.push_back(mesh_W.vertices[static_cast<std::size_t>(face[0])]);
    for (int k = 0; k < 3; ++k) *faces++ = static_cast<unsigned>(face[k]);
  }
  const auto index = static_cast<unsigned>(scene_->instances.size());
  scene_->instances.push_back(std::move(instance));
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene_->scene, geometry, index);
  rtcReleaseGeometry(geometry);  // the scene holds it now
  return static_cast<int>(index);
}

void RayScene::commit() {
  rtcCommitScene(scene_->scene);
  scene_->committed = true;
}

RayHit RayScene::cast(const Eigen::Vector3d& p_W_from, const Eigen::Vector3d& direction_W) const {
  require(scene_->committed, "commit a ray scene before casting rays");
  const double length = direction_W.norm();
  require(length > 0.0 && std::isfinite(length), "a ray needs a direction, got ", direction_W.transpose());
  const Hit hit = scene_->first_hit(p_W_from, direction_W / length);
  return {hit.t, hit.instance, hit.face, hit.normal};
}

bool RayScene::is_blocked(const Eigen::Vector3d& p_W_from, const Eigen::Vector3d& direction_W,
                          double farthest) const {
  require(scene_->committed, "commit a ray scene before casting rays");
  RTCRay ray{};
  ray.org_x = static_cast<float>(p_W_from.x());
  ray.org_y = static_cast<float>(p_W_from.y());
  ray.org_z = static_cast<float>(p_W_from.z());
  ray.dir_x = static_cast<float>(direction_W.x());
  ray.dir_y = static_cast<float>(direction_W.y());
  ray.dir_z = static_cast<float>(direction_W.z());
  ray.tfar = static_cast<float>(farthest);
  ray.mask = ~0U;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene_->scene, &context, &ray);
  return ray.tfar < 0.0F;  // Embree's sign for a hit
}

int RayScene::count_blocked(const Eigen::Vector3d& p_W_from, std::span<const Eigen::Vector3d> directions_W,
                            double farthest) const {
  require(scene_->committed, "commit a ray scene before casting rays");
  constexpr std::size_t kTogether = 8;
  int blocked = 0;
  for (std::size_t first = 0; first < directions_W.size(); first += kTogether) {
    const std::size_t count = std::min(kTogether, directions_W.size() - first);
    alignas(32) RTCRay8 rays{};
    alignas(32) std::array<int, kTogether> valid{};
    for (std::size_t k = 0; k < count; ++k) {
      const Eigen::Vector3f from = p_W_from.cast<float>(), to = directions_W[first + k].cast<float>();
      rays.org_x[k] = from.x(), rays.org_y[k] = from.y(), rays.org_z[k] = from.z();
      rays.dir_x[k] = to.x(), rays.dir_y[k] = to.y(), rays.dir_z[k] = to.z();
      rays.tfar[k] = static_cast<float>(farthest);
      rays.mask[k] = ~0U;
      valid[k] = -1;  // Embree's word for a ray that is asked
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded8(valid.data(), scene_->scene, &context, &rays);
    for (std::size_t k = 0; k < count; ++k) blocked += rays.tfar[k] < 0.0F ? 1 : 0;
  }
  return blocked;
}

RenderedView render(const RayScene& scene, const CameraIntrinsics& camera, const Pose& T_W_C) {
  RenderedView view;
  view.depth = make_empty_image(camera);
  view.instance.assign(view.depth.z.size(), -1);
  view.normal_W.assign(view.depth.z.size(), Eigen::Vector3f::Zero());
  tbb::parallel_for(0, camera.height, [&](int v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray_C = deproject(camera, u, v);
      const RayHit hit = scene.cast(T_W_C.translation(), T_W_C.linear() * ray_C);
      if (hit.instance < 0) continue;
      const std::size_t pixel = pixel_index(camera, u, v);
      view.depth.z[pixel] = static_cast<float>(hit.distance / ray_C.norm());  // along the optical axis
      view.instance[pixel] = hit.instance;
      view.normal_W[pixel] = hit.normal.cast<float>();
    }
  });
  return view;
}

}  // namespace stonestack::geometry
