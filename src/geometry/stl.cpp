#include "geometry/stl.hpp"

#include <algorithm>
#include <cctype>

#include "geometry/byte_order.hpp"
#include "geometry/file_cursor.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kHeader = 84;  // 80 bytes of anything, then the count of faces
constexpr std::size_t kRecord = 50;  // normal, three corners, two bytes of attributes
constexpr const char* kStlRemedy = "write the STL file again with another program";

void add_face(Mesh& mesh) {
  const auto n = static_cast<int>(mesh.vertices.size());
  mesh.faces.emplace_back(n - 3, n - 2, n - 1);
}

Mesh parse_binary(FileCursor& cursor) {
  (void)cursor.next_bytes(kHeader);
  Mesh mesh;
  while (cursor.bytes_left() > 0) {
    const std::string_view record = cursor.next_bytes(kRecord);
    for (std::size_t corner = 1; corner <= 3; ++corner) {
      Eigen::Vector3d p;
      for (std::size_t k = 0; k < 3; ++k)
        p[static_cast<Eigen::Index>(k)] =
            static_cast<double>(decoded<float>(record.substr(12 * corner + 4 * k, 4)));
      mesh.vertices.push_back(p);
    }
    add_face(mesh);
  }
  return mesh;
}

bool is_word(std::string_view word, std::string_view lower_case) {
  return std::equal(word.begin(), word.end(), lower_case.begin(), lower_case.end(),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == b; });
}

void expect(FileCursor& cursor, std::string_view lower_case) {
  const std::string_view word = cursor.next_word();
  if (!is_word(word, lower_case))
    cursor.fail(concat("expected '", lower_case, "', got '", FileCursor::printable(word), "'"), kStlRemedy);
}

void parse_ascii_face(FileCursor& cursor, Mesh& mesh) {
  expect(cursor, "normal");
  for (int k = 0; k < 3; ++k) (void)cursor.number(cursor.next_word());  // often wrong, so not used
  expect(cursor, "outer");
  expect(cursor, "loop");
  for (int corner = 0; corner < 3; ++corner) {
    expect(cursor, "vertex");
    Eigen::Vector3d p;
    for (int k = 0; k < 3; ++k) p[k] = cursor.finite_number(cursor.next_word());
    mesh.vertices.push_back(p);
  }
  expect(cursor, "endloop");
  expect(cursor, "endfacet");
  add_face(mesh);
}

Mesh parse_ascii(FileCursor& cursor) {
  Mesh mesh;
  std::string_view word = cursor.next_word();
  while (!word.empty()) {
    if (!is_word(word, "solid"))
      cursor.fail(concat("expected 'solid', got '", FileCursor::printable(word), "'"), kStlRemedy);
    (void)cursor.next_line();  // its name
    for (word = cursor.next_word(); is_word(word, "facet"); word = cursor.next_word())
      parse_ascii_face(cursor, mesh);
    if (word.empty()) cursor.fail("ends too early: no 'endsolid'", "the file is truncated; make it again");
    if (!is_word(word, "endsolid"))
      cursor.fail(concat("expected 'facet' or 'endsolid', got '", FileCursor::printable(word), "'"),
                  kStlRemedy);
    (void)cursor.next_line();
    word = cursor.next_word();
  }
  return mesh;
}

}  // namespace

// Binary files may begin with "solid" as well, so the size decides.
Mesh parse_stl(const std::string& path, std::string_view content) {
  FileCursor cursor(path, content);
  if (content.size() >= kHeader) {
    const std::size_t faces = decoded<std::uint32_t>(content.substr(80, 4));
    if (content.size() - kHeader == faces * kRecord) return parse_binary(cursor);
  }
  std::string_view start = content.substr(0, 80);
  const std::size_t first = start.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && is_word(start.substr(first, 5), "solid")) return parse_ascii(cursor);
  if (content.size() < kHeader)
    cursor.fail(concat("has ", content.size(), " bytes, too few for an STL file"), kStlRemedy);
  cursor.fail(concat("announces ", decoded<std::uint32_t>(content.substr(80, 4)), " faces, but has ",
                     content.size(), " bytes"),
              "the file is truncated or no STL file; make it again");
}

}  // namespace stonestack::geometry
