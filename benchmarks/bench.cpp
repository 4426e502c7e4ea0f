#include "bench.hpp"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>

#include "version.hpp"

#include "stonestack/core/file.hpp"

namespace stonestack::bench {
namespace {

/// The command line of this process, as one would type it.
std::string own_command() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string words((std::istreambuf_iterator<char>(file)), {});
  if (!words.empty() && words.back() == '\0') words.pop_back();
  std::replace(words.begin(), words.end(), '\0', ' ');
  const std::size_t end = words.find(' ');
  return "bench" + (end == std::string::npos ? "" : words.substr(end));
}

}  // namespace

void measure_by(CLI::App& sub, std::function<void(Results&)> measure) {
  auto json = std::make_shared<bool>(false);
  sub.add_flag("--json", *json, "Result as JSON on stdout (schema stonestack.bench/1)");
  auto record = std::make_shared<std::string>();
  sub.add_option("--record", *record, "Write the result and the command to this JSON file, for docs/results");
  sub.callback([&sub, json, record, measure = std::move(measure)] {
    if (!record->empty()) require_writable(*record);
    Results results(sub.get_name(), {*json, program_version()}, std::cout, std::cerr);
    try {
      measure(results);
    } catch (...) {
      results.finish(false);
      throw;
    }
    results.finish(true);
    if (!record->empty()) write_file(*record, results.record(own_command()));
  });
}

}  // namespace stonestack::bench
