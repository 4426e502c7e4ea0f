// Reads result.json of a run: 8_read_a_result RUN/result.json. Any JSON library will do.
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s RUN/result.json\n", argv[0]);
    return 2;
  }
  std::ifstream file(argv[1]);
  const nlohmann::json run = nlohmann::json::parse(file);
  if (run.at("schema") != "stonestack.run/1") throw std::runtime_error("not a stonestack.run/1 file");
  for (const auto& placement : run.at("placements"))
    std::printf("%-12s %s\n", placement.at("stone").get<std::string>().c_str(),
                placement.at("outcome").get<std::string>().c_str());
  std::printf("height %d: %s\n", run.at("height").get<int>(), run.at("ended").get<std::string>().c_str());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 3;
}
