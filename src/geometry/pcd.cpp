#include "geometry/pcd.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "geometry/byte_order.hpp"
#include "geometry/file_cursor.hpp"
#include "geometry/lzf.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kMaxFields = 32;
constexpr std::size_t kMaxValues = 64;  // of a point
constexpr std::uint64_t kMaxPoints = 20'000'000;
constexpr std::size_t kMaxHeader = 64U << 10U;
constexpr std::size_t kMaxExpansion = 100;  // LZF packs at most 264 bytes into 3
constexpr const char* kPcdRemedy = "write the PCD file again with another program";
constexpr const char* kCut = "the file is truncated; make it again";

struct Field {
  std::string name;
  std::size_t size = 4;
  char type = 'F';
  std::size_t count = 1;
  [[nodiscard]] std::size_t bytes() const { return size * count; }
};

struct Header {
  std::vector<Field> fields;
  std::uint64_t width = 0;
  std::uint64_t height = 1;
  std::uint64_t points = 0;
  bool has_points = false;
  std::string data;

  [[nodiscard]] std::size_t record() const {
    std::size_t sum = 0;
    for (const Field& field : fields) sum += field.bytes();
    return sum;
  }
};

std::uint64_t parse_whole(const FileCursor& cursor, std::string_view word, std::uint64_t low,
                          std::uint64_t high) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || word.empty() || value < low || value > high)
    cursor.fail(concat("'", FileCursor::printable(word), "' is not a whole number from ", low, " to ", high),
                kPcdRemedy);
  return value;
}

/// FIELDS, SIZE, TYPE or COUNT: one word a field.
void parse_columns(const FileCursor& cursor, std::string_view key, std::string_view rest, Header& header) {
  std::size_t i = 0;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++i) {
    if (key == "FIELDS") {
      if (i == kMaxFields) cursor.fail(concat("a point has more than ", kMaxFields, " fields"), kPcdRemedy);
      header.fields.push_back({std::string(word)});
      continue;
    }
    if (i == header.fields.size()) break;
    Field& field = header.fields[i];
    if (key == "SIZE") {
      field.size = parse_whole(cursor, word, 1, 8);
      if ((field.size & (field.size - 1)) != 0)
        cursor.fail(concat("a value of ", field.size, " bytes"), kPcdRemedy);
    } else if (key == "COUNT") {
      field.count = parse_whole(cursor, word, 1, kMaxValues);
    } else {
      field.type = word.front();
      if (word != "F" && word != "I" && word != "U")
        cursor.fail(concat("'", FileCursor::printable(word), "' is not a PCD type"), kPcdRemedy);
    }
    if (i + 1 == header.fields.size() && take_word(rest).empty()) return;
  }
  if (key != "FIELDS")
    cursor.fail(concat(key, " does not name one value for each of the ", header.fields.size(), " fields"),
                kPcdRemedy);
}

void check(const FileCursor& cursor, const Header& header) {
  if (header.fields.empty()) cursor.fail("the header has no FIELDS", kPcdRemedy);
  std::size_t values = 0;
  for (const Field& field : header.fields) {
    values += field.count;
    if (field.type == 'F' && field.size < 4)
      cursor.fail(
          concat("field ", FileCursor::printable(field.name), " is a float of ", field.size, " bytes"),
          kPcdRemedy);
  }
  if (values > kMaxValues) cursor.fail(concat("a point has more than ", kMaxValues, " values"), kPcdRemedy);
  if (header.width * header.height > kMaxPoints)  // each is at most kMaxPoints: no overflow
    cursor.fail(concat("has ", header.width * header.height, " points, more than ", kMaxPoints),
                "thin it out");
  if (header.has_points && header.points != header.width * header.height)
    cursor.fail(
        concat("POINTS ", header.points, " is not WIDTH ", header.width, " times HEIGHT ", header.height),
        kPcdRemedy);
}

