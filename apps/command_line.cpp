#include "command_line.hpp"

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "stonestack/core/error.hpp"
#include "stonestack/core/options.hpp"

namespace stonestack::apps {
namespace {

using Words = std::vector<std::string>;

std::string listed(const Words& words, const char* separator) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

/// "; did you mean a or b?", or nothing.
std::string question(const Words& known, const std::string& given) {
  const Words meant = likely_meant(known, given);
  return meant.empty() ? "" : concat("; did you mean ", listed(meant, " or "), "?");
}

/// Commands that the help lists.
Words commands_of(const CLI::App& app) {
  Words names;
  for (const auto* command : app.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); }))
    names.push_back(command->get_name());
  return names;
}

Words options_of(const CLI::App& app) {
  Words names;
  for (const auto* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
    for (const auto& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

/// "stonestack config show"
std::string full_name(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name()
                                     : concat(full_name(*app.get_parent()), ' ', app.get_name());
}

/// The innermost command that was given.
const CLI::App& chosen(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  return *at;
}

bool is_option(const std::string& word) {
  return word.size() > 1 && word.front() == '-';
}

/// A word that stands where a subcommand belongs; CLI11 would only report that one is missing.
void check_commands(const CLI::App& app, const Words& words) {
  const CLI::App* at = &app;
  for (const auto& word : words) {
    const Words known = commands_of(*at);
    if (known.empty() || is_option(word)) return;
    require(!at->get_subcommands([&](const CLI::App* c) { return c->get_name() == word; }).empty(),
            "unknown command '", word, "'", at == &app ? "" : " of " + full_name(*at), question(known, word),
            "; commands: ", listed(known, ", "));
    at = at->get_subcommand(word);
  }
}

/// An option that the subcommand does not have, or a word that it has no use for.
void check_left_over(const CLI::App& app) {
  const CLI::App& command = chosen(app);
  const Words left = command.remaining();
  if (left.empty()) return;
  const auto option = std::find_if(left.begin(), left.end(), is_option);
  const std::string& word = option == left.end() ? left.front() : *option;
  const std::string given = word.substr(0, word.find('='));
  const std::string name = full_name(command);
  const std::string help = concat("; `", name, " --help` lists what it takes");
  require(option != left.end(), name, " has no use for '", word, "'", help);
  throw InvalidArgument(
      concat(name, " has no option '", given, "'", question(options_of(command), given), help));
}

/// `help config show` is `config show --help`.
Words words_of(int argc, const char* const* argv) {
  Words words(argv + std::min(argc, 1), argv + argc);
  if (words.empty() || words.front() != "help") return words;
  words.erase(words.begin());
  words.emplace_back("--help");
  return words;
}

}  // namespace

int run_command_line(CLI::App& app, int argc, const char* const* argv) {
  const Words words = words_of(argc, argv);
  check_commands(app, words);
  Words reversed(words.rbegin(), words.rend());  // CLI11 takes them from the back
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& problem) {
    // CallForHelp, too, is a ParseError. An option that does not exist may be why another is missing.
    if (problem.get_exit_code() == 0) return app.exit(problem, std::cout, std::cerr);
    check_left_over(app);
    const std::string name = full_name(chosen(app));
    throw InvalidArgument(concat(name, ": ", problem.what(), "; `", name, " --help` lists what it takes"));
  }
  return 0;
}

}  // namespace stonestack::apps
