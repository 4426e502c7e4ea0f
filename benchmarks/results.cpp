#include <iostream>
#include <memory>

#include "bench.hpp"
#include "results_page.hpp"

namespace stonestack::bench {

void add_results(CLI::App& app) {
  CLI::App* sub = app.add_subcommand("results", "Print docs/results.md as its records give it");
  auto folder = std::make_shared<std::string>("docs/results");
  sub->add_option("--records", *folder, "Folder of the records (schema stonestack.results/1)")
      ->capture_default_str();
  sub->footer("Example:\n  stonestack-bench results > docs/results.md");
  sub->callback([folder] { std::cout << results_page(*folder); });
}

}  // namespace stonestack::bench
