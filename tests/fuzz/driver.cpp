// fuzz_NAME CORPUS_FOLDER ITERATIONS SEED: what libFuzzer does, without its eyes: every file of the corpus as
// it is, then seeded mutations of them. An input that crashes, aborts or takes over five seconds is written
// to crash-input in the working folder; "fuzz_NAME FILE" runs one input.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using stonestack::core::Random;

constexpr std::size_t kMaxSeed = 1 << 20, kLongestInput = 1 << 14;
constexpr unsigned kSlowest = 5;  // s for one input
constexpr int kMaxMutations = 6;

const std::string* current = nullptr;

void keep_input(int signal) {
  const int file = open("crash-input", O_WRONLY | O_CREAT | O_TRUNC, 0640);
  if (file >= 0 && current != nullptr && write(file, current->data(), current->size()) < 0) _exit(2);
  std::signal(signal == SIGALRM ? SIGABRT : signal, SIG_DFL);
  raise(signal == SIGALRM ? SIGABRT : signal);
}

void run(const std::string& input) {
  current = &input;
  alarm(kSlowest);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  alarm(0);
}

std::string piece_of(const std::string& text, Random& random) {
  if (text.empty()) return {};
  const std::size_t begin = random.index(text.size());
  return text.substr(begin, 1 + random.index(text.size() - begin));
}

void mutate_once(std::string& input, const std::vector<std::string>& corpus, Random& random) {
  constexpr char kEdges[] = {'\0', '\x01', '\x02', '\x7F', '\x80', '\xFF', '\n', ',', '(', '.'};
  const std::size_t at = input.empty() ? 0 : random.index(input.size());
  switch (input.empty() ? 3 : random.index(7)) {
    case 0:
      input[at] = static_cast<char>(input[at] ^ (1 << random.index(8)));
      break;
    case 1:
      input[at] = kEdges[random.index(std::size(kEdges))];
      break;
    case 2:
      input[at] = static_cast<char>(random.bits());
      break;
    case 3:
      input.insert(at, piece_of(corpus[random.index(corpus.size())], random));
      break;
    case 4:
      input.erase(at, 1 + random.index(input.size() - at));
      break;
    case 5:
      input.insert(at, std::string(1 + random.index(8), static_cast<char>(random.bits())));
      break;
    default:
      input.resize(at);
  }
}

std::vector<std::string> read_corpus(const std::string& folder) {
  std::vector<std::string> paths, corpus;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  corpus.reserve(paths.size());
  for (const auto& path : paths) corpus.push_back(stonestack::core::read_file(path, kMaxSeed));
  return corpus;
}

}  // namespace

int main(int argc, char** argv) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGALRM})
    std::signal(signal, keep_input);
  if (argc == 2) {
    run(stonestack::core::read_file(argv[1], kMaxSeed));
    return 0;
  }
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s CORPUS_FOLDER ITERATIONS SEED | FILE\n", argv[0]);
    return 2;
  }
  const auto corpus = read_corpus(argv[1]);
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no seeds in %s\n", argv[0], argv[1]);
    return 2;
  }
  const long iterations = std::stol(argv[2]);
  const std::uint64_t seed = std::stoull(argv[3]);
  for (const auto& input : corpus) run(input);
  for (long i = 0; i < iterations; ++i) {
    Random random = Random::stream(seed, static_cast<std::uint64_t>(i));
    std::string input = corpus[random.index(corpus.size())];
    for (auto n = 1 + random.index(kMaxMutations); n > 0; --n) mutate_once(input, corpus, random);
    input.resize(std::min(input.size(), kLongestInput));
    run(input);
  }
  std::printf("%zu seeds and %ld mutations survived\n", corpus.size(), iterations);
}
