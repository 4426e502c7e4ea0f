#include "scene_input.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "stonestack/core/error.hpp"

namespace stonestack::apps {

void register_depth_input(CLI::App& command, DepthInput& input) {
  command.add_option("--depth-unit", input.unit, "m a count of a depth PNG; never guessed")
      ->check(CLI::Range(1e-6, 0.1));
  command.add_option("--camera", input.camera, "fx,fy,cx,cy of a depth PNG, pixels");
  command.add_option("--distortion", input.distortion,
                     "Of a depth PNG's or recording's lens: brown_conrady:k1,k2,p1,p2,k3 or "
                     "inverse_brown_conrady:... (SR300)");
  command.add_option("--frame", input.frame, "Of a recording, from 0")->check(CLI::NonNegativeNumber);
  command.add_option("--units", input.units, "Of a cloud's coordinates")
      ->check(CLI::IsMember({"m", "cm", "mm"}))
      ->capture_default_str();
}

void require_readable(const std::string& path) {
  if (::access(path.c_str(), R_OK) != 0) throw FileError(path, std::strerror(errno), "check the path");
}

}  // namespace stonestack::apps
