#pragma once
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "result_table.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/experiment/experiment.hpp"

namespace stonestack::bench {

/// The independent draws of a benchmark, numbered from 1 in the order in which it asks for them. A process
/// performs those of its shard, as an experiment its runs; what is known of a draw is not performed again. So
/// a benchmark that makes its tables of these outcomes makes the same tables of one process and of shards.
class Draws {
 public:
  using Json = nlohmann::json;

  /// All draws.
  Draws() = default;
  /// Draws of a shard. `keep` is called after each draw that was performed.
  Draws(const Shard& shard, std::function<void()> keep) : shard_(shard), keep_(std::move(keep)) {}
  /// None: all outcomes come from add().
  [[nodiscard]] static Draws of_shards();

  /// Adds the outcomes that records() gave in another process. Throws InvalidArgument for a draw that is
  /// known.
  void add(const Json& records);
  /// Outcomes that are known, [{"number": ..., "draw": NAME, "outcome": ...}].
  [[nodiscard]] Json records() const;
  /// False where nothing is performed, so that stones need no shapes.
  [[nodiscard]] bool performs() const { return performs_; }
  /// False for a process that performs all.
  [[nodiscard]] bool divided() const { return !performs_ || shard_.count > 1; }
  /// Numbers of the draws, asked for till now, that neither are known nor belong to another shard.
  [[nodiscard]] const std::vector<int>& missing() const { return missing_; }

  /// Performs draws 0 to `total` - 1 of a group that `name` names, as far as they are of the shard and no
  /// interrupt is noted. `perform(k)` gives an outcome that has to_json and from_json.
  /// @return the outcomes that are known, in order
  template <class Perform>
  [[nodiscard]] auto outcomes(const std::string& name, int total, const Perform& perform) {
    using Outcome = std::decay_t<decltype(perform(0))>;
    std::vector<Outcome> list;
    for (int k = 0; k < total; ++k) {
      const int number = ++asked_;
      const std::string draw = concat(name, ' ', k);
      if (const Json* known = find(number, draw)) {
        try {
          list.push_back(known->get<Outcome>());
        } catch (const Json::exception& fault) {
          throw FileError("the record", concat("of draw ", number, " cannot be read: ", fault.what()),
                          "perform the shard that holds it again");
        }
        continue;
      }
      if (performs_ && !shard_.has(number)) continue;
      if (performs_ && !interrupt_noted()) {
        Outcome made = perform(k);
        if (!interrupt_noted()) {  // what was found till then is no draw
          learn(number, draw, made);
          list.push_back(std::move(made));
          continue;
        }
      }
      missing_.push_back(number);
    }
    return list;
  }

 private:
  struct Known {
    std::string draw;
    Json outcome;
  };
  [[nodiscard]] const Json* find(int number, const std::string& draw) const;
  void learn(int number, const std::string& draw, Json outcome);

  bool performs_ = true;
  Shard shard_;
  std::function<void()> keep_;
  std::map<int, Known> known_;
  int asked_ = 0;
  std::vector<int> missing_;
};

void to_json(nlohmann::json& json, const TableValue& value);
void from_json(const nlohmann::json& json, TableValue& value);

}  // namespace stonestack::bench
