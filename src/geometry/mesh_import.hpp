#pragma once
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

namespace stonestack::geometry {

/// Mesh formats that are read by assimp in a process of its own: glb, gltf, dae, 3ds, off, fbx.
/// `extension` in lower case.
[[nodiscard]] bool is_imported(std::string_view extension);

struct MeshImport {
  std::string program;    ///< stonestack-import; empty: the one beside this program or as installed
  double seconds = 30.0;  ///< after which the process is ended (it ends itself after 10 s of CPU) [s]
};

/// A file's mesh as PLY, from the helper process `stonestack-import` (geometry/import_program.cpp), which can
/// open no other file and has 1 GiB and 10 s of CPU. Whatever the file does to it, this process goes on. What
/// assimp repairs is warned of. The result is foreign bytes still: parse it strictly. Throws FileError,
/// naming `path`; Interrupted.
[[nodiscard]] std::string import_as_ply(const std::string& path, const std::string& extension,
                                        std::string_view content, const MeshImport& how = {});

}  // namespace stonestack::geometry
