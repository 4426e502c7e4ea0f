#include "urscript/value.hpp"

#include <cmath>
#include <cstdio>

#include "stonestack/core/error.hpp"

namespace stonestack::urscript {
namespace {

const char* kind(const Value& value) {
  static constexpr const char* kNames[] = {"None", "Boolean", "Integer", "Float", "String",
                                           "List", "Pose",    "Thread",  "Struct"};
  return kNames[value.is.index()];
}

[[noreturn]] void wrong_type(const char* expected, const Value& value) {
  throw ScriptError{concat("Type error: expected ", expected, ", got ", kind(value))};
}

bool is_number(const Value& value) {
  return std::holds_alternative<long long>(value.is) || std::holds_alternative<double>(value.is);
}

bool is_integer(const Value& value) {
  return std::holds_alternative<long long>(value.is);
}

std::string print_number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%g", value);
  return buffer;
}

// Elements of a list or structure, those of inner ones included.
std::size_t count(const Value& value, std::size_t depth) {
  const auto* list = std::get_if<List>(&value.is);
  const auto* fields = std::get_if<Fields>(&value.is);
  if (!list && !fields) return 0;
  if (depth > kDeepestList) throw ScriptError{"Lists are nested too deep"};
  std::size_t sum = 0;
  if (list)
    for (const auto& item : *list) sum += 1 + count(item, depth + 1);
  if (fields)
    for (const auto& field : *fields) sum += 1 + count(field.value, depth + 1);
  return sum;
}

Value arithmetic(Operator op, const Value& a, const Value& b) {
  if (op == Operator::kDivide) {
    if (number(b) == 0) throw ScriptError{"Division by zero"};
    return number(a) / number(b);
  }
  if (op == Operator::kModulo) {
    if (number(b) == 0) throw ScriptError{"Division by zero"};
    const double rest = std::fmod(number(a), number(b));
    if (is_integer(a) && is_integer(b)) return static_cast<long long>(rest);
    return rest;
  }
  if (is_integer(a) && is_integer(b)) {
    const auto x = static_cast<unsigned long long>(integer(a)),
               y = static_cast<unsigned long long>(integer(b));
    const auto result = op == Operator::kAdd ? x + y : op == Operator::kSubtract ? x - y : x * y;
    return static_cast<long long>(
        static_cast<std::int32_t>(result));  // the controller's integers have 32 bits
  }
  const double x = number(a), y = number(b);
  return op == Operator::kAdd ? x + y : op == Operator::kSubtract ? x - y : x * y;
}

Value elementwise(Operator op, const Value& a, const Value& b) {
  const auto* x = std::get_if<List>(&a.is);
  const auto* y = std::get_if<List>(&b.is);
  if (x && y && x->size() != y->size())
    throw ScriptError{concat("Type error: lists of ", x->size(), " and ", y->size(), " elements")};
  List result;
  const std::size_t size = x ? x->size() : y->size();
  for (std::size_t i = 0; i < size; ++i) result.push_back(apply(op, x ? (*x)[i] : a, y ? (*y)[i] : b));
  return result;
}

bool equal(const Value& a, const Value& b) {
  if (is_number(a) && is_number(b)) return number(a) == number(b);
  if (a.is.index() != b.is.index()) {
    // A thread handle compares with the 0 that programs initialise it with.
    if (const auto* handle = std::get_if<ThreadHandle>(&a.is)) return is_number(b) && handle->id == number(b);
    if (const auto* handle = std::get_if<ThreadHandle>(&b.is)) return is_number(a) && handle->id == number(a);
    return false;
  }
  if (const auto* x = std::get_if<List>(&a.is)) {
    const auto& y = std::get<List>(b.is);
    if (x->size() != y.size()) return false;
    for (std::size_t i = 0; i < x->size(); ++i)
      if (!equal((*x)[i], y[i])) return false;
    return true;
  }
  if (const auto* x = std::get_if<Fields>(&a.is)) {
    const auto& y = std::get<Fields>(b.is);
    return std::equal(x->begin(), x->end(), y.begin(), y.end(), [](const NamedValue& f, const NamedValue& g) {
      return f.name == g.name && equal(f.value, g.value);
    });
  }
  if (const auto* x = std::get_if<std::string>(&a.is)) return *x == std::get<std::string>(b.is);
  if (const auto* x = std::get_if<PoseVector>(&a.is)) return *x == std::get<PoseVector>(b.is);
  if (const auto* x = std::get_if<bool>(&a.is)) return *x == std::get<bool>(b.is);
  if (const auto* x = std::get_if<ThreadHandle>(&a.is)) return x->id == std::get<ThreadHandle>(b.is).id;
  return true;
}

std::size_t place(long long index, std::size_t size) {
  if (index < 0 || static_cast<std::size_t>(index) >= size)
    throw ScriptError{concat("Index out of bounds: ", index, " of ", size)};
  return static_cast<std::size_t>(index);
}

// The member of a structure, const as the structure is.
template <class AnyValue>
auto& named(AnyValue& value, const std::string& name) {
  auto* fields = std::get_if<Fields>(&value.is);
  if (!fields) wrong_type("Struct", value);
  for (auto& field : *fields)
    if (field.name == name) return field.value;
  throw ScriptError{"The struct has no member '" + name + "'"};
}

}  // namespace

