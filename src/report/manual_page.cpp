#include <algorithm>
#include <cctype>
#include <sstream>

#include "report/text.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

/// "stonestack-config-show"
std::string page_name(const CommandDescription& command) {
  std::string name;
  for (const std::string& word : command.words) name += (name.empty() ? "" : "-") + word;
  return name;
}

/// Text of a line: what roff would take as a request, an escape or a hyphen is none.
std::string roff(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\\')
      safe += "\\e";
    else if (c == '-')
      safe += "\\-";
    else if (c == '\'')
      safe += "\\(aq";
    else if (c == '~')
      safe += "\\(ti";
    else if (c == '^')
      safe += "\\(ha";
    else if (c == '`')
      safe += "\\(ga";
    else
      safe += c;
  }
  return safe.starts_with('.') ? "\\&" + safe : safe;
}

std::string bold(const std::string& text) {
  return std::string("\\fB") + roff(text) + "\\fR";
}

std::string italic(const std::string& text) {
  return std::string("\\fI") + roff(text) + "\\fR";
}

std::string option_entry(const CommandOption& option) {
  std::string head;
  for (const std::string& name : option.names)
    head += (head.empty() ? "" : ", ") + (name.starts_with('-') ? bold(name) : italic(name));
  if (!option.value.empty() && option.names.front().starts_with('-'))
    head += std::string(" ") + italic(option.value);
  std::string choices;
  for (const std::string& choice : option.choices)
    choices += (choices.empty() ? " One of " : ", ") + bold(choice);
  return ".TP\n" + head + "\n" + roff(option.description) + (choices.empty() ? "" : "." + choices + ".") +
         "\n";
}

std::string options_section(const char* title, const std::vector<CommandOption>& options) {
  if (options.empty()) return "";
  std::string text = concat(".SH ", title, "\n");
  for (const CommandOption& option : options) text += option_entry(option);
  return text;
}

/// The footer: lines that stand further right are typed, the others are text.
std::string footer_section(const std::string& footer) {
  std::string text;
  std::istringstream lines(footer);
  bool typed = false, begun = false;  // a section begins a paragraph by itself
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line == "Example:" || line == "Examples:") continue;
    const bool now = line.starts_with("  ");
    if (now != typed) text += now ? std::string(begun ? ".PP\n" : "") + ".nf\n" : std::string(".fi\n.PP\n");
    text += roff(now ? line.substr(2) : line) + "\n";
    typed = now;
    begun = true;
  }
  if (typed) text += ".fi\n";
  return text.empty() ? "" : ".SH NOTES AND EXAMPLES\n" + text;
}

void write_manual_pages(const CommandDescription& command, const std::string& version,
                        const std::string& date, const std::string& folder) {
  write_file(concat(folder, "/man/man1/", page_name(command), ".1"), manual_page(command, version, date));
  for (const CommandDescription& below : command.commands) write_manual_pages(below, version, date, folder);
}

}  // namespace

std::string manual_page(const CommandDescription& command, const std::string& version,
                        const std::string& date) {
  const std::string name = page_name(command), &program = command.words.front();
  std::string upper = name, typed;
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  for (const std::string& word : command.words) typed += (typed.empty() ? "" : " ") + word;
  std::string text = concat(".TH ", upper, " 1 \"", date, "\" \"", roff(version), "\" \"", program, "\"\n");
  text += std::string(".SH NAME\n") + roff(name) + " \\- " + roff(command.description) + "\n";
  text += std::string(".SH SYNOPSIS\n") + bold(typed) + " [" + italic("OPTIONS") + "]";
  if (!command.commands.empty()) text += std::string(" ") + italic("COMMAND");
  for (const CommandOption& argument : command.arguments)
    text += std::string(" [") + italic(argument.names.front()) + "]";
  text += "\n";
  if (!command.commands.empty()) text += ".SH COMMANDS\n";
  for (const CommandDescription& below : command.commands)
    text += std::string(".TP\n") + bold(page_name(below)) + "(1)\n" + roff(below.description) + "\n";
  text += options_section("ARGUMENTS", command.arguments) + options_section("OPTIONS", command.options);
  text += footer_section(command.footer);
  text +=
      ".SH EXIT STATUS\n0 done, 2 usage, 3 unreadable input, 4 nothing detected, 5 no stable pose, 6 "
      "planning or "
      "execution failed, 7 safety stop, 130 interrupted.\n";
  text +=
      ".SH FILES AND ENVIRONMENT\nOptions come from flags, then the environment "
      "(STONESTACK_SEARCH_FRICTION=0.3), then "
      "./stonestack.yaml, then \\(ti/.config/stonestack/config.yaml. NO_COLOR turns colours off.\n";
  if (command.words.size() > 1) {
    CommandDescription above{{command.words.begin(), command.words.end() - 1}, "", "", {}, {}, {}};
    text += std::string(".SH SEE ALSO\n") + bold(page_name(above)) + "(1)" +
            (above.words.size() > 1 ? std::string(", ") + bold(program) + "(1)" : "") + "\n";
  }
  return text;
}

void write_command_pages(const CommandDescription& program, const std::string& version,
                         const std::string& date, const std::vector<std::string>& settings,
                         const std::string& folder) {
  const std::string& name = program.words.front();
  write_manual_pages(program, version, date, folder);
  write_file(folder + "/bash-completion/completions/" + name, completion_script(program, "bash", settings));
  write_file(folder + "/zsh/vendor-completions/_" + name, completion_script(program, "zsh", settings));
  write_file(folder + "/fish/vendor_completions.d/" + name + ".fish",
             completion_script(program, "fish", settings));
}

}  // namespace stonestack::report
