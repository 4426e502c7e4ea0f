#include "deal_runs.hpp"

#include "deal.hpp"

namespace stonestack::mpi {
namespace {

Perform run_of(const ExperimentOrder& order, const Catalogue& catalogue) {
  return [order, &catalogue](const std::string& folder, int number) {
    return perform_experiment_run(order, catalogue, folder, number);
  };
}

}  // namespace

RecordedExperiment deal_runs(const Ranks& ranks, ExperimentOrder order, const Catalogue& catalogue,
                             const std::function<void(const std::string& lines)>& listener) {
  Dealer dealer(ranks);
  const Perform perform = run_of(order, catalogue);
  order.perform_elsewhere = [&](const std::string& folder, const std::vector<int>& numbers,
                                const TakeRuns& take) {
    dealer.deal(folder, numbers, perform,
                [&](const std::vector<std::string>& runs) { listener(take(runs)); });
  };
  return record_experiment(order, catalogue);
}

void perform_dealt_runs(const Ranks& ranks, const ExperimentOrder& order, const Catalogue& catalogue) {
  perform_dealt(ranks, run_of(order, catalogue));
}

}  // namespace stonestack::mpi
