#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/report/results.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

/// Kind of value, range and choices from CLI11's "INT:INT in [1 - 100]" and "TEXT:{default,paper}".
CommandOption describe_option(const CLI::Option& option) {
  CommandOption described;
  for (const auto& name : option.get_snames()) described.names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) described.names.push_back("--" + name);
  if (described.names.empty()) described.names.push_back(option.get_name(true));
  described.description = option.get_description();
  if (option.get_items_expected_max() == 0) return described;
  const std::string type = option.get_type_name();
  const std::size_t colon = type.find(':');
  described.value = type.substr(0, colon);
  const std::string check = colon == std::string::npos ? "" : type.substr(colon + 1);
  if (check.starts_with('{') && check.ends_with('}'))
    described.choices = CLI::detail::split(check.substr(1, check.size() - 2), ',');
  else if (const auto range = check.find('['); range != std::string::npos)
    described.description += " " + check.substr(range);
  if (!option.get_default_str().empty())
    described.description += " (default: " + option.get_default_str() + ")";
  return described;
}

CommandDescription describe(const CLI::App& app, std::vector<std::string> words) {
  words.push_back(app.get_name());
  CommandDescription command{words, app.get_description(), app.get_footer(), {}, {}, {}};
  for (const CLI::Option* option : app.get_options())
    (option->nonpositional() ? command.options : command.arguments).push_back(describe_option(*option));
  for (const CLI::App* below : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!below->get_group().empty()) command.commands.push_back(describe(*below, words));
  return command;
}

std::vector<std::string> setting_names() {
  EveryOption every;
  std::vector<std::string> names;
  for (const Field& field : fields(every)) names.push_back(field.name);
  return names;
}

}  // namespace

void add_completion(CLI::App& app) {
  struct Command {
    const CLI::App* program = nullptr;
    std::string shell, folder, date;
  };
  const auto [sub, command] = add_subcommand<Command>(
      app, "completion", "Print the completion script of a shell", +[](Command& c) {
        std::cout << completion_script(describe(*c.program, {}), c.shell, setting_names());
      });
  sub.add_option("SHELL", command.shell, "Shell that shall complete commands")
      ->check(CLI::IsMember({"bash", "zsh", "fish"}))
      ->required();
  sub.footer(
      "The Debian package installs the scripts. Otherwise:\n"
      "Examples:\n"
      "  source <(stonestack completion bash)\n"
      "  stonestack completion zsh > /usr/local/share/zsh/site-functions/_stonestack\n"
      "  stonestack completion fish > ~/.config/fish/completions/stonestack.fish");
  const auto [pages, target] = add_subcommand<Command>(
      app, "pages", "Write manual pages and completion scripts; the build calls it", +[](Command& c) {
        write_command_pages(describe(*c.program, {}), std::string("stonestack ") + program_version(), c.date,
                            setting_names(), c.folder);
      });
  pages.add_option("FOLDER", target.folder, "Folder to write to")->required();
  pages.add_option("DATE", target.date, "Date of the pages, 2025-01-01")->required();
  pages.group("");
  command.program = target.program = &app;
}

}  // namespace stonestack::apps
