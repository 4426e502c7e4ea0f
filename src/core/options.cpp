#include "stonestack/core/options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "core/yaml.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

constexpr std::size_t kMaxSuggested = 3;  // names

std::string number_text(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

std::string range_text(const Field& f) {
  return concat("[", number_text(f.range.low), ", ", number_text(f.range.high), "]",
                f.unit.empty() ? "" : " " + f.unit);
}

/// "; did you mean a, b or c?", or nothing. The group in front may have been left out.
std::string suggestion(const FieldList& list, std::string_view name) {
  std::vector<std::string> names, last_words;
  for (const Field& f : list) {
    names.push_back(f.name);
    last_words.push_back(f.name.substr(f.name.rfind('.') + 1));
  }
  std::vector<std::string> meant = likely_meant(names, name);
  if (meant.empty() && name.find('.') == std::string_view::npos)
    for (const std::string& word : likely_meant(last_words, name))
      for (std::size_t i = 0; i < names.size() && meant.size() < kMaxSuggested; ++i)
        if (last_words[i] == word && std::find(meant.begin(), meant.end(), names[i]) == meant.end())
          meant.push_back(names[i]);
  std::string text;
  for (std::size_t i = 0; i < meant.size(); ++i)
    text += concat(i == 0 ? "; did you mean " : i + 1 < meant.size() ? ", " : " or ", meant[i]);
  return meant.empty() ? text : text + "?";
}

/// Parses and range-checks; the message has no file name, the caller adds it.
void assign(const Field& f, const std::string& text) {
  if (auto* flag = std::get_if<bool*>(&f.value)) {
    require(text == "true" || text == "false", f.name, " must be true or false, got '", text, "'");
    **flag = text == "true";
  } else if (auto* word = std::get_if<std::string*>(&f.value)) {
    **word = text;
  } else {
    double number = std::nan("");
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool whole = error == std::errc() && end == text.data() + text.size() && std::isfinite(number);
    require(whole, f.name, " must be a number in ", range_text(f), ", got '", text, "'");
    require(number >= f.range.low && number <= f.range.high, f.name, " must be in ", range_text(f), ", got ",
            text);
    if (auto* real = std::get_if<double*>(&f.value)) {
      **real = number;
    } else {
      require(number == std::floor(number), f.name, " must be a whole number, got ", text);
      *std::get<int*>(f.value) = static_cast<int>(number);
    }
  }
}

const Field& find(const FieldList& list, std::string_view name) {
  const auto it = std::find_if(list.begin(), list.end(), [&](const Field& f) { return f.name == name; });
  require(!list.empty(), "unknown option '", name, "'; this command has none to set");
  require(it != list.end(), "unknown option '", name, "'", suggestion(list, name));
  return *it;
}

}  // namespace

Field field(std::string name, double& value, FieldRange range, std::string unit, std::string description) {
  return {std::move(name), &value, range, std::move(unit), std::move(description)};
}
Field field(std::string name, int& value, FieldRange range, std::string unit, std::string description) {
  return {std::move(name), &value, range, std::move(unit), std::move(description)};
}
Field field(std::string name, bool& value, std::string description) {
  return {std::move(name), &value, {}, "", std::move(description)};
}
Field field(std::string name, std::string& value, std::string description) {
  return {std::move(name), &value, {}, "", std::move(description)};
}

Field user(Field field) {
  field.tier = Tier::kUser;
  return field;
}

FieldList user(FieldList list) {
  for (auto& f : list) f.tier = Tier::kUser;
  return list;
}

FieldList user_fields(const FieldList& list) {
  FieldList chosen;
  std::copy_if(list.begin(), list.end(), std::back_inserter(chosen),
               [](const Field& f) { return f.tier == Tier::kUser; });
  return chosen;
}

FieldList nest(const std::string& prefix, FieldList list) {
  for (auto& f : list) f.name = prefix + "." + f.name;
  return list;
}

FieldList join(std::vector<FieldList> lists) {
  FieldList all;
  for (auto& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

void set_field(const FieldList& list, std::string_view assignment) {
  const auto equals = assignment.find('=');
  require(equals != std::string_view::npos, "expected name=value, got '", assignment, "'");
  assign(find(list, assignment.substr(0, equals)), std::string(assignment.substr(equals + 1)));
}

void read_fields(const FieldList& list, const std::string& path, const FieldList& others) {
  const auto root = yaml::read_file(path);
  FieldList all = list;  // first: a name in both lists means this one
  all.insert(all.end(), others.begin(), others.end());
  try {
    yaml::for_each_scalar(
        root, [&](const std::string& name, const std::string& text) { assign(find(all, name), text); });
  } catch (const InvalidArgument& problem) {
    throw FileError(path, problem.what(),
                    "`stonestack config show --expert` lists every option with its range, `config cell "
                    "--expert` those of cells");
  }
}

std::string field_text(const Field& f) {
  if (const auto* flag = std::get_if<bool*>(&f.value)) return **flag ? "true" : "false";
  if (const auto* word = std::get_if<std::string*>(&f.value)) return **word;
  if (const auto* whole = std::get_if<int*>(&f.value)) return std::to_string(**whole);
  return number_text(*std::get<double*>(f.value));
}

std::string write_fields(const FieldList& list) {
  std::string text;
  for (const auto& f : list) {
    const bool number = std::holds_alternative<double*>(f.value) || std::holds_alternative<int*>(f.value);
    text += concat(f.name, ": ", field_text(f), "  #", number ? " " + range_text(f) : "", " ", f.description,
                   "\n");
  }
  return text;
}

}  // namespace stonestack::core
