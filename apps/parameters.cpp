// edge-mcl parameters: every parameter with its value, unit, range and meaning.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "apps/common_options.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/detector/detector_parameters.h"
#include "edge_mcl/viewer/drawing/view_parameters.h"

namespace edge_mcl {

namespace {

constexpr const char* kTableHead =
    "\n| name | default | unit | range | meaning |\n|---|---|---|---|---|\n";

std::string cell(std::string text) {
  for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\\|");
  return text;
}

std::string rowOf(const ParameterDescription& d) {
  return "| `" + d.name + "` | " + cell(d.value) + " | " + d.unit + " | " + cell(d.range) + " | " +
         cell(d.text) + " |\n";
}

/// The method's parameters, one table per group.
std::string methodTables(const Parameters& params) {
  std::string text, group;
  for (const ParameterDescription& d : describeParameters(params)) {
    const auto dot = d.name.find('.');
    if (d.name.substr(0, dot) != group) {
      group = d.name.substr(0, dot);
      text += "\n## " + group + "\n" + kTableHead;
    }
    text += rowOf(d);
  }
  return text;
}

template <class Struct>
std::string tableOf(const Struct& params) {
  std::string text = kTableHead;
  for (const ParameterDescription& d : describeParameters(params)) text += rowOf(d);
  return text;
}

std::string toMarkdown(const Parameters& params) {
  return "# Parameters\n\n"
         "`edge-mcl parameters --markdown` writes this page. A parameter has the same name "
         "everywhere:\n\n"
         "* in a YAML file (`--params FILE`): `group: {name: value}`\n"
         "* on the command line: `--set group.name=value`\n"
         "* as a ROS parameter: `~group/name`\n"
         "* in an ini file of MRPT: key `group.name` in the section `..._creationOpts` of the "
         "map\n\n"
         "An unknown name is an error.\n" +
         methodTables(params) +
         "\n## Viewer\n\nOptions `edge-mcl view --show name=value` and parameters `~name` of "
         "`edge_mcl_viewer`.\n" +
         tableOf(ViewParameters()) +
         "\n## Detector\n\nOptions `edge-mcl detect --set name=value` and parameters `~name` of "
         "`edge_mcl_detector`.\n" +
         tableOf(DetectorParameters());
}

}  // namespace

void addParameters(CLI::App* app, Action* action) {
  auto o = std::make_shared<ParameterOptions>();
  auto markdown = std::make_shared<bool>(false);
  CLI::App* c = app->add_subcommand("parameters",
                                    "print all parameters as a commented YAML file for --params");
  o->addTo(c);
  c->add_flag("--markdown", *markdown,
              "print tables instead, with the parameters of viewer and detector");
  c->callback([o, markdown, action] {
    *action = [o, markdown] {
      const Parameters params = o->load();
      std::printf("%s", (*markdown ? toMarkdown(params) : params.toYaml()).c_str());
      return static_cast<int>(kExitOk);
    };
  });
}

}  // namespace edge_mcl