Header parse_header(FileCursor& cursor) {
  const std::size_t whole = cursor.bytes_left();
  Header header;
  while (header.data.empty()) {
    if (cursor.bytes_left() == 0) cursor.fail("the header has no DATA line", "give a whole PCD file");
    std::string_view rest = cursor.next_line();
    if (whole - cursor.bytes_left() > kMaxHeader)
      cursor.fail(concat("the header is longer than ", kMaxHeader, " bytes"), kPcdRemedy);
    const std::string_view key = take_word(rest);
    if (key.empty() || key.front() == '#' || key == "VERSION" || key == "VIEWPOINT") continue;
    if (key == "FIELDS" || key == "SIZE" || key == "TYPE" || key == "COUNT") {
      parse_columns(cursor, key, rest, header);
    } else if (key == "WIDTH") {
      header.width = parse_whole(cursor, take_word(rest), 0, kMaxPoints);
    } else if (key == "HEIGHT") {
      header.height = parse_whole(cursor, take_word(rest), 0, kMaxPoints);
    } else if (key == "POINTS") {
      header.points = parse_whole(cursor, take_word(rest), 0, kMaxPoints);
      header.has_points = true;
    } else if (key == "DATA") {
      header.data = take_word(rest);
      if (header.data != "ascii" && header.data != "binary" && header.data != "binary_compressed")
        cursor.fail(concat("'", FileCursor::printable(header.data), "' is not a kind of PCD data"),
                    kPcdRemedy);
    } else {
      cursor.fail(concat("'", FileCursor::printable(key), "' is not a PCD header line"), "give a PCD file");
    }
  }
  check(cursor, header);
  return header;
}

/// For each field, which of x y z and the normal it is; 6 for others.
std::vector<std::size_t> field_slots(const FileCursor& cursor, const Header& header, bool& has_normals) {
  static constexpr std::array<std::string_view, 6> kNames{"x", "y", "z", "normal_x", "normal_y", "normal_z"};
  std::array<int, 7> found{};
  std::vector<std::size_t> slots;
  for (const Field& field : header.fields) {
    std::size_t slot = 0;
    while (slot < kNames.size() && kNames[slot] != field.name) ++slot;
    if (slot < kNames.size() && (field.type != 'F' || field.count != 1 || found[slot] > 0))
      cursor.fail(concat("field ", field.name, " must be one float"), kPcdRemedy);
    ++found[slot];
    slots.push_back(slot);
  }
  if (found[0] == 0 || found[1] == 0 || found[2] == 0) cursor.fail("the points lack x, y or z", kPcdRemedy);
  has_normals = found[3] > 0 && found[4] > 0 && found[5] > 0;
  return slots;
}

/// Values by point and field, wherever the file keeps them.
class Body {
 public:
  Body(FileCursor& cursor, const Header& header) : cursor_(cursor), is_ascii_(header.data == "ascii") {
    const std::size_t count = header.width * header.height;
    std::size_t values = 0;
    for (const Field& field : header.fields) values += field.count;
    if (is_ascii_) {
      if (count > (cursor.bytes_left() + 1) / (2 * values))
        cursor.fail(concat("ends too early for ", count, " points"), kCut);
      return;
    }
    cursor.leave_text();
    const std::size_t expected = count * header.record();
    if (header.data == "binary") {
      data_ = cursor.next_bytes(expected);
    } else {
      const std::size_t packed = decoded<std::uint32_t>(cursor.next_bytes(4));
      const std::size_t unpacked = decoded<std::uint32_t>(cursor.next_bytes(4));
      const std::string_view bytes = cursor.next_bytes(packed);
      if (unpacked != expected || unpacked / kMaxExpansion > packed)
        cursor.fail(concat("announces ", unpacked, " bytes from ", packed, ", the header ", expected),
                    kPcdRemedy);
      if (expected > 0) expanded_ = expand_lzf(bytes, expected);
      if (expanded_.size() != expected) cursor.fail("the compressed data are damaged", "make the file again");
      data_ = expanded_;
    }
    refuse_rest(header);
    lay_out(header, count);
  }