bool truth(const Value& value) {
  if (const auto* it = std::get_if<bool>(&value.is)) return *it;
  if (is_number(value)) return number(value) != 0;
  wrong_type("Boolean", value);
}

double number(const Value& value) {
  if (const auto* it = std::get_if<double>(&value.is)) return *it;
  if (const auto* it = std::get_if<long long>(&value.is)) return static_cast<double>(*it);
  wrong_type("Number", value);
}

long long integer(const Value& value) {
  if (const auto* it = std::get_if<long long>(&value.is)) return *it;
  if (const auto* it = std::get_if<double>(&value.is); it && std::abs(*it) < 9e15)
    return static_cast<long long>(*it);
  if (const auto* it = std::get_if<bool>(&value.is)) return *it ? 1 : 0;
  wrong_type("Integer", value);
}

const std::string& text(const Value& value) {
  if (const auto* it = std::get_if<std::string>(&value.is)) return *it;
  wrong_type("String", value);
}

bool is_pose(const Value& value) {
  return std::holds_alternative<PoseVector>(value.is);
}

PoseVector six(const Value& value) {
  PoseVector result;
  if (const auto* it = std::get_if<PoseVector>(&value.is)) {
    result = *it;
  } else {
    const auto* list = std::get_if<List>(&value.is);
    if (!list || list->size() != 6) wrong_type("six numbers", value);
    for (int i = 0; i < 6; ++i) result[i] = number((*list)[static_cast<std::size_t>(i)]);
  }
  if (!result.allFinite()) throw ScriptError{"Value error: a number is not finite"};
  return result;
}

Joints joints(const Value& value) {
  if (is_pose(value)) wrong_type("joint positions", value);
  return six(value);
}

Eigen::Vector3d three(const Value& value) {
  const auto* list = std::get_if<List>(&value.is);
  if (!list || list->size() != 3) wrong_type("three numbers", value);
  const Eigen::Vector3d result(number((*list)[0]), number((*list)[1]), number((*list)[2]));
  if (!result.allFinite()) throw ScriptError{"Value error: a number is not finite"};
  return result;
}

Value to_list(const Joints& q) {
  return List(q.data(), q.data() + 6);
}

Value to_list(const Eigen::Vector3d& v) {
  return List(v.data(), v.data() + 3);
}

PoseVector to_vector(const Pose& pose) {
  const Eigen::AngleAxisd turn(pose.rotation());
  PoseVector vector;
  vector << pose.translation(), turn.angle() * turn.axis();
  return vector;
}

Pose to_pose(const PoseVector& vector) {
  Pose pose = Pose::Identity();
  pose.translation() = vector.head<3>();
  const double angle = vector.tail<3>().norm();
  if (angle > 1e-12) pose.linear() = Eigen::AngleAxisd(angle, vector.tail<3>() / angle).toRotationMatrix();
  return pose;
}

