// Targets of walls, as files and as short text: refused with an error that names them, or a wall that can be
// asked for.
#include <cmath>

#include "fuzz/checks.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace {

void check_task(const stonestack::search::SpanTask& task) {
  using stonestack::fuzz::check;
  check(!task.spans.empty());
  for (const auto& span : task.spans) {
    check(std::isfinite(span.from) && std::isfinite(span.to) && span.from < span.to);
    check(std::isfinite(span.clear) && span.clear >= 0.0);
  }
  for (const auto& block : task.supports) {
    check(std::isfinite(block.from) && std::isfinite(block.to) && block.from < block.to);
    check(std::isfinite(block.height) && block.height > 0.0);
    check(std::isfinite(block.depth) && block.depth > 0.0);
  }
  check(!task.carry || std::isfinite(*task.carry));
}

void check_wall(const std::string& text) {
  using namespace stonestack;
  using namespace stonestack::report;
  using stonestack::fuzz::check;
  try {
    const search::WallTarget target = search::read_wall_target(text);
    for (const int count : target.courses) check(count > 0);
    check(target.task || !target.courses.empty() ||
          (target.length > 0.0 && std::isfinite(target.length) && target.levels > 0));
    if (target.task) check_task(*target.task);
    check(!target.centre_W || target.centre_W->allFinite());
    check(std::isfinite(target.yaw));
  } catch (const InvalidArgument&) {
  } catch (const FileError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  static const fuzz::Scratch scratch;
  const std::string text = fuzz::text_of(data, size);
  check_wall(scratch.write("wall.yaml", text));
  if (!is_scene_file(text)) check_wall(text);  // no file of that name is asked for
  return 0;
}
