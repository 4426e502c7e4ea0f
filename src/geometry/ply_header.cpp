#include "geometry/ply_header.hpp"

#include <array>
#include <utility>

namespace stonestack::geometry {
namespace {

constexpr std::size_t kHeaderMaxHeader = 64U << 10U;
constexpr std::size_t kMaxElements = 16;
constexpr std::size_t kMaxProperties = 32;
constexpr const char* kHeaderRemedy = "write the PLY file again with another program";

PlyType parse_type(const FileCursor& cursor, std::string_view word) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames{{
      {"char", PlyType::kInt8},
      {"int8", PlyType::kInt8},
      {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},
      {"short", PlyType::kInt16},
      {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16},
      {"uint16", PlyType::kUint16},
      {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},
      {"uint", PlyType::kUint32},
      {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat32},
      {"float32", PlyType::kFloat32},
      {"double", PlyType::kFloat64},
      {"float64", PlyType::kFloat64},
  }};
  for (const auto& [name, type] : kNames)
    if (name == word) return type;
  cursor.fail(concat("'", FileCursor::printable(word), "' is not a PLY type"), kHeaderRemedy);
}

std::size_t parse_count(const FileCursor& cursor, std::string_view word) {
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error != std::errc() || end != word.data() + word.size() || word.empty())
    cursor.fail(concat("'", FileCursor::printable(word), "' is not a count"), kHeaderRemedy);
  return count;
}

void parse_format(const FileCursor& cursor, std::string_view rest, PlyHeader& header) {
  const std::string_view format = take_word(rest);
  if (take_word(rest) != "1.0") cursor.fail("only PLY format 1.0 is known", kHeaderRemedy);
  header.is_ascii = format == "ascii";
  if (format == "binary_big_endian")
    header.order = std::endian::big;
  else if (!header.is_ascii && format != "binary_little_endian")
    cursor.fail(concat("'", FileCursor::printable(format), "' is not a PLY format"), kHeaderRemedy);
}

void parse_property(const FileCursor& cursor, std::string_view rest, PlyHeader& header) {
  if (header.elements.empty()) cursor.fail("a property stands before any element", kHeaderRemedy);
  PlyProperty property;
  std::string_view word = take_word(rest);
  if (word == "list") {
    property.is_list = true;
    property.count_type = parse_type(cursor, take_word(rest));
    if (property.count_type >= PlyType::kFloat32)
      cursor.fail("a list is counted by a whole number", kHeaderRemedy);
    word = take_word(rest);
  }
  property.type = parse_type(cursor, word);
  property.name = take_word(rest);
  if (property.name.empty()) cursor.fail("a property has no name", kHeaderRemedy);
  PlyElement& element = header.elements.back();
  for (const PlyProperty& other : element.properties)
    if (other.name == property.name)
      cursor.fail(concat("property ", property.name, " stands twice"), kHeaderRemedy);
  element.properties.push_back(property);
  if (element.properties.size() > kMaxProperties)
    cursor.fail(concat("an element has more than ", kMaxProperties, " properties"), kHeaderRemedy);
}

void parse_element(const FileCursor& cursor, std::string_view rest, PlyHeader& header) {
  PlyElement element;
  element.name = take_word(rest);
  element.count = parse_count(cursor, take_word(rest));
  for (const PlyElement& other : header.elements)
    if (other.name == element.name)
      cursor.fail(concat("element ", element.name, " stands twice"), kHeaderRemedy);
  header.elements.push_back(element);
  if (header.elements.size() > kMaxElements)
    cursor.fail(concat("there are more than ", kMaxElements, " elements"), kHeaderRemedy);
}

/// Width and height of an organised cloud; anything else in a comment is a comment.
void parse_remark(std::string_view rest, PlyHeader& header) {
  const std::string_view key = take_word(rest);
  const std::string_view value = take_word(rest);
  int number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || number < 0) return;
  if (key == "width" || key == "num_cols") header.width = number;
  if (key == "height" || key == "num_rows") header.height = number;
}

}  // namespace

std::size_t size_of(PlyType type) {
  static constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

PlyHeader parse_ply_header(FileCursor& cursor) {
  const std::size_t whole = cursor.bytes_left();
  if (cursor.next_line() != "ply") cursor.fail("does not begin with 'ply'", "give a PLY file");
  PlyHeader header;
  bool has_format = false;
  while (true) {
    if (cursor.bytes_left() == 0)
      cursor.fail("the header has no end", "the file is truncated; make it again");
    std::string_view rest = cursor.next_line();
    if (whole - cursor.bytes_left() > kHeaderMaxHeader)
      cursor.fail(concat("the header is longer than ", kHeaderMaxHeader, " bytes"), kHeaderRemedy);
    const std::string_view key = take_word(rest);
    if (key == "end_header") break;
    if (key == "format") {
      parse_format(cursor, rest, header);
      has_format = true;
    } else if (key == "element") {
      parse_element(cursor, rest, header);
    } else if (key == "property") {
      parse_property(cursor, rest, header);
    } else if (key == "comment" || key == "obj_info") {
      parse_remark(rest, header);
    } else if (!key.empty()) {
      cursor.fail(concat("'", FileCursor::printable(key), "' is not a PLY header line"), kHeaderRemedy);
    }
  }
  if (!has_format) cursor.fail("the header names no format", kHeaderRemedy);
  return header;
}

}  // namespace stonestack::geometry
