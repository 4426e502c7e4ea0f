#include "stacking/refuted_place.hpp"

#include "geometry/depth_render.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kSameSurface = 0.010;     // m along a ray: models, poses and depth err by less
constexpr double kMaxThrough = 1.0 / 3.0;  // of what is not hidden: guessed parts of a model may be missing
constexpr int kMinPixels = 40;             // of all views, that tell

}  // namespace

bool is_refuted(const Views& views, const Mesh& mesh, const Pose& T_W_O) {
  RayScene scene;
  scene.add(mesh, T_W_O);
  scene.commit();
  int on = 0, through = 0;
  for (const CameraView& view : views) {
    const DepthImage there = render(scene, view.image.camera, view.T_W_C).depth;
    for (int v = 0; v < view.image.camera.height; ++v)
      for (int u = 0; u < view.image.camera.width; ++u) {
        const double seen = view.image.at(u, v), expected = there.at(u, v);
        if (!(seen > 0.0) || !(expected > 0.0) || seen < expected - kSameSurface) continue;
        ++(seen > expected + kSameSurface ? through : on);
      }
  }
  return on + through >= kMinPixels && through > kMaxThrough * (on + through);
}

}  // namespace stonestack::stacking
