#pragma once
#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "stonestack/geometry/pose.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::urscript {

/// A run-time error of a script; the machine adds the line.
struct ScriptError {
  std::string text;
};

struct Value;
using List = std::vector<Value>;
/// x, y, z, rotation vector: `p[...]`.
using PoseVector = Eigen::Matrix<double, 6, 1>;
/// A named part of `struct(name=value, ...)`.
struct NamedValue;
using Fields = std::vector<NamedValue>;
/// Handle that `run` returns.
struct ThreadHandle {
  int id = 0;
};

/// A value of the language.
struct Value {
  std::variant<std::monostate, bool, long long, double, std::string, List, PoseVector, ThreadHandle, Fields>
      is;

  Value();
  Value(const Value& other);
  Value(Value&& other) noexcept;
  Value& operator=(const Value& other);
  Value& operator=(Value&& other) noexcept;
  ~Value();
  Value(bool value);          // NOLINT: a value is what it holds
  Value(int value);           // NOLINT
  Value(long long value);     // NOLINT
  Value(double value);        // NOLINT
  Value(std::string value);   // NOLINT
  Value(const char* value);   // NOLINT
  Value(List value);          // NOLINT
  Value(PoseVector value);    // NOLINT
  Value(ThreadHandle value);  // NOLINT
  Value(Fields value);        // NOLINT
};

struct NamedValue {
  std::string name;
  Value value;
};

// A field holds a value: only now is either complete.
inline Value::Value() = default;
inline Value::Value(const Value& other) = default;
inline Value::Value(Value&& other) noexcept = default;
inline Value& Value::operator=(const Value& other) = default;
inline Value& Value::operator=(Value&& other) noexcept = default;
inline Value::~Value() = default;
inline Value::Value(bool value) : is(value) {}
inline Value::Value(int value) : is(static_cast<long long>(value)) {}
inline Value::Value(long long value) : is(value) {}
inline Value::Value(double value) : is(value) {}
inline Value::Value(std::string value) : is(std::move(value)) {}
inline Value::Value(const char* value) : is(std::string(value)) {}
inline Value::Value(List value) : is(std::move(value)) {}
inline Value::Value(PoseVector value) : is(std::move(value)) {}
inline Value::Value(ThreadHandle value) : is(value) {}
inline Value::Value(Fields value) : is(std::move(value)) {}

inline constexpr std::size_t kLongestText = 65536;  ///< characters of a string
inline constexpr std::size_t kLongestList = 16384;  ///< elements, those of inner lists included
inline constexpr std::size_t kDeepestList = 16;

/// These throw ScriptError when the value is of another kind.
[[nodiscard]] bool truth(const Value& value);
[[nodiscard]] double number(const Value& value);
[[nodiscard]] long long integer(const Value& value);
[[nodiscard]] const std::string& text(const Value& value);
/// Six numbers from a list or pose.
[[nodiscard]] PoseVector six(const Value& value);
[[nodiscard]] Joints joints(const Value& value);
[[nodiscard]] Eigen::Vector3d three(const Value& value);
[[nodiscard]] bool is_pose(const Value& value);

[[nodiscard]] Value to_list(const Joints& q);
[[nodiscard]] Value to_list(const Eigen::Vector3d& v);
[[nodiscard]] PoseVector to_vector(const Pose& pose);
[[nodiscard]] Pose to_pose(const PoseVector& vector);

/// As textmsg and to_str print it.
[[nodiscard]] std::string print(const Value& value);

enum class Operator {
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kModulo,
  kEqual,
  kNotEqual,
  kLess,
  kGreater,
  kLessEqual,
  kGreaterEqual,
  kXor
};
[[nodiscard]] Value apply(Operator op, const Value& a, const Value& b);
[[nodiscard]] Value negate(const Value& value);
/// An integer as the controller has it, of 32 bits: what is beyond goes round. For |number| below 2^53.
[[nodiscard]] long long whole_number(double number);
/// value[index]; a list, pose or string.
[[nodiscard]] Value element(const Value& value, long long index);
/// value[index] = element, in place.
void set_element(Value& value, long long index, Value element);
/// value[key], or value.key where the key is a string.
[[nodiscard]] Value member(const Value& value, const Value& key);
/// Returns the member in place; no element of a pose.
[[nodiscard]] Value& member(Value& value, const Value& key);
void set_member(Value& value, const Value& key, Value item);
/// Cost of a copy: elements, those of inner lists included, and a sixteenth of the characters.
[[nodiscard]] int weight(const Value& value);
/// Throws when a list or structure has grown beyond the limits.
void check_size(const Value& value);

}  // namespace stonestack::urscript
