#include <algorithm>

#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

using Strings = std::vector<std::string>;

std::string joined(const Strings& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (&word == &words.front() ? "" : separator) + word;
  return text;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// "/config/show"; the program itself is "".
std::string path_of(const CommandDescription& command) {
  std::string path;
  for (std::size_t i = 1; i < command.words.size(); ++i) path += "/" + command.words[i];
  return path;
}

/// The command and all below it.
void flatten(const CommandDescription& command, std::vector<const CommandDescription*>& list) {
  list.push_back(&command);
  for (const CommandDescription& below : command.commands) flatten(below, list);
}

Strings names_of(const std::vector<CommandDescription>& commands) {
  Strings names;
  for (const CommandDescription& command : commands) names.push_back(command.words.back());
  return names;
}

Strings with_equals(Strings names) {
  for (std::string& name : names) name += "=";
  return names;
}

bool is_setting(const CommandOption& option) {
  return option.value.starts_with("NAME=VALUE");
}

// bash

std::string bash_values(const CommandOption& option) {
  if (is_setting(option))
    return "compopt -o nospace 2>/dev/null; COMPREPLY=($(compgen -W \"$settings\" -- \"$cur\")); return";
  if (!option.choices.empty())
    return std::string("COMPREPLY=($(compgen -W '") + joined(option.choices, " ") + "' -- \"$cur\")); return";
  if (option.value == "DIR")
    return "compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -d -- \"$cur\")); return";
  return "return";  // file names, by -o default
}

std::string bash_script(const CommandDescription& program, const Strings& settings) {
  std::vector<const CommandDescription*> all;
  flatten(program, all);
  const std::string& name = program.words.front();
  Strings paths, values, offers;
  for (const CommandDescription* command : all) {
    const std::string path = path_of(*command);
    if (!path.empty()) paths.push_back(path);
    Strings options, subcommands = names_of(command->commands);
    for (const CommandOption& option : command->options) {
      options.insert(options.end(), option.names.begin(), option.names.end());
      if (option.value.empty()) continue;
      Strings patterns;
      for (const std::string& flag : option.names) patterns.push_back("'" + path + " " + flag + "'");
      values.push_back(std::string("    ") + joined(patterns, " | ") + ") " + bash_values(option) + " ;;\n");
    }
    if (path.empty()) subcommands.push_back("help");
    bool files = false;
    for (const CommandOption& argument : command->arguments) {
      subcommands.insert(subcommands.end(), argument.choices.begin(), argument.choices.end());
      files = files || argument.choices.empty();
    }
    offers.push_back("    '" + path + "') options='" + joined(options, " ") + "' words='" +
                     joined(subcommands, " ") + "' files=" + (files ? "1" : "") + " ;;\n");
  }
  return "# Completion of " + name + " in bash, written by `" + name + " completion bash`.\n_" + name +
         R"(() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} path= options= words= files= i
  local settings=')" +
         joined(with_equals(settings), " ") +
         R"('
  COMPREPLY=()
  if [[ $cur == = ]]; then cur=; elif [[ $prev == = ]]; then prev=${COMP_WORDS[COMP_CWORD-2]}; fi
  for ((i = 1; i < COMP_CWORD; i++)); do
    case $path/${COMP_WORDS[i]} in
      )" +
         joined(paths, " | ") +
         R"() path+=/${COMP_WORDS[i]} ;;
    esac
  done
  case "$path $prev" in
)" + joined(values, "") +
         "  esac\n  case $path in\n" + joined(offers, "") +
         R"(  esac
  if [[ $cur == -* || -z $words$files ]]; then words=$options; fi
  COMPREPLY=($(compgen -W "$words" -- "$cur"))
}
complete -o default -F _)" +
         name + " " + name + "\n";
}

// zsh

/// Text within single quotes and brackets.
std::string zsh_text(const std::string& text) {
  return replaced(replaced(replaced(replaced(text, "[", "("), "]", ")"), ":", "\\:"), "'", "'\\''");
}

std::string zsh_action(const CommandOption& option) {
  if (!option.choices.empty()) return std::string("(") + joined(option.choices, " ") + ")";
  return option.value == "DIR" ? "_files -/" : "_files";
}

std::string zsh_values(const CommandOption& option, const std::string& program) {
  const std::string label = std::string(":") + replaced(option.names.back(), "--", "") + ":";
  if (is_setting(option)) return label + "{compadd -S = -a _" + program + "_settings}";
  return label + zsh_action(option);
}

