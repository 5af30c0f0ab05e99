// edge-mcl parameters: every parameter with its value, unit and meaning, as YAML or Markdown.
#include <cstdio>
#include <memory>
#include <string>

#include "apps/common_options.h"
#include "edge_mcl/core/base/parameter_text.h"
#include "edge_mcl/detector/detector_parameters.h"
#include "edge_mcl/viewer/drawing/view_parameters.h"

namespace edge_mcl {

namespace {

std::string cell(std::string text) {
  for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\\|");
  return text;
}

/// Of the localizer: group by group.
std::string methodTables(const Parameters& params) {
  std::string text, group;
  for (const Parameters::Description& d : params.describe()) {
    const auto dot = d.name.find('.');
    if (d.name.substr(0, dot) != group) {
      group = d.name.substr(0, dot);
      text += "\n## " + group + "\n\n| | default | unit | |\n|---|---|---|---|\n";
    }
    text +=
        "| `" + d.name + "` | " + cell(d.value) + " | " + d.unit + " | " + cell(d.text) + " |\n";
  }
  return text;
}

template <class Struct>
std::string nameTable(Struct params) {
  std::string text = "\n| | default |\n|---|---|\n";
  params.visit([&](const char* name, auto& value) {
    text += std::string("| `") + name + "` | " + cell(parameter_text::toText(value)) + " |\n";
  });
  return text;
}

std::string toMarkdown(const Parameters& params) {
  return "# Parameters\n\n"
         "Made by `edge-mcl parameters --markdown`. The same names hold in YAML (`--params FILE`), "
         "on the command\nline (`--set group.name=value`), as ROS parameters "
         "(`~group/name`), and in MRPT's ini files (section\n`..._creationOpts` of the map, key "
         "`group.name`). A name that is not known is "
         "an error.\n" +
         methodTables(params) +
         "\n## Viewer\n\n`edge-mcl view --show name=value`, `edge_mcl_viewer`'s `~name`; what they "
         "mean: `viewer.md`.\n" +
         nameTable(ViewParameters()) +
         "\n## Detector\n\n`edge-mcl detect --set name=value`, `edge_mcl_detector`'s `~name`; what "
         "they mean: `detector.md`.\n" +
         nameTable(DetectorParameters());
}

}  // namespace

void addParameters(CLI::App* app, Action* action) {
  auto o = std::make_shared<ParameterOptions>();
  auto markdown = std::make_shared<bool>(false);
  CLI::App* c = app->add_subcommand("parameters",
                                    "print all parameters as a commented YAML file for --params");
  o->addTo(c);
  c->add_flag("--markdown", *markdown, "as tables, with those of viewer and detector");
  c->callback([o, markdown, action] {
    *action = [o, markdown] {
      const Parameters params = o->load();
      std::printf("%s", (*markdown ? toMarkdown(params) : params.toYaml()).c_str());
      return static_cast<int>(kExitOk);
    };
  });
}

}  // namespace edge_mcl
