#pragma once
#include <bit>
#include <string>
#include <vector>

#include "geometry/file_cursor.hpp"

namespace stonestack::geometry {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };
[[nodiscard]] std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  bool is_ascii = true;
  std::endian order = std::endian::little;
  std::vector<PlyElement> elements;
  int width = 0;
  int height = 0;
};

/// Reads up to and including "end_header". Throws FileError.
[[nodiscard]] PlyHeader parse_ply_header(FileCursor& cursor);

}  // namespace stonestack::geometry