  /// First value of the field; in ASCII the fields must be asked for in order.
  double value(const Header& header, std::size_t point, std::size_t field) {
    const Field& f = header.fields[field];
    if (is_ascii_) {
      const double first = cursor_.number(cursor_.next_word());
      for (std::size_t i = 1; i < f.count; ++i) (void)cursor_.number(cursor_.next_word());
      return first;
    }
    const std::string_view bytes = data_.substr(start_[field] + point * stride_[field], f.size);
    if (f.type == 'U' && f.size == 4) return decoded<std::uint32_t>(bytes);
    if (f.type != 'F') return 0.0;  // never used
    return f.size == 8 ? decoded<double>(bytes) : static_cast<double>(decoded<float>(bytes));
  }

  void require_end() {
    if (is_ascii_ && !cursor_.next_word().empty())
      cursor_.fail("data stand after the last point", kPcdRemedy);
  }

 private:
  /// Binary goes point by point, compressed field by field.
  void lay_out(const Header& header, std::size_t count) {
    std::size_t before = 0;
    for (const Field& field : header.fields) {
      const bool by_field = header.data == "binary_compressed";
      start_.push_back(by_field ? before * count : before);
      stride_.push_back(by_field ? field.bytes() : header.record());
      before += field.bytes();
    }
  }

  /// Bytes after the points are an error, but for the zeros with which older PCL ends compressed files.
  void refuse_rest(const Header& header) {
    const std::size_t count = cursor_.bytes_left();
    const std::string_view rest = cursor_.next_bytes(count);
    const bool padding =
        header.data == "binary_compressed" && rest.find_first_not_of('\0') == std::string_view::npos;
    if (count > 0 && !padding) cursor_.fail(concat(count, " bytes stand after the points"), kPcdRemedy);
  }

  FileCursor& cursor_;
  bool is_ascii_;
  std::string expanded_;
  std::string_view data_;
  std::vector<std::size_t> start_, stride_;
};

}  // namespace

Cloud parse_pcd(const std::string& path, std::string_view content) {
  FileCursor cursor(path, content);
  const Header header = parse_header(cursor);
  bool has_normals = false;
  const std::vector<std::size_t> slots = field_slots(cursor, header, has_normals);
  Body body(cursor, header);
  Cloud cloud;
  cloud.width = static_cast<int>(header.width);
  cloud.height = static_cast<int>(header.height);
  const std::size_t count = header.width * header.height;
  cloud.points.reserve(count);
  if (has_normals) cloud.normals.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 7> values{};
    for (std::size_t k = 0; k < slots.size(); ++k)
      values[slots[k]] = static_cast<float>(body.value(header, i, k));
    cloud.points.emplace_back(values[0], values[1], values[2]);
    if (has_normals) cloud.normals.emplace_back(values[3], values[4], values[5]);
  }
  body.require_end();
  return cloud;
}

std::vector<int> parse_pcd_labels(const std::string& path, std::string_view content) {
  FileCursor cursor(path, content);
  const Header header = parse_header(cursor);
  const auto field = std::find_if(header.fields.begin(), header.fields.end(), [](const Field& f) {
    return f.name == "label" && f.type == 'U' && f.size == 4 && f.count == 1;
  });
  if (field == header.fields.end() || header.data == "ascii")
    cursor.fail("the points have no label (unsigned, 4 bytes, binary)", "give a labelled cloud");
  Body body(cursor, header);
  std::vector<int> labels;
  const auto index = static_cast<std::size_t>(field - header.fields.begin());
  for (std::size_t i = 0; i < header.width * header.height; ++i) {
    const double label = body.value(header, i, index);
    if (label > std::numeric_limits<int>::max())
      cursor.fail(concat("label ", static_cast<std::uint32_t>(label), " is too large"),
                  "number the labels from 0");
    labels.push_back(static_cast<int>(label));
  }
  return labels;
}

}  // namespace stonestack::geometry
