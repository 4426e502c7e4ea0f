// `mpirun -n N stonestack-mpi experiment ...`: the runs of `stonestack experiment`, dealt to N processes;
// `mpirun -n N stonestack-mpi bench --out DIR -- ...`: the draws of `stonestack-bench ...`.
#include <fcntl.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <iostream>
#include <optional>

#include "commands.hpp"
#include "deal_parts.hpp"
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

void add_experiment(CLI::App& app, const Ranks& ranks, bool& took_part) {
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

void add_bench(CLI::App& app, const Ranks& ranks, bool& took_part) {
  const auto order = std::make_shared<BenchOrder>();
  const auto quiet = std::make_shared<bool>(false);
  CLI::App& sub = *app.add_subcommand("bench", "Perform a benchmark of stonestack-bench in parts");
  sub.add_option("arguments", order->arguments, "The benchmark and its options, after --")
      ->required()
      ->type_name("-- BENCHMARK");
  sub.add_option("--out", order->out, "Folder of the parts, which all processes see")
      ->required()
      ->type_name("DIR");
  sub.add_option("--parts", order->parts, "Parts that are dealt: several for each process")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub.add_flag("--continue", order->continues, "Perform what the folder lacks");
  sub.add_option("--program", order->program, "stonestack-bench (default: the one beside this program)")
      ->type_name("FILE");
  sub.add_option("--record", order->record, "Write the merged tables to this file")->type_name("FILE");
  sub.add_flag("--json", order->json, "Result as JSON on stdout");
  sub.add_flag("-q,--quiet", *quiet, "No progress on stderr");
  sub.callback([&ranks, &took_part, order, quiet] {
    if (order->program.empty()) order->program = own_bench();
    took_part = true;
    if (ranks.rank() == 0)
      deal_parts(ranks, *order, *quiet);
    else
      perform_dealt_parts(ranks, *order);
  });
  sub.footer(
      "The tables are those of one process. For benchmarks that take --shard: detection, search, walls, ...\n"
      "A part keeps each draw when it has ended, so that little is lost with a process.\n"
      "Examples:\n"
      "  mpirun --bind-to core -n 8 stonestack-mpi bench --out parts -- detection --scenes 100 --seed 5\n"
      "  mpirun --bind-to core -n 8 stonestack-mpi bench --out parts --continue -- detection --scenes 100 "
      "--seed 5");
}

void set_up(CLI::App& app, const Ranks& ranks, bool& took_part) {
  app.name("stonestack-mpi");
  app.description(
      "stonestack-mpi: experiments and benchmarks on many processes and machines, started by mpirun.");
  add_experiment(app, ranks, took_part);
  add_bench(app, ranks, took_part);
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
                      " before its first task; there, the command without mpirun shows why"));
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
