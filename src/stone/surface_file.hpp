#pragma once
#include <string>

#include "stonestack/stone/stone.hpp"

/// Private to stone/: the file surface.json in the folder of a stone that was modelled from views.
namespace stonestack::stone {

/// File, within a stone's folder, of how well its surface is known.
inline constexpr const char* kSurfaceFile = "surface.json";

/// "stonestack.surface/1": `sigma_m` and `seen`, a vertex of scan.ply each, and `up_at_rest`.
[[nodiscard]] std::string surface_json(const SurfaceKnowledge& surface);
/// @param vertices of scan.ply
/// @throws FileError for what is no such file, or not of that scan
[[nodiscard]] SurfaceKnowledge read_surface(const std::string& path, std::size_t vertices);

}  // namespace stonestack::stone