std::string zsh_option(const CommandOption& option, const std::string& program) {
  Strings specs;
  for (const std::string& name : option.names)
    specs.push_back(name + (option.value.empty() ? "" : name.starts_with("--") ? "=" : "+"));
  const std::string once = is_setting(option) ? "*" : std::string("(") + joined(option.names, " ") + ")";
  const std::string tail = concat("[", zsh_text(option.description), "]",
                                  option.value.empty() ? "" : zsh_values(option, program), "'");
  std::string text;
  for (const std::string& spec : specs) text += " \\\n    '" + once + spec + tail;
  return text;
}

std::string zsh_function(const CommandDescription& command) {
  std::string options;
  for (const CommandOption& option : command.options) options += zsh_option(option, command.words.front());
  std::string text = std::string("_") + joined(command.words, "_") + "() {\n";
  if (command.commands.empty()) {
    for (const CommandOption& argument : command.arguments)
      options += " \\\n    '*:" + argument.names.front() + ":" + zsh_action(argument) + "'";
    return text + "  _arguments -s" + options + "\n}\n";
  }
  text +=
      "  local curcontext=\"$curcontext\" context state state_descr line\n  typeset -A opt_args\n  "
      "_arguments -C" +
      options + " \\\n    '1:command:->command' \\\n    '*::argument:->argument' && return\n" +
      "  case $state in\n    command)\n      local -a commands\n      commands=(\n";
  std::string cases;
  for (const CommandDescription& below : command.commands) {
    text += "        '" + below.words.back() + ":" + zsh_text(below.description) + "'\n";
    cases += "        " + below.words.back() + ") _" + joined(below.words, "_") + " ;;\n";
  }
  return text + "      )\n      _describe command commands ;;\n    argument)\n      case $words[1] in\n" +
         cases + "      esac ;;\n  esac\n}\n";
}

std::string zsh_script(const CommandDescription& program, const Strings& settings) {
  const std::string& name = program.words.front();
  std::vector<const CommandDescription*> all;
  flatten(program, all);
  std::string text = "#compdef " + name + "\n# Completion of " + name + " in zsh, written by `" + name +
                     " completion zsh`.\ntypeset -ga _" + name + "_settings=(" + joined(settings, " ") +
                     ")\n";
  for (const CommandDescription* command : all) text += zsh_function(*command);
  return text + "if [ \"$funcstack[1]\" = _" + name + " ]; then\n  _" + name + " \"$@\"\nelse\n  compdef _" +
         name + " " + name + "\nfi\n";
}

// fish

std::string fish_text(const std::string& text) {
  return concat('\'', replaced(replaced(text, "\\", "\\\\"), "'", "\\'"), '\'');
}

std::string fish_option(const CommandOption& option, const std::string& program) {
  std::string text;
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (is_setting(option))
    text += " -x -a '$__" + program + "_settings'";
  else if (!option.choices.empty())
    text += std::string(" -x -a ") + fish_text(joined(option.choices, " "));
  else if (!option.value.empty())
    text += " -r -F";
  return text + " -d " + fish_text(option.description);
}

std::string fish_script(const CommandDescription& program, const Strings& settings) {
  const std::string& name = program.words.front();
  std::vector<const CommandDescription*> all;
  flatten(program, all);
  const std::string begin = "complete -c " + name;
  std::string text = "# Completion of " + name + " in fish, written by `" + name +
                     " completion fish`.\nset -g __" + name + "_settings " +
                     joined(with_equals(settings), " ") + "\n" + begin + " -f\n";
  for (const CommandDescription* command : all) {
    std::string here;  // condition: the words up to this command were typed, and none below it
    for (std::size_t i = 1; i < command->words.size(); ++i)
      here += (i == 1 ? "" : "; and ") + ("__fish_seen_subcommand_from " + command->words[i]);
    std::string open = here;
    if (!command->commands.empty())
      open = here.empty()
                 ? "__fish_use_subcommand"
                 : here + "; and not __fish_seen_subcommand_from " + joined(names_of(command->commands), " ");
    for (const CommandDescription& below : command->commands)
      text += begin + " -n " + fish_text(open) + " -a " + below.words.back() + " -d " +
              fish_text(below.description) + "\n";
    for (const CommandOption& option : command->options)
      text += begin + " -n " + fish_text(open) + fish_option(option, name) + "\n";
    for (const CommandOption& argument : command->arguments)
      text += begin + " -n " + fish_text(open) +
              (argument.choices.empty() ? " -F"
                                        : std::string(" -a ") + fish_text(joined(argument.choices, " "))) +
              "\n";
  }
  return text;
}

}  // namespace

std::string completion_script(const CommandDescription& program, const std::string& shell,
                              const std::vector<std::string>& settings) {
  if (shell == "bash") return bash_script(program, settings);
  if (shell == "zsh") return zsh_script(program, settings);
  require(shell == "fish", "no completion for the shell '", shell, "'; there are bash, zsh and fish");
  return fish_script(program, settings);
}

}  // namespace stonestack::report
