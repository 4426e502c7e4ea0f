// `mpirun -n N stonestack-mpi experiment ...`: the runs of `stonestack experiment`, dealt to N processes.
#include <fcntl.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <iostream>
#include <optional>

#include "commands.hpp"
#include "deal_runs.hpp"
#include "program.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::mpi {
namespace {

/// Rank 0 speaks for all: a rank that prints would print what the others print.
void be_silent() {
  set_log_level(LogLevel::kOff);
  std::cerr.setstate(std::ios::failbit);
  if (const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0) {
    ::dup2(nowhere, STDOUT_FILENO);
    ::close(nowhere);
  }
}

void set_up(CLI::App& app, const Ranks& ranks, bool& took_part) {
  app.name("stonestack-mpi");
  app.description("stonestack-mpi: experiments on many processes and machines, started by mpirun.");
  const auto threads = std::make_shared<int>(1);
  const auto quiet = std::make_shared<const CLI::Option*>(nullptr);
  CLI::App& sub = apps::add_experiment_by(app, [&ranks, &took_part, threads, quiet](
                                                   const ExperimentOrder& order, const Catalogue& catalogue,
                                                   const auto&) {
    using tbb::global_control;
    const global_control limit(global_control::max_allowed_parallelism, static_cast<std::size_t>(*threads));
    took_part = true;
    if (ranks.rank() == 0)
      return deal_runs(ranks, order, catalogue, [&](const std::string& line) {
        if ((*quiet)->count() == 0) std::cerr << line << std::endl;
      });
    perform_dealt_runs(ranks, order, catalogue);
    return RecordedExperiment{};
  });
  sub.add_option("--threads", *threads, "Threads of each process")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  *quiet = sub.get_option("--quiet");
  sub.footer(
      "The record is the one that `stonestack experiment` makes with the same arguments.\n"
      "All processes see the folder --out.\n"
      "Examples:\n"
      "  mpirun -n 8 stonestack-mpi experiment --runs 200 --seed 5 --out whole\n"
      "  mpirun -n 8 stonestack-mpi experiment --runs 200 --seed 5 --out whole --continue\n"
      "When a process dies, mpirun ends the others: the second line performs the runs that had not ended.");
}

/// Runs the program. A rank that ends before it took part says so to those that would wait for it.
int run(const Ranks& ranks, int argc, char** argv) {
  bool took_part = false;
  set_log_level(LogLevel::kWarning);
  if (ranks.rank() > 0) be_silent();
  const int code = apps::run_program(argc, argv, [&](CLI::App& app) { set_up(app, ranks, took_part); });
  if (took_part) return code;
  if (ranks.rank() > 0)
    ranks.send(0, Word::kGone,
               concat("rank ", ranks.rank(), " on ", ranks.host(), " ended with code ", code,
                      " before its first run; `stonestack experiment` shows there why"));
  else
    for (int other = 1; other < ranks.size(); ++other) ranks.send(other, Word::kEnd);
  return code;
}

}  // namespace
}  // namespace stonestack::mpi

int main(int argc, char** argv) {
  const stonestack::mpi::Ranks ranks(argc, argv);
  return stonestack::mpi::run(ranks, argc, argv);
}
