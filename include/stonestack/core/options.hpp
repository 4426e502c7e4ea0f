#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

/// One list of fields per options struct gives reading, writing and overriding.
///
///   struct SettleOptions {
///     double step = 1.0 / 240.0;  ///< time step, s
///     int iterations = 50;
///   };
///   FieldList fields(SettleOptions& o) {
///     return {user(field("step", o.step, {1e-4, 0.02}, "s", "time step of the simulation")),
///             field("iterations", o.iterations, {1, 1000}, "", "solver iterations in a step")};
///   }
///
/// A field's value is checked against its range wherever it comes from; unknown names are errors.
/// An option is for users if it is marked so, else for experts. What nobody needs to set is no option but a
/// constant in its room's constants.hpp.
namespace stonestack::core {

/// Inclusive range of a number.
struct FieldRange {
  double low = -1e300;  ///< lowest value that is allowed
  double high = 1e300;  ///< highest value that is allowed
};

/// Audience of an option.
enum class Tier {
  kUser,    ///< shown by `config show`
  kExpert,  ///< shown by `config show --expert`; a test or a benchmark sets it
};

/// One option of a struct: its name, where it lies, and what a reader needs to know.
struct Field {
  std::string name;  ///< name of the option, with the prefix of its group: search.friction
  std::variant<double*, int*, bool*, std::string*> value;  ///< the option itself, inside its struct
  FieldRange range;                                        ///< limits of a number
  std::string unit;                                        ///< "m", "rad", "" for a pure number
  std::string description;                                 ///< effect, in plain English
  Tier tier = Tier::kExpert;  ///< user options are listed by `config show`, the others with --expert
};
/// Options of a struct, in the order in which they are listed.
using FieldList = std::vector<Field>;

/// Describes a number with a fraction.
[[nodiscard]] Field field(std::string name, double& value, FieldRange range, std::string unit,
                          std::string description);
/// Describes a whole number.
[[nodiscard]] Field field(std::string name, int& value, FieldRange range, std::string unit,
                          std::string description);
/// Describes a switch.
[[nodiscard]] Field field(std::string name, bool& value, std::string description);
/// Describes a text.
[[nodiscard]] Field field(std::string name, std::string& value, std::string description);

/// Marks a field as one for users.
[[nodiscard]] Field user(Field field);
/// Marks every field of a list.
[[nodiscard]] FieldList user(FieldList list);
/// Fields for users.
[[nodiscard]] FieldList user_fields(const FieldList& list);

/// Prefixes every name with `prefix.`: several structs in one file, `search.friction`.
[[nodiscard]] FieldList nest(const std::string& prefix, FieldList list);
/// Joins lists.
[[nodiscard]] FieldList join(std::vector<FieldList> lists);

/// Applies "name=value".
/// @throws InvalidArgument that names the field, the value and the range; for an unknown name it asks whether
/// one of the nearest was meant.
void set_field(const FieldList& list, std::string_view assignment);
/// Reads a YAML file of `name: value` (nested maps become `a.b`). A name that is not in `list` but in
/// `others` (options of other parts of a program that share the file) is set there.
/// @throws FileError with file, name and value.
void read_fields(const FieldList& list, const std::string& path, const FieldList& others = {});
/// YAML text, a line a field, with range, unit and description as comments.
[[nodiscard]] std::string write_fields(const FieldList& list);
/// The value as text.
[[nodiscard]] std::string field_text(const Field& field);

/// Letters to insert, leave out or replace until `a` is `b` (Levenshtein).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The names that `name` may be a slip of, at most three: those that begin with it, then the nearest at an
/// edit distance (swapped neighbours: 1) of at most a third of its length (at least 1). May be none.
[[nodiscard]] std::vector<std::string> likely_meant(const std::vector<std::string>& names,
                                                    std::string_view name);

}  // namespace stonestack::core

#pragma GCC visibility pop
