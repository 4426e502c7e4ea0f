#include "results_page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kSchema = "stonestack.results/1";
constexpr std::size_t kMaxRecord = std::size_t{16} << 20U;  // bytes

[[noreturn]] void refuse(const std::string& path, const std::string& problem) {
  throw FileError(path, problem, "benchmarks/results_page.hpp describes the format");
}

json read_record(const std::string& path) {
  json content = json::parse(read_file(path, kMaxRecord), nullptr, false);
  if (content.is_discarded()) refuse(path, "not JSON");
  return content;
}

/// Reads a text under `key`; empty where it may be missing and is.
std::string text_of(const json& map, const char* key, const std::string& path, bool required) {
  if (!map.is_object() || !map.contains(key)) {
    if (required) refuse(path, concat("'", key, "' is missing"));
    return {};
  }
  if (!map.at(key).is_string()) refuse(path, concat("'", key, "' is not a text"));
  return map.at(key).get<std::string>();
}

/// Reads a number that stands here or in the record of a benchmark.
double number_of(const json& value, const std::string& path) {
  if (value.is_number()) return value.get<double>();
  const std::string file = text_of(value, "record", path, true), at = text_of(value, "at", path, true);
  const std::string record = (fs::path(path).parent_path() / file).string();
  const json content = read_record(record);
  try {
    const json& found = content.at(json::json_pointer(at));
    if (found.is_number()) return found.get<double>();
  } catch (const json::exception&) {  // refused below
  }
  refuse(record, concat("there is no number at '", at, "'"));
}

/// Prints a number with `decimals`, or with up to six significant digits if there are less than 0.
std::string in_digits(double number, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, decimals < 0 ? "%.*g" : "%.*f", decimals < 0 ? 6 : decimals, number);
  return text;
}

struct Entry {
  std::string figure;
  std::string mark;  ///< empty if there is none
};

/// One value of a row as it is printed, and its marks.
Entry entry_of(const json& value, const std::string& path) {
  if (!value.is_object() || !value.contains("value")) refuse(path, "a value without 'value'");
  const double number = number_of(value.at("value"), path);
  const int decimals = value.value("decimals", -1);
  const std::string unit = text_of(value, "unit", path, false), space = unit.empty() ? "" : " ";
  Entry entry{in_digits(number, decimals) + space + unit, {}};
  bool met = true;
  const bool counted = value.contains("of");
  double share = number;
  if (counted) {
    const double of = number_of(value.at("of"), path);
    entry.figure += " of " + in_digits(of, decimals);
    share = of > 0.0 ? number / of : 0.0;
  }
  if (value.contains("min")) {
    const double min = number_of(value.at("min"), path);
    met = share >= min;
    entry.mark =
        "at least " + (counted ? in_digits(100.0 * min, -1) + " %" : in_digits(min, -1) + space + unit);
  }
  if (value.contains("max")) {
    const double max = number_of(value.at("max"), path);
    met = met && number <= max;
    entry.mark += concat(entry.mark.empty() ? "" : " and ", "at most ", in_digits(max, -1), space, unit);
  }
  if (!met) entry.figure = "**" + entry.figure + "**";
  return entry;
}

/// Marks of the values of a row, in their order; one if all are equal.
std::string joined(const std::vector<std::string>& marks) {
  const bool same = std::adjacent_find(marks.begin(), marks.end(), std::not_equal_to<>()) == marks.end();
  std::string text;
  for (std::size_t i = 0; i < (same ? std::min<std::size_t>(1, marks.size()) : marks.size()); ++i)
    text += concat(i == 0 ? "" : ", ", marks[i].empty() ? "-" : marks[i]);
  return text == "-" ? "" : text;
}

std::string row_of(const json& row, const std::string& path) {
  std::string figure = text_of(row, "figure", path, true);
  if (!row.contains("values") || !row.at("values").is_object()) refuse(path, "a row without 'values'");
  std::vector<std::string> marks;
  std::string printed;
  std::set<std::string> used;
  for (std::size_t at = 0; at < figure.size();) {
    const std::size_t open = figure.find('{', at), close = figure.find('}', at);
    if (open == std::string::npos) {
      printed += figure.substr(at);
      break;
    }
    if (close == std::string::npos || close < open)
      refuse(path, concat("braces do not match in '", figure, "'"));
    const std::string name = figure.substr(open + 1, close - open - 1);
    if (!row.at("values").contains(name))
      refuse(path, concat("'", name, "' is not among the values of its row"));
    const Entry entry = entry_of(row.at("values").at(name), path);
    printed += figure.substr(at, open - at) + entry.figure;
    marks.push_back(entry.mark);
    used.insert(name);
    at = close + 1;
  }
  if (used.size() != row.at("values").size())
    refuse(path, concat("a value is not printed by '", figure, "'"));
  const std::string command = text_of(row, "command", path, false);
  return concat("| ", text_of(row, "what", path, true), " | ", printed, " | ", joined(marks), " | ",
                command.empty() ? "no command in this repository" : concat('`', command, '`'), " | ",
                text_of(row, "version", path, true), " |\n");
}

std::string section_of(const std::string& path) {
  const json content = read_record(path);
  if (text_of(content, "schema", path, true) != kSchema) refuse(path, concat("its schema is not ", kSchema));
  if (!content.contains("rows") || !content.at("rows").is_array())
    refuse(path, "'rows' is missing or not a list");
  std::string text = concat("\n## ", text_of(content, "section", path, true), "\n");
  if (const std::string note = text_of(content, "note", path, false); !note.empty())
    text += concat('\n', note, '\n');
  text += "\n| what | figure | mark | command | version |\n|---|---|---|---|---|\n";
  for (const json& row : content.at("rows")) text += row_of(row, path);
  return text;
}

}  // namespace

std::string results_page(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code missing;
  for (const auto& file : fs::directory_iterator(folder, missing))
    if (file.path().extension() == ".json") files.push_back(file.path().string());
  if (files.empty()) refuse(folder, "no records (*.json)");
  std::sort(files.begin(), files.end());
  std::string page =
      "# Results\n\n"
      "Written by `./dev bench results` from the records in `docs/results`; change the records, not this "
      "page.\n\n"
      "Each figure stands beside its mark and the command that prints it. `bench` stands for `./dev bench`, "
      "`experiment` for\n"
      "`./dev experiment`. A bold figure misses its mark. Simulated devices and cells only; nothing has been "
      "tried on hardware.\n";
  for (const std::string& file : files) page += section_of(file);
  return page;
}

}  // namespace stonestack::bench
