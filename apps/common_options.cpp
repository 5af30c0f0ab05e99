#include "apps/common_options.h"

#include <CLI/CLI.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_text.h"

namespace edge_mcl {

void ParameterOptions::addTo(CLI::App* command) {
  command->add_option(
      "--params", file_,
      "YAML file with parameters, as `edge-mcl parameters` prints it; default: no file, and "
      "every parameter has its default value");
  command->add_option(
      "--set", assignments_,
      "sets one parameter, e.g. --set likelihood.sigma=2; can be given several times; "
      "overrides --params");
  command->add_option("--particles", particles_, "number of particles; sets filter.particles");
  command->add_option("--likelihood", likelihood_,
                      "likelihood model, paper or robust; sets likelihood.model");
  command->add_option(
      "--backend", backend_,
      "device that computes the likelihood, auto, cpu or cuda; sets likelihood.backend");
  command->add_option("--seed", seed_, "seed of the random generator; sets filter.seed");
}

void ParameterOptions::set(const std::string& name, double value) {
  assignments_.push_back(name + "=" + parameter_text::toText(value));
}

Parameters ParameterOptions::load() const {
  Parameters params;
  if (!file_.empty()) params.loadYaml(file_);
  std::string faults;
  const auto set = [&](const std::string& name, const std::string& value) {
    try {
      params.set(name, value);
    } catch (const ParameterError& e) {
      faults += std::string(faults.empty() ? "" : "; ") + e.what();
    }
  };
  for (const std::string& assignment : assignments_) {
    const auto equals = assignment.find('=');
    if (equals == std::string::npos)
      faults += (faults.empty() ? "" : "; ") +
                ("--set " + assignment + ": must have the form name=value");
    else
      set(assignment.substr(0, equals), assignment.substr(equals + 1));
  }
  if (!particles_.empty()) set("filter.particles", particles_);
  if (!likelihood_.empty()) set("likelihood.model", likelihood_);
  if (!backend_.empty()) set("likelihood.backend", backend_);
  if (!seed_.empty()) set("filter.seed", seed_);
  if (!faults.empty()) throw ParameterError(faults);
  params.validate();
  return params;
}

}  // namespace edge_mcl
