#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "rooms.hpp"
#include "stonestack/stone/scene_view.hpp"

namespace stonestack::apps {

/// --depth-unit, --camera, --distortion, --frame, --units.
void register_depth_input(CLI::App& command, DepthInput& input);

/// Throws FileError unless a file or folder of that name is there and may be read: for a check before shapes
/// are built, which takes seconds.
void require_readable(const std::string& path);

}  // namespace stonestack::apps
