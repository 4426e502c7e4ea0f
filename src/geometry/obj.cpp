#include "geometry/obj.hpp"

#include "geometry/file_cursor.hpp"

namespace stonestack::geometry {
namespace {

constexpr const char* kObjRemedy = "write the OBJ file again with another program";
constexpr int kMaxCorners = 1000;

/// "v x y z", then nothing, a weight or a colour.
void parse_vertex(const FileCursor& cursor, std::string_view rest, Mesh& mesh) {
  Eigen::Vector3d p;
  for (int k = 0; k < 3; ++k) {
    const std::string_view word = take_word(rest);
    if (word.empty()) cursor.fail("a vertex has fewer than three numbers", kObjRemedy);
    p[k] = cursor.finite_number(word);
  }
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest))
    (void)cursor.number(word);
  mesh.vertices.push_back(p);
}

/// The vertex index of "a", "a/b", "a//c" or "a/b/c", from 0; negative ones count back from the last vertex.
/// Indices ahead are checked at the end of the file.
int parse_corner(const FileCursor& cursor, std::string_view word, std::size_t vertices_so_far) {
  const std::string_view digits = word.substr(0, word.find('/'));
  int index = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
  if (error != std::errc() || end != digits.data() + digits.size() || index == 0)
    cursor.fail(concat("'", FileCursor::printable(word), "' is not a vertex index"), kObjRemedy);
  if (index > 0) return index - 1;
  const auto from_start = static_cast<std::int64_t>(vertices_so_far) + index;
  if (from_start < 0) cursor.fail(concat("vertex index ", index, " is before the first vertex"), kObjRemedy);
  return static_cast<int>(from_start);
}

void parse_face(const FileCursor& cursor, std::string_view rest, Mesh& mesh) {
  int corners = 0;
  int first = 0;
  int before = 0;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
    const int index = parse_corner(cursor, word, mesh.vertices.size());
    if (corners == 0) first = index;
    if (corners >= 2) mesh.faces.emplace_back(first, before, index);
    before = index;
    if (++corners > kMaxCorners)
      cursor.fail(concat("a face has more than ", kMaxCorners, " corners"), kObjRemedy);
  }
  if (corners < 3) cursor.fail(concat("a face has ", corners, " corners"), kObjRemedy);
}

}  // namespace

Mesh parse_obj(const std::string& path, std::string_view content) {
  FileCursor cursor(path, content);
  Mesh mesh;
  while (cursor.bytes_left() > 0) {
    std::string_view rest = cursor.next_line();
    if (!rest.empty() && rest.back() == '\\') cursor.fail("a line is continued on the next", kObjRemedy);
    const std::string_view key = take_word(rest);
    if (key == "v") parse_vertex(cursor, rest, mesh);
    if (key == "f") parse_face(cursor, rest, mesh);
  }
  cursor.leave_text();
  for (const Eigen::Vector3i& face : mesh.faces) {
    const int max = face.maxCoeff();
    if (static_cast<std::size_t>(max) >= mesh.vertices.size())
      cursor.fail(concat("a face has vertex ", max + 1.0, ", but there are ", mesh.vertices.size()),
                  kObjRemedy);
  }
  return mesh;
}

}  // namespace stonestack::geometry
