#include "draws.hpp"

namespace stonestack::bench {
namespace {

/// A number that is not finite is null in a file.
void restore_numbers(nlohmann::json& value) {
  if (value.is_null()) value = std::nan("");
  if (value.is_structured())
    for (nlohmann::json& part : value) restore_numbers(part);
}

}  // namespace

Draws Draws::of_shards() {
  Draws draws;
  draws.performs_ = false;
  return draws;
}

void Draws::add(const Json& records) {
  for (const Json& record : records) {
    const int number = record.at("number");
    const auto [there, is_new] = known_.insert({number, {record.at("draw"), record.at("outcome")}});
    require(is_new, "draw ", number, " is there twice");
    restore_numbers(there->second.outcome);
  }
}

Draws::Json Draws::records() const {
  Json list = Json::array();
  for (const auto& [number, known] : known_)
    list.push_back({{"number", number}, {"draw", known.draw}, {"outcome", known.outcome}});
  return list;
}

const Draws::Json* Draws::find(int number, const std::string& draw) const {
  const auto there = known_.find(number);
  if (there == known_.end()) return nullptr;
  require(there->second.draw == draw, "draw ", number, " is '", there->second.draw, "' in the record, and '",
          draw, "' here");
  return &there->second.outcome;
}

void Draws::learn(int number, const std::string& draw, Json outcome) {
  known_[number] = {draw, std::move(outcome)};
  if (keep_) keep_();
}

void to_json(nlohmann::json& json, const TableValue& value) {
  std::visit(
      [&](const auto& one) {
        if constexpr (std::is_same_v<std::decay_t<decltype(one)>, std::monostate>)
          json = nullptr;
        else
          json = one;
      },
      value.value());
}

void from_json(const nlohmann::json& json, TableValue& value) {
  if (json.is_boolean())
    value = json.get<bool>();
  else if (json.is_number_integer())
    value = json.get<long>();
  else if (json.is_number())
    value = json.get<double>();  // empty where it is not finite
  else if (json.is_string())
    value = json.get<std::string>();
  else
    value = {};
}

}  // namespace stonestack::bench
