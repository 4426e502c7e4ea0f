// Scene files: refused with a FileError, or a camera that can be, poses that are, and obstacles with a shape.
#include <cmath>

#include "fuzz/checks.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/stone/scene_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  using fuzz::check;
  static const fuzz::Scratch scratch;
  const std::string path = scratch.write("scene.yaml", fuzz::text_of(data, size));
  try {
    const SceneFile scene = read_scene_file(path);
    if (scene.camera) {
      check(scene.camera->width > 0 && scene.camera->height > 0 && scene.camera->fx > 0);
      for (const double k : scene.camera->k) check(std::isfinite(k));
    }
    check(!scene.T_W_C || is_valid(*scene.T_W_C));
    check(scene.depth_file.empty() || scene.depth_unit > 0);
    for (const auto* list : {&scene.stack, &scene.stones})
      for (const auto& stone : *list) check(is_valid(stone.T_W_O));
    for (const auto& obstacle : scene.obstacles)
      for (const auto& piece : obstacle.pieces) fuzz::check_mesh(piece);
  } catch (const FileError&) {
  }
  return 0;
}
