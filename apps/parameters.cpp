// edge-mcl parameters: every parameter with its value, unit and meaning, as YAML.
#include <cstdio>
#include <memory>

#include "common_options.h"

namespace edge_mcl {

void addParameters(CLI::App* app, Action* action) {
  auto o = std::make_shared<ParameterOptions>();
  CLI::App* c = app->add_subcommand("parameters",
                                    "print all parameters as a commented YAML file for --params");
  o->addTo(c);
  c->callback([o, action] {
    *action = [o] {
      std::printf("%s", o->load().toYaml().c_str());
      return static_cast<int>(kExitOk);
    };
  });
}

}  // namespace edge_mcl
