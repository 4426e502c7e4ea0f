#include "result_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kNarrowest = 7;  // characters of a column
constexpr std::size_t kNameWidth = 12;

Json to_json(const TableValue& cell) {
  return std::visit(
      [](const auto& value) -> Json {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::monostate>)
          return nullptr;
        else
          return value;
      },
      cell.value());
}

std::string number(double value, int decimals) {
  char text[64];
  if (decimals < 0)
    std::snprintf(text, sizeof text, "%.3g", value);
  else
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

struct ToText {
  int decimals;
  std::string operator()(std::monostate) const { return "-"; }
  std::string operator()(bool value) const { return value ? "yes" : "no"; }
  std::string operator()(long long value) const { return std::to_string(value); }
  std::string operator()(double value) const { return number(value, decimals); }
  std::string operator()(const std::string& value) const { return value; }
};

std::string to_text(const TableValue& cell, int decimals) {
  return std::visit(ToText{decimals}, cell.value());
}

std::string heading(const std::string& key) {
  std::string text = key;
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string padded(const std::string& text, std::size_t width, bool left) {
  const std::string space(width > text.size() ? width - text.size() : 0, ' ');
  return left ? text + space : space + text;
}

/// The first column holds names.
std::size_t width_of(const std::vector<Column>& columns, std::size_t i) {
  return std::max(columns[i].key.size(), i == 0 ? kNameWidth : kNarrowest);
}

void print_line(std::ostream& out, std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  out << line << std::endl;
}

}  // namespace

TableValue::TableValue(double value) {
  if (std::isfinite(value)) value_ = value;
}

struct Results::Document {
  Json json;
};

Results::Results(std::string benchmark, const Format& format, std::ostream& out, std::ostream& notes)
    : document_(std::make_unique<Document>()), json_(format.json), out_(out), notes_(notes) {
  document_->json = {{"schema", "stonestack.bench/1"}, {"benchmark", std::move(benchmark)},
                     {"version", format.version},      {"complete", true},
                     {"settings", Json::object()},     {"tables", Json::array()}};
}

Results::~Results() = default;

void Results::settings(const std::vector<Figure>& figures) {
  std::string line;
  for (const Figure& figure : figures) {
    document_->json["settings"][figure.key] = to_json(figure.value);
    line += concat(line.empty() ? "" : ", ", heading(figure.key), ' ', to_text(figure.value, -1));
  }
  if (!json_) print_line(out_, line);
}

void Results::table(const std::string& name, std::vector<Column> columns) {
  columns_ = std::move(columns);
  Json keys = Json::array();
  for (const Column& column : columns_) keys.push_back(column.key);
  document_->json["tables"].push_back({{"name", name}, {"columns", keys}, {"rows", Json::array()}});
  if (json_) return;
  std::string line;
  for (std::size_t i = 0; i < columns_.size(); ++i)
    line += (i == 0 ? "" : "  ") + padded(heading(columns_[i].key), width_of(columns_, i), i == 0);
  print_line(out_, concat('\n', name));
  print_line(out_, line);
}

void Results::row(const std::vector<TableValue>& cells) {
  require(cells.size() == columns_.size(), "a row has ", cells.size(), " cells, its table ", columns_.size(),
          " columns");
  Json row = Json::object();
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    row[columns_[i].key] = to_json(cells[i]);
    line +=
        (i == 0 ? "" : "  ") + padded(to_text(cells[i], columns_[i].decimals), width_of(columns_, i), i == 0);
  }
  document_->json["tables"].back()["rows"].push_back(std::move(row));
  if (!json_) print_line(out_, line);
}

void Results::figures(const std::string& name, const std::vector<Figure>& figures) {
  columns_.clear();  // no row may follow
  Json keys = Json::array(), row = Json::object();
  std::size_t width = kNameWidth;
  for (const Figure& figure : figures) {
    keys.push_back(figure.key);
    row[figure.key] = to_json(figure.value);
    width = std::max(width, figure.key.size());
  }
  document_->json["tables"].push_back({{"name", name}, {"columns", keys}, {"rows", Json::array({row})}});
  if (json_) return;
  print_line(out_, concat('\n', name));
  for (const Figure& figure : figures)
    print_line(out_, concat("  ", padded(heading(figure.key), width, true), "  ",
                            to_text(figure.value, figure.decimals)));
}

void Results::note(const char* format, ...) {
  std::va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int size = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string line(static_cast<std::size_t>(std::max(0, size)) + 1, '\0');
  std::vsnprintf(line.data(), line.size(), format, again);
  va_end(again);
  line.pop_back();
  print_line(json_ ? notes_ : out_, line);
}

void Results::finish(bool complete) {
  document_->json["complete"] = complete;
  if (json_) out_ << document_->json.dump(2) << std::endl;
}

std::string Results::record(const std::string& command) const {
  Json document = document_->json;
  document["command"] = command;
  return document.dump(2) + '\n';
}

}  // namespace stonestack::bench
