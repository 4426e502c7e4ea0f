#include "stonestack/hardware/cell_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "core/yaml.hpp"
#include "hardware/cell_config.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::hardware {
namespace {

constexpr std::size_t kMaxFile = 1 << 20;
constexpr double kRounding = 2e-6;  // of numbers as `number_text` writes them
const std::array<std::string, 7> kKeys{"x", "y", "z", "qx", "qy", "qz", "qw"};

using Numbers = std::array<double, 7>;
using Scalars = std::map<std::string, std::string>;

Numbers numbers_of(const Pose& pose) {
  const Eigen::Vector3d& p = pose.translation();
  Eigen::Quaterniond q(pose.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

/// Micrometres, and as much of a rotation.
std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.7f", std::round(value * 1e7) / 1e7 + 0.0);
  std::string plain = text.data();
  while (plain.back() == '0' && plain[plain.size() - 2] != '.') plain.pop_back();
  return plain;
}

std::string flow_text(const Numbers& numbers) {
  std::string text;
  for (std::size_t k = 0; k < kKeys.size(); ++k)
    text += concat(k == 0 ? "{" : ", ", kKeys[k], ": ", number_text(numbers[k]));
  return text + "}";
}

/// One `key: value` of the file; `name` is the whole one, "layout.T_T_C.x".
struct Entry {
  std::string name;
  YAML::Node key, value;
  bool in_flow = false;  ///< between braces
};

void collect(const YAML::Node& map, const std::string& prefix, int level, std::vector<Entry>& list) {
  constexpr int kDeepest = 3;  // layout, T_T_C, x
  if (!map.IsMap() || level > kDeepest) return;
  for (const auto& child : map) {
    const std::string name = prefix + child.first.Scalar();
    list.push_back({name, child.first, child.second, map.Style() == YAML::EmitterStyle::Flow});
    collect(child.second, name + ".", level + 1, list);
  }
}

Scalars scalars_of(const YAML::Node& root) {
  Scalars all;
  yaml::for_each_scalar(root, [&](const std::string& name, const std::string& value) { all[name] = value; });
  return all;
}

bool is_of_mount(const std::string& name) {
  return name == "layout.hand_eye" || name == "layout.T_T_C" || name.rfind("layout.T_T_C.", 0) == 0;
}

bool is_of_base(const std::string& name) {
  return name.rfind("layout.T_W_R.", 0) == 0;
}

/// The text of a cell file, and where its entries stand in it.
class CellText {
 public:
  CellText(std::string text, const std::string& path) : text_(std::move(text)) {
    root_ = yaml::parse(text_, path);
    collect(root_, "", 1, entries_);
  }
  [[nodiscard]] const Entry* find(const std::string& name) const {
    const auto it =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.name == name; });
    return it == entries_.end() ? nullptr : &*it;
  }
  [[nodiscard]] Scalars scalars() const { return scalars_of(root_); }

  /// Each as "name: value" below `layout`; nothing when the text is not of a kind that can be edited.
  [[nodiscard]] std::optional<std::string> with_numbers(const std::string& pose,
                                                        const Numbers& numbers) const;
  [[nodiscard]] std::optional<std::string> with_entry_replaced(const Entry& old,
                                                               const std::string& line) const;
  [[nodiscard]] std::optional<std::string> with_entry_added(const std::string& line) const;

 private:
  struct Piece {
    std::size_t at = 0, length = 0;
    std::string text;
  };
  [[nodiscard]] std::string replaced(std::vector<Piece> pieces) const {
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.at > b.at; });
    std::string text = text_;
    for (const Piece& piece : pieces) text.replace(piece.at, piece.length, piece.text);
    return text;
  }
  /// Where a value of one line stands: plain, or in quotes.
  [[nodiscard]] std::optional<Piece> place_of(const YAML::Node& scalar) const {
    const int at = scalar.Mark().pos;
    if (at < 0 || static_cast<std::size_t>(at) >= text_.size()) return {};
    const auto begin = static_cast<std::size_t>(at);
    const std::string& value = scalar.Scalar();
    if (text_.compare(begin, value.size(), value) == 0 && !value.empty())
      return Piece{begin, value.size(), ""};
    const char quote = text_[begin];
    if ((quote == '"' || quote == '\'') && text_.compare(begin + 1, value.size(), value) == 0)
      return Piece{begin, value.size() + 2, ""};
    return {};
  }
  [[nodiscard]] std::size_t end_of_line(std::size_t at) const {
    return std::min(text_.find('\n', at), text_.size());
  }
  [[nodiscard]] static std::size_t position(const YAML::Node& node) {
    return static_cast<std::size_t>(std::max(0, node.Mark().pos));
  }
  [[nodiscard]] static std::string indent(const YAML::Node& node) {
    return std::string(static_cast<std::size_t>(std::max(0, node.Mark().column)), ' ');
  }

  std::string text_;
  YAML::Node root_;
  std::vector<Entry> entries_;
};

