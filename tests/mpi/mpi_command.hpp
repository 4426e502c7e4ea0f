#pragma once
#include "apps/commands.hpp"

namespace stonestack {

/// Runs stonestack-mpi by mpirun, in a folder of its own.
class MpiCommand : public Commands {
 protected:
  void SetUp() override {
    ASSERT_EQ(std::system("command -v mpirun > /dev/null"), 0)
        << "mpirun is not installed: `./dev packages` does";
    Commands::SetUp();
    ::setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
    ::setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  }
  void TearDown() override {
    if (!folder_.empty()) Commands::TearDown();
  }

  static std::string command_on(int ranks, const std::string& arguments) {
    return concat("timeout 800 mpirun --oversubscribe -n ", ranks, ' ', STONESTACK_MPI_BINARY, ' ',
                  arguments);
  }
  [[nodiscard]] Outcome run_on(int ranks, const std::string& arguments) const {
    return shell(concat("cd ", folder_, " && ", command_on(ranks, arguments), " 2>err"));
  }
  [[nodiscard]] std::string file(const std::string& name) const {
    return read_file(folder_ + "/" + name, 1U << 24U);
  }
  static void expect_refused(const Outcome& outcome, const std::string& message) {
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    const std::size_t first = outcome.err.find(message);
    EXPECT_NE(first, std::string::npos) << outcome.err;
    EXPECT_EQ(first, outcome.err.rfind(message)) << "more ranks than one print";
  }
};

}  // namespace stonestack
