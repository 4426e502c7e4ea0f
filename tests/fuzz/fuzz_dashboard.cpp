// What a Dashboard client makes of arbitrary lines.
#include <cstdint>
#include <cstdlib>
#include <sstream>

#include "hardware/ur/dashboard_client.hpp"
#include "protocol/dashboard_text.hpp"
#include "rooms.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
  for (std::string line; std::getline(lines, line);) {
    static_cast<void>(dashboard_truth(line));
    const auto value = dashboard_value(line, "Robotmode:");
    if (value && value->size() > line.size()) std::abort();
    const auto version = parse_polyscope_version(line);
    if (version && parse_polyscope_version(to_string(*version)) != version) std::abort();
    if (is_dashboard_text(line) && line.size() > 1024) std::abort();
  }
  return 0;
}