std::optional<std::string> CellText::with_numbers(const std::string& pose, const Numbers& numbers) const {
  std::vector<Piece> pieces;
  const Entry* last = nullptr;
  std::string missing_flow, missing_block;
  for (std::size_t k = 0; k < kKeys.size(); ++k)
    if (const Entry* entry = find(pose + "." + kKeys[k])) {
      auto piece = place_of(entry->value);
      if (!piece) return {};
      piece->text = number_text(numbers[k]);
      pieces.push_back(*piece);
      if (last == nullptr || position(entry->key) > position(last->key)) last = entry;
    }
  if (last == nullptr) return {};
  const std::string& key = last->key.Scalar();  // "x", or "layout.T_T_C.x" where maps are written so
  const std::string prefix = key.substr(0, key.rfind('.') + 1);
  for (std::size_t k = 0; k < kKeys.size(); ++k) {
    if (find(pose + "." + kKeys[k]) != nullptr) continue;
    const std::string line = concat(prefix, kKeys[k], ": ", number_text(numbers[k]));
    missing_flow += ", " + line;
    missing_block += "\n" + indent(last->key) + line;
  }
  const auto end = place_of(last->value);
  if (last->in_flow)
    pieces.push_back({end->at + end->length, 0, missing_flow});
  else
    pieces.push_back({end_of_line(end->at), 0, missing_block});
  return replaced(pieces);
}

std::optional<std::string> CellText::with_entry_replaced(const Entry& old, const std::string& line) const {
  const auto value = place_of(old.value);
  const std::string& key = old.key.Scalar();
  const std::size_t begin = position(old.key);
  if (!value || value->at < begin) return {};
  const std::string prefix = key.substr(0, key.rfind('.') + 1);
  return replaced({{begin, value->at + value->length - begin, prefix + line}});
}

std::optional<std::string> CellText::with_entry_added(const std::string& line) const {
  const Entry* layout = find("layout");
  const auto first = std::find_if(entries_.begin(), entries_.end(),
                                  [](const Entry& e) { return e.name.rfind("layout.", 0) == 0; });
  if (layout != nullptr && layout->value.IsMap() && first != entries_.end()) {
    const std::size_t begin = position(first->key);
    if (first->in_flow) return replaced({{begin, 0, line + ", "}});
    return replaced({{begin, 0, line + "\n" + indent(first->key)}});
  }
  if (!entries_.empty() && entries_.front().in_flow)
    return replaced({{position(entries_.front().key), 0, "layout." + line + ", "}});
  const std::string gap = text_.empty() || text_.back() == '\n' ? "" : "\n";
  return text_ + gap + (layout == nullptr ? "layout:\n  " : "layout.") + line + "\n";
}

/// The scalars of a text that may be none.
std::optional<Scalars> read_scalars(const std::string& text, const std::string& path) {
  try {
    return scalars_of(yaml::parse(text, path));
  } catch (const Error&) {
    return {};
  }
}

/// True if all seven numbers of the pose stand there.
bool holds(const Scalars& scalars, const std::string& pose, const Numbers& numbers) {
  for (std::size_t k = 0; k < kKeys.size(); ++k) {
    const auto found = scalars.find(pose + "." + kKeys[k]);
    if (found == scalars.end() || std::abs(std::atof(found->second.c_str()) - numbers[k]) > kRounding)
      return false;
  }
  return true;
}

/// True if everything but what is `changed` reads as before.
bool same_but(Scalars after, Scalars before, bool (*changed)(const std::string& name)) {
  std::erase_if(before, [&](const auto& entry) { return changed(entry.first); });
  std::erase_if(after, [&](const auto& entry) { return changed(entry.first); });
  return before == after;
}

/// True if everything but the mount reads as before, and the mount as it should.
bool reads_as_intended(const std::string& text, const std::string& path, const Scalars& before,
                       const std::string& file, const Numbers& numbers) {
  const auto read = read_scalars(text, path);
  if (!read) return false;
  Scalars after = *read;
  const bool by_file = after.count("layout.hand_eye") > 0 && !after["layout.hand_eye"].empty();
  if (by_file != !file.empty() || (by_file && after["layout.hand_eye"] != file)) return false;
  return (by_file || holds(after, "layout.T_T_C", numbers)) && same_but(after, before, is_of_mount);
}

