#include "bench.hpp"

#include <iostream>
#include <memory>

#include "version.hpp"

namespace stonestack::bench {

void measure_by(CLI::App& sub, std::function<void(Results&)> measure) {
  auto json = std::make_shared<bool>(false);
  sub.add_flag("--json", *json, "Result as JSON on stdout (schema stonestack.bench/1)");
  sub.callback([&sub, json, measure = std::move(measure)] {
    Results results(sub.get_name(), {*json, program_version()}, std::cout, std::cerr);
    try {
      measure(results);
    } catch (...) {
      results.finish(false);
      throw;
    }
    results.finish(true);
  });
}

}  // namespace stonestack::bench
