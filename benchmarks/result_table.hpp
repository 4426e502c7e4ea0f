#pragma once
#include <iosfwd>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "rooms.hpp"

namespace stonestack::bench {

/// A value in a table; empty where there is nothing to state. A double that is not finite counts as empty.
class TableValue {
 public:
  TableValue() = default;
  TableValue(bool value) : value_(value) {}
  TableValue(int value) : value_(static_cast<long long>(value)) {}
  TableValue(long value) : value_(static_cast<long long>(value)) {}
  TableValue(std::size_t value) : value_(static_cast<long long>(value)) {}
  TableValue(double value);
  TableValue(const char* value) : value_(std::string(value)) {}
  TableValue(std::string value) : value_(std::move(value)) {}

  using Variant = std::variant<std::monostate, bool, long long, double, std::string>;
  [[nodiscard]] const Variant& value() const { return value_; }

 private:
  Variant value_;
};

/// A column: its key in JSON, words and unit joined by underscores ("plan_ms_median"), which with spaces is
/// its heading, and how its doubles are printed.
struct Column {
  std::string key;
  int decimals = 2;  ///< negative: three significant digits
};

/// A value under its name.
struct Figure {
  std::string key;
  TableValue value;
  int decimals = 2;  ///< as in Column
};

/// The report of a benchmark: its settings, tables of results, and notes. As text each line is printed as
/// soon as it is known; as JSON one document is printed by finish(), and notes go to the error stream:
///
///     {"schema": "stonestack.bench/1", "benchmark": NAME, "version": ..., "complete": true, "settings": {KEY: value},
///      "tables": [{"name": ..., "columns": [KEY, ...], "rows": [{KEY: value or null}]}]}
class Results {
 public:
  struct Format {
    bool json = false;
    std::string version;
  };
  Results(std::string benchmark, const Format& format, std::ostream& out, std::ostream& notes);
  ~Results();

  /// Settings that the figures depend on; call it once, before the first table.
  void settings(const std::vector<Figure>& figures);
  /// Begins a table, to which row() adds.
  void table(const std::string& name, std::vector<Column> columns);
  /// A row of the table that was begun last. Throws InvalidArgument for another number of cells than columns.
  void row(const std::vector<TableValue>& cells);
  /// A table of one row, printed as one line a figure.
  void figures(const std::string& name, const std::vector<Figure>& figures);
  /// A line that is not data, as printf formats it.
  void note(const char* format, ...) __attribute__((format(printf, 2, 3)));
  /// Prints what is still to be printed. `complete` is false if the benchmark was interrupted or failed.
  void finish(bool complete);
  /// Gives the document that --json prints, with the command that measured it under "command".
  /// @return JSON, ending with a line break.
  [[nodiscard]] std::string record(const std::string& command) const;

 private:
  struct Document;
  std::unique_ptr<Document> document_;
  std::vector<Column> columns_;
  bool json_;
  std::ostream& out_;
  std::ostream& notes_;
};

}  // namespace stonestack::bench
