#include "geometry/ply.hpp"

#include <array>

#include "geometry/byte_order.hpp"
#include "geometry/ply_header.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kMaxVertices = 20'000'000;
constexpr double kPlyMaxCorners = 1000;
constexpr const char* kPlyRemedy = "write the PLY file again with another program";

/// Values one after the other, whatever the format.
class PlyBody {
 public:
  PlyBody(FileCursor& cursor, const PlyHeader& header)
      : cursor_(cursor), is_ascii_(header.is_ascii), order_(header.order) {
    if (!is_ascii_) cursor_.leave_text();
  }

  double next(PlyType type) {
    if (is_ascii_) return cursor_.number(cursor_.next_word());
    const std::string_view bytes = cursor_.next_bytes(size_of(type));
    switch (type) {
      case PlyType::kInt8:
        return decoded<std::int8_t>(bytes, order_);
      case PlyType::kUint8:
        return decoded<std::uint8_t>(bytes, order_);
      case PlyType::kInt16:
        return decoded<std::int16_t>(bytes, order_);
      case PlyType::kUint16:
        return decoded<std::uint16_t>(bytes, order_);
      case PlyType::kInt32:
        return decoded<std::int32_t>(bytes, order_);
      case PlyType::kUint32:
        return decoded<std::uint32_t>(bytes, order_);
      case PlyType::kFloat32:
        return static_cast<double>(decoded<float>(bytes, order_));
      case PlyType::kFloat64:
        return decoded<double>(bytes, order_);
    }
    return 0.0;
  }

  /// A whole number in [low, high].
  int next_whole(PlyType type, double low, double high, const char* what) {
    const double value = next(type);
    if (!(value >= low && value <= high) || value != std::floor(value))
      cursor_.fail(concat(what, " must be a whole number from ", low, " to ", high, ", got ", value),
                   kPlyRemedy);
    return static_cast<int>(value);
  }

  void skip(const PlyProperty& property) {
    if (!property.is_list) {
      (void)next(property.type);
      return;
    }
    for (int left = next_whole(property.count_type, 0, 1e9, "the length of a list"); left > 0; --left)
      (void)next(property.type);
  }

  /// Throws unless the rest of the file can hold the element: at least a byte and a blank a value in ASCII.
  void require_bytes(const PlyElement& element) const {
    if (element.count == 0) return;
    std::size_t min = 0;
    for (const PlyProperty& property : element.properties)
      min += is_ascii_ ? 2 : size_of(property.is_list ? property.count_type : property.type);
    if (min == 0) cursor_.fail(concat("element ", element.name, " has no properties"), kPlyRemedy);
    const std::size_t capacity =
        cursor_.bytes_left() + (is_ascii_ ? 1 : 0);  // the last line may lack its end
    if (element.count > capacity / min)
      cursor_.fail(concat("ends too early: ", element.count, " of element ", element.name, " need at least ",
                          min, " bytes each, ", cursor_.bytes_left(), " are left"),
                   "the file is truncated; make it again");
  }

  void require_end() {
    if (is_ascii_ ? !cursor_.next_word().empty() : cursor_.bytes_left() > 0)
      cursor_.fail("data stand after the last element", kPlyRemedy);
  }

 private:
  FileCursor& cursor_;
  bool is_ascii_;
  std::endian order_;
};

/// For each property, which of x y z nx ny nz it is; 6 for others.
std::vector<std::size_t> vertex_slots(const FileCursor& cursor, const PlyElement& element,
                                      bool& has_normals) {
  static constexpr std::array<std::string_view, 6> kNames{"x", "y", "z", "nx", "ny", "nz"};
  std::vector<std::size_t> slots;
  std::array<bool, 6> found{};
  for (const PlyProperty& property : element.properties) {
    if (property.is_list) cursor.fail("a vertex has a list property", kPlyRemedy);
    std::size_t slot = 0;
    while (slot < kNames.size() && kNames[slot] != property.name) ++slot;
    if (slot < kNames.size()) found[slot] = true;
    slots.push_back(slot);
  }
  if (!found[0] || !found[1] || !found[2]) cursor.fail("vertices lack x, y or z", kPlyRemedy);
  has_normals = found[3] && found[4] && found[5];
  return slots;
}

void read_vertices(const FileCursor& cursor, const PlyElement& element, PlyBody& body, PlyContent& content) {
  if (element.count > kMaxVertices)
    cursor.fail(concat("has ", element.count, " vertices, more than ", kMaxVertices), "reduce it first");
  bool has_normals = false;
  const std::vector<std::size_t> slots = vertex_slots(cursor, element, has_normals);
  content.points.reserve(element.count);
  if (has_normals) content.normals.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i) {
    std::array<double, 7> values{};
    for (std::size_t k = 0; k < slots.size(); ++k) values[slots[k]] = body.next(element.properties[k].type);
    content.points.emplace_back(values[0], values[1], values[2]);
    if (has_normals)
      content.normals.emplace_back(Eigen::Vector3d(values[3], values[4], values[5]).cast<float>());
  }
}

void read_faces(const FileCursor& cursor, const PlyElement& element, PlyBody& body, PlyContent& content) {
  const auto is_corners = [](const PlyProperty& property) {
    return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
  };
  bool found = false;
  for (const PlyProperty& property : element.properties) found = found || is_corners(property);
  if (!found) cursor.fail("faces lack the list vertex_indices", kPlyRemedy);
  const double last = static_cast<double>(content.points.size()) - 1.0;
  for (std::size_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      if (!is_corners(property)) {
        body.skip(property);
        continue;
      }
      const int corners = body.next_whole(property.count_type, 3, kPlyMaxCorners, "the corners of a face");
      const int first = body.next_whole(property.type, 0, last, "a vertex index");
      int before = body.next_whole(property.type, 0, last, "a vertex index");
      for (int k = 2; k < corners; ++k) {
        const int next = body.next_whole(property.type, 0, last, "a vertex index");
        content.faces.emplace_back(first, before, next);
        before = next;
      }
    }
  }
}

}  // namespace

PlyContent parse_ply(const std::string& path, std::string_view file) {
  FileCursor cursor(path, file);
  const PlyHeader header = parse_ply_header(cursor);
  PlyBody body(cursor, header);
  PlyContent content;
  content.width = header.width;
  content.height = header.height;
  for (const PlyElement& element : header.elements) {
    body.require_bytes(element);
    if (element.name == "vertex") {
      read_vertices(cursor, element, body, content);
    } else if (element.name == "face") {
      read_faces(cursor, element, body, content);
    } else {
      for (std::size_t i = 0; i < element.count; ++i)
        for (const PlyProperty& property : element.properties) body.skip(property);
    }
  }
  body.require_end();
  return content;
}

}  // namespace stonestack::geometry