/// As the cell names it: relative where the file lies beside the cell or below.
std::string name_for(const std::string& calibration, const std::string& cell) {
  namespace fs = std::filesystem;
  const fs::path file = fs::weakly_canonical(calibration);
  const fs::path folder = fs::weakly_canonical(cell).parent_path();
  const fs::path relative = file.lexically_relative(folder);
  return relative.empty() || *relative.begin() == ".." ? file : relative;
}

/// In single quotes where a plain word would be read as something else.
std::string quoted(const std::string& word) {
  const bool is_plain = std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '/' || c == '.' || c == '_' || c == '-';
  });
  if (is_plain) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "''" : std::string(1, c);
  return text + "'";
}

/// The file itself, not a link to it.
std::string linked_file(const std::string& path) {
  std::error_code missing;
  const std::string target = std::filesystem::canonical(path, missing);
  if (missing) throw FileError(path, missing.message(), "name a cell file that is there");
  return target;
}

[[noreturn]] void refuse_to_edit(const std::string& path, const std::string& line) {
  throw FileError(path, "is written in a manner that cannot be edited without changing more",
                  "write below `layout`: " + line);
}

void replace_file(const std::string& path, const std::string& text) {
  const auto rights = std::filesystem::status(path).permissions();
  write_file(path, text);
  std::error_code ignored;
  std::filesystem::permissions(path, rights, ignored);
}

}  // namespace

std::string mount_text(const Pose& pose) {
  return flow_text(numbers_of(pose));
}

std::string write_mount(const std::string& path, const Pose& T_F_C, const std::string& calibration) {
  const std::string target = linked_file(path);
  const CellText cell(read_file(target, kMaxFile), target);
  const Scalars before = cell.scalars();
  const auto has = [&](const std::string& name) {
    return before.count(name) > 0 && !before.at(name).empty();
  };
  const bool has_pose = std::any_of(before.begin(), before.end(), [](const auto& entry) {
    return is_of_mount(entry.first) && entry.first != "layout.hand_eye";
  });
  if (has_pose && has("layout.hand_eye"))
    throw FileError(path, "says layout.T_T_C and layout.hand_eye, which are the same thing", "remove one");
  const std::string file = calibration.empty() || has_pose ? "" : name_for(calibration, target);
  CellConfig config;
  const FieldList list = fields(config);
  for (const std::string& key : kKeys)
    if (const std::string name = "layout.T_F_T." + key; has(name)) try {
        set_field(list, name + "=" + before.at(name));
      } catch (const InvalidArgument& problem) {
        throw FileError(path, problem.what(), "write the finger tips in the flange");
      }
  const Numbers numbers = numbers_of(to_pose(config.T_F_T, "layout.T_F_T").inverse() * T_F_C);
  const std::string line = file.empty() ? "T_T_C: " + flow_text(numbers) : "hand_eye: " + quoted(file);
  const Entry* old = cell.find("layout.hand_eye");
  const auto text = has_pose                 ? cell.with_numbers("layout.T_T_C", numbers)
                    : has("layout.hand_eye") ? cell.with_entry_replaced(*old, line)
                                             : cell.with_entry_added(line);
  if (!text || !reads_as_intended(*text, target, before, file, numbers)) refuse_to_edit(path, line);
  replace_file(target, *text);
  return "layout." + line;
}

std::string write_base(const std::string& path, const Pose& T_W_R) {
  const std::string base = "layout.T_W_R";
  const std::string target = linked_file(path);
  const CellText cell(read_file(target, kMaxFile), target);
  const Scalars before = cell.scalars();
  const Numbers numbers = numbers_of(T_W_R);
  const std::string line = "T_W_R: " + flow_text(numbers);
  const bool has_pose =
      std::any_of(before.begin(), before.end(), [](const auto& entry) { return is_of_base(entry.first); });
  const auto text = has_pose ? cell.with_numbers(base, numbers) : cell.with_entry_added(line);
  const auto after = text ? read_scalars(*text, target) : std::nullopt;
  if (!after || !holds(*after, base, numbers) || !same_but(*after, before, is_of_base))
    refuse_to_edit(path, line);
  replace_file(target, *text);
  return "layout." + line;
}

}  // namespace stonestack::hardware