std::string print(const Value& value) {
  if (const auto* it = std::get_if<bool>(&value.is)) return *it ? "True" : "False";
  if (const auto* it = std::get_if<long long>(&value.is)) return std::to_string(*it);
  if (const auto* it = std::get_if<double>(&value.is)) return print_number(*it);
  if (const auto* it = std::get_if<std::string>(&value.is)) return *it;
  if (const auto* it = std::get_if<ThreadHandle>(&value.is)) return std::to_string(it->id);
  if (const auto* it = std::get_if<PoseVector>(&value.is)) {
    std::string line = "p[";
    for (int i = 0; i < 6; ++i) line += (i ? "," : "") + print_number((*it)[i]);
    return line + "]";
  }
  if (const auto* fields = std::get_if<Fields>(&value.is)) {
    std::string line = "struct(";
    for (const auto& field : *fields)
      line += (line.back() == '(' ? "" : ",") + field.name + "=" + print(field.value);
    return line + ")";
  }
  const auto* list = std::get_if<List>(&value.is);
  if (!list) return "None";
  std::string line = "[";
  for (std::size_t i = 0; i < list->size() && line.size() < kLongestText; ++i)
    line += (i ? "," : "") + print((*list)[i]);
  return line + "]";
}

Value apply(Operator op, const Value& a, const Value& b) {
  switch (op) {
    case Operator::kEqual:
      return equal(a, b);
    case Operator::kNotEqual:
      return !equal(a, b);
    case Operator::kLess:
      return number(a) < number(b);
    case Operator::kGreater:
      return number(a) > number(b);
    case Operator::kLessEqual:
      return number(a) <= number(b);
    case Operator::kGreaterEqual:
      return number(a) >= number(b);
    case Operator::kXor:
      return truth(a) != truth(b);
    default:
      break;
  }
  if (std::holds_alternative<List>(a.is) || std::holds_alternative<List>(b.is)) return elementwise(op, a, b);
  return arithmetic(op, a, b);
}

long long whole_number(double number) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<long long>(number)));
}

Value negate(const Value& value) {
  if (const auto* it = std::get_if<long long>(&value.is)) return whole_number(-static_cast<double>(*it));
  if (std::holds_alternative<List>(value.is)) return elementwise(Operator::kMultiply, Value(-1), value);
  return -number(value);
}

Value element(const Value& value, long long index) {
  if (const auto* list = std::get_if<List>(&value.is)) return (*list)[place(index, list->size())];
  if (const auto* pose = std::get_if<PoseVector>(&value.is))
    return (*pose)[static_cast<Eigen::Index>(place(index, 6))];
  if (const auto* string = std::get_if<std::string>(&value.is))
    return std::string(1, (*string)[place(index, string->size())]);
  wrong_type("List", value);
}

void set_element(Value& value, long long index, Value item) {
  if (auto* list = std::get_if<List>(&value.is)) {
    (*list)[place(index, list->size())] = std::move(item);
    check_size(value);
  } else if (auto* pose = std::get_if<PoseVector>(&value.is)) {
    (*pose)[static_cast<Eigen::Index>(place(index, 6))] = number(item);
  } else {
    wrong_type("List", value);
  }
}

Value member(const Value& value, const Value& key) {
  const auto* name = std::get_if<std::string>(&key.is);
  return name ? named(value, *name) : element(value, integer(key));
}

Value& member(Value& value, const Value& key) {
  if (const auto* name = std::get_if<std::string>(&key.is)) return named(value, *name);
  auto* list = std::get_if<List>(&value.is);
  if (!list) wrong_type("List", value);
  return (*list)[place(integer(key), list->size())];
}

void set_member(Value& value, const Value& key, Value item) {
  if (!std::holds_alternative<std::string>(key.is)) return set_element(value, integer(key), std::move(item));
  member(value, key) = std::move(item);
  check_size(value);
}

int weight(const Value& value) {
  constexpr std::size_t kCharacters = 16;
  int sum = 0;
  if (const auto* string = std::get_if<std::string>(&value.is))
    sum = static_cast<int>(string->size() / kCharacters);
  if (const auto* list = std::get_if<List>(&value.is))
    for (const auto& item : *list) sum += 1 + weight(item);
  if (const auto* fields = std::get_if<Fields>(&value.is))
    for (const auto& field : *fields) sum += 1 + weight(field.value);
  return sum;
}

void check_size(const Value& value) {
  if (count(value, 0) > kLongestList) throw ScriptError{"A list has too many elements"};
}

}  // namespace stonestack::urscript
