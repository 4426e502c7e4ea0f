#include "ranks.hpp"

#include <mpi.h>

namespace stonestack::mpi {

Ranks::Ranks(int& argc, char**& argv) {
  int threads = 0;  // others work beside the one that sends and receives
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &threads);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

Ranks::~Ranks() {
  MPI_Finalize();
}

std::string Ranks::host() const {
  char name[MPI_MAX_PROCESSOR_NAME + 1] = {};
  int length = 0;
  MPI_Get_processor_name(name, &length);
  return name;
}

void Ranks::send(int to, Word word, const std::string& text) const {
  MPI_Send(text.data(), static_cast<int>(text.size()), MPI_CHAR, to, static_cast<int>(word), MPI_COMM_WORLD);
}

std::optional<Message> Ranks::receive() const {
  int arrived = 0, length = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &arrived, &status);
  if (arrived == 0) return {};
  MPI_Get_count(&status, MPI_CHAR, &length);
  Message message{static_cast<Word>(status.MPI_TAG), status.MPI_SOURCE, {}};
  message.text.resize(static_cast<std::size_t>(length));
  MPI_Recv(message.text.data(), length, MPI_CHAR, status.MPI_SOURCE, status.MPI_TAG, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  return message;
}

}  // namespace stonestack::mpi
