#pragma once
// What several fuzz targets check of what a parser let through, and where they put files for parsers that
// read paths.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "rooms.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::fuzz {

inline void check(bool held) {
  if (!held) std::abort();
}

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Some face, every corner a vertex, every coordinate finite and within 100 km.
inline void check_mesh(const Mesh& mesh) {
  check(!mesh.faces.empty());
  for (const auto& p : mesh.vertices) check(p.allFinite() && p.cwiseAbs().maxCoeff() <= 1e5);
  for (const auto& face : mesh.faces)
    for (const int corner : face) check(corner >= 0 && corner < static_cast<int>(mesh.vertices.size()));
}

/// As many points as rows and columns say, each near or a gap as a whole.
inline void check_cloud(const Cloud& cloud) {
  check(cloud.width >= 0 && cloud.height >= 0);
  check(static_cast<std::size_t>(cloud.width) * static_cast<std::size_t>(cloud.height) ==
        cloud.points.size());
  check(cloud.normals.empty() || cloud.normals.size() == cloud.points.size());
  for (const auto& p : cloud.points)
    check((p.allFinite() && p.cwiseAbs().maxCoeff() <= 1e5F) || p.array().isNaN().all());
}

/// A folder in memory, if there is one, that goes with the program.
class Scratch {
 public:
  Scratch() {
    const std::filesystem::path memory = "/dev/shm";
    const auto parent = std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path();
    std::string name = (parent / "stonestack_fuzz_XXXXXX").string();
    check(::mkdtemp(name.data()) != nullptr);
    folder_ = name;
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  /// Where the file lies.
  std::string write(const std::string& name, const std::string& text) const {
    write_file(path(name), text);
    return path(name);
  }

 private:
  std::string folder_;
};

}  // namespace stonestack::fuzz
