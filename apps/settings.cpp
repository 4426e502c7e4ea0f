#include "settings.hpp"

namespace stonestack::apps {

void Settings::register_on(CLI::App& command) {
  command
      .add_option("--set", sources_.assignments,
                  "Set an option of this command by its name, e.g. --set GROUP.NAME=VALUE (repeatable); see "
                  "config show")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  command.add_option("--config", sources_.config, "Option file in place of ./stonestack.yaml")
      ->type_name("FILE");
}

void Settings::apply(const FieldList& list) {
  sources_.flags.clear();
  for (const auto& [flag, option] : bound_)
    if (flag->count() > 0) sources_.flags.push_back({flag->get_name(), option, flag->results().back()});
  origins_ = apply_options(list, sources_);
}

}  // namespace stonestack::apps
