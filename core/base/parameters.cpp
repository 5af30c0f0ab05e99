#include "edge_mcl/core/base/parameters.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_text.h"
#include "edge_mcl/core/base/yaml_file.h"

namespace edge_mcl {

using parameter_text::fromText;
using parameter_text::toText;
using parameter_text::typeName;

namespace {

/// Calls f(group.name, reference, unit, text) for every parameter.
template <class F>
void forEach(Parameters& parameters, F&& f) {
  parameters.visitGroups([&](const char* group, auto& values) {
    values.visit([&](const char* name, auto& value, const char* unit, const char* text) {
      f(std::string(group) + "." + name, value, unit, text);
    });
  });
}

std::vector<std::string> allNames() {
  Parameters defaults;
  std::vector<std::string> names;
  forEach(defaults,
          [&](const std::string& name, auto&, const char*, const char*) { names.push_back(name); });
  return names;
}

}  // namespace

std::string nearestName(const std::string& name, const std::vector<std::string>& known) {
  std::string best;
  size_t best_distance = 1000;
  for (const std::string& candidate : known) {
    std::vector<size_t> row(candidate.size() + 1);
    for (size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= name.size(); ++i) {
      size_t diagonal = row[0];
      row[0] = i;
      for (size_t j = 1; j <= candidate.size(); ++j) {
        const size_t above = row[j];
        row[j] = std::min(
            {above + 1, row[j - 1] + 1, diagonal + (name[i - 1] == candidate[j - 1] ? 0u : 1u)});
        diagonal = above;
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

void Parameters::set(const std::string& dotted_name, const std::string& value) {
  bool found = false, good = true;
  const char* wanted = "";
  forEach(*this, [&](const std::string& name, auto& field, const char*, const char*) {
    if (name != dotted_name) return;
    found = true;
    auto parsed = field;
    good = fromText(value, &parsed);
    wanted = typeName(parsed);
    if (good) field = parsed;
  });
  if (!found)
    throw ParameterError("unknown parameter '" + dotted_name + "' (nearest: '" +
                         nearestName(dotted_name, allNames()) + "')");
  if (!good)
    throw ParameterError("parameter '" + dotted_name + "': '" + value + "' is not " + wanted);
}

std::string Parameters::get(const std::string& dotted_name) const {
  for (const Description& d : describe())
    if (d.name == dotted_name) return d.value;
  throw ParameterError("unknown parameter '" + dotted_name + "'");
}

std::vector<Parameters::Description> Parameters::describe() const {
  std::vector<Description> result;
  Parameters copy = *this;
  forEach(copy, [&](const std::string& name, auto& field, const char* unit, const char* text) {
    result.push_back({name, unit, text, toText(field)});
  });
  return result;
}

std::string Parameters::toYaml() const {
  std::string text, group;
  for (const Description& d : describe()) {
    const auto dot = d.name.find('.');
    if (d.name.substr(0, dot) != group) {
      group = d.name.substr(0, dot);
      text += group + ":\n";
    }
    text += "  " + d.name.substr(dot + 1) + ": " + d.value + "   # " +
            (d.unit.empty() ? "" : "[" + d.unit + "] ") + d.text + "\n";
  }
  return text;
}

void Parameters::loadYaml(const std::string& file) {
  const YAML::Node root = loadYamlFile(file);
  if (root.IsNull()) return;
  if (!root.IsMap()) throw ParameterError(file + ": groups of parameters expected");
  std::string faults;
  const auto attempt = [&](const std::string& name, const YAML::Node& value) {
    try {
      if (!value.IsScalar()) throw ParameterError("parameter '" + name + "' needs one value");
      set(name, value.Scalar());
    } catch (const ParameterError& e) {
      faults += std::string(faults.empty() ? "" : "; ") + e.what();
    }
  };
  for (const auto& group : root) {
    const auto group_name = group.first.as<std::string>();
    if (group.second.IsMap())
      for (const auto& entry : group.second)
        attempt(group_name + "." + entry.first.as<std::string>(), entry.second);
    else
      attempt(group_name, group.second);
  }
  if (!faults.empty()) throw ParameterError(file + ": " + faults);
  validate();
}

void Parameters::validate() const {
  std::string faults;
  const auto require = [&](bool good, const char* name, const char* rule) {
    if (good) return;
    faults +=
        std::string(faults.empty() ? "" : "; ") + name + " = " + get(name) + " must be " + rule;
  };
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  const auto not_negative = [](double v) { return std::isfinite(v) && v >= 0; };
  const auto share = [](double v) { return v >= 0 && v <= 1; };
  require(positive(map.scale), "map.scale", "positive");
  require(map.crease_angle_deg > 0 && map.crease_angle_deg < 180, "map.crease_angle_deg",
          "between 0 and 180");
  require(not_negative(map.weld_tolerance), "map.weld_tolerance", "zero or more");
  require(not_negative(map.sample_step), "map.sample_step", "zero or more");
  require(not_negative(map.min_line_length), "map.min_line_length", "zero or more");
  require(not_negative(visibility.cell_size), "visibility.cell_size", "zero or more");
  require(visibility.cache_cells >= 1, "visibility.cache_cells", "at least 1");
  require(not_negative(visibility.occlusion_tolerance), "visibility.occlusion_tolerance",
          "zero or more");
  require(image.blur_sigma >= 0 && image.blur_sigma < 20, "image.blur_sigma", "0 to 20");
  require(image.edge_share > 0 && image.edge_share < 1, "image.edge_share", "between 0 and 1");
  require(not_negative(image.noise_factor), "image.noise_factor", "zero or more");
  require(image.hysteresis > 0 && image.hysteresis <= 1, "image.hysteresis", "in (0, 1]");
  require(positive(image.min_segment_length), "image.min_segment_length", "positive");
  require(image.mask_dilation >= 0 && image.mask_dilation <= 100, "image.mask_dilation",
          "0 to 100");
  require(image.orientation_bins >= 4 && image.orientation_bins <= 64, "image.orientation_bins",
          "4 to 64");
  require(image.orientation_tolerance_deg > 0 && image.orientation_tolerance_deg <= 90,
          "image.orientation_tolerance_deg", "in (0, 90]");
  require(image.search_length >= 2 && image.search_length <= 200, "image.search_length",
          "2 to 200");
  require(image.clutter_window >= 16 && image.clutter_window <= 2000, "image.clutter_window",
          "16 to 2000");
  require(positive(likelihood.sigma), "likelihood.sigma", "positive");
  require(positive(likelihood.alpha), "likelihood.alpha", "positive");
  require(positive(likelihood.k), "likelihood.k", "positive");
  require(likelihood.missing_edge > 0 && likelihood.missing_edge < 1, "likelihood.missing_edge",
          "between 0 and 1");
  require(positive(likelihood.line_saturation), "likelihood.line_saturation", "positive");
  require(positive(likelihood.correlation_length), "likelihood.correlation_length", "positive");
  require(likelihood.line_correlation >= 0 && likelihood.line_correlation <= 1,
          "likelihood.line_correlation", "0 to 1");
  require(positive(likelihood.scale), "likelihood.scale", "positive");
  require(likelihood.max_samples >= 0, "likelihood.max_samples", "zero or more");
  require(not_negative(likelihood.border_fade), "likelihood.border_fade", "zero or more");
  require(positive(depth.truncation) && depth.truncation <= 5, "depth.truncation", "in (0, 5]");
  require(not_negative(depth.voxel_size), "depth.voxel_size", "zero or more");
  require(depth.points >= 10 && depth.points <= 1000000, "depth.points", "10 to 1000000");
  require(not_negative(depth.min_range), "depth.min_range", "zero or more");
  require(std::isfinite(depth.max_range) && depth.max_range > depth.min_range, "depth.max_range",
          "more than depth.min_range");
  require(positive(depth.sigma), "depth.sigma", "positive");
  require(not_negative(depth.sigma_per_square_metre), "depth.sigma_per_square_metre",
          "zero or more");
  require(not_negative(depth.bias_sigma), "depth.bias_sigma", "zero or more");
  require(depth.sigma >= 1e-4 * depth.truncation, "depth.sigma",
          "at least a ten-thousandth of depth.truncation");
  require(depth.clutter >= 1e-3 && depth.clutter < 1, "depth.clutter",
          "0.001 up to, not including, 1");
  require(positive(depth.independent_points), "depth.independent_points", "positive");
  require(refinement.iterations >= 1 && refinement.iterations <= 1000, "refinement.iterations",
          "1 to 1000");
  require(refinement.start_iterations >= 1 && refinement.start_iterations <= 1000,
          "refinement.start_iterations", "1 to 1000");
  require(refinement.start_samples >= 6, "refinement.start_samples", "at least 6");
  require(refinement.search_length >= 1 && refinement.search_length <= 200,
          "refinement.search_length", "1 to 200");
  require(refinement.final_search_length >= 1 &&
              refinement.final_search_length <= refinement.search_length,
          "refinement.final_search_length", "1 to refinement.search_length");
  require(positive(refinement.sigma), "refinement.sigma", "positive");
  require(refinement.max_samples >= 20, "refinement.max_samples", "at least 20");
  require(refinement.starts >= 1 && refinement.starts <= 1000, "refinement.starts", "1 to 1000");
  require(filter.particles >= 1 && filter.particles <= 10000000, "filter.particles",
          "1 to 10000000");
  require(not_negative(filter.odometry_noise_position), "filter.odometry_noise_position",
          "zero or more");
  require(not_negative(filter.odometry_noise_angle_deg), "filter.odometry_noise_angle_deg",
          "zero or more");
  require(not_negative(filter.odometry_noise_per_metre), "filter.odometry_noise_per_metre",
          "zero or more");
  require(not_negative(filter.odometry_noise_per_radian), "filter.odometry_noise_per_radian",
          "zero or more");
  require(positive(filter.walk_position_rate), "filter.walk_position_rate", "positive");
  require(positive(filter.walk_angle_rate_deg), "filter.walk_angle_rate_deg", "positive");
  require(not_negative(filter.walk_acceleration), "filter.walk_acceleration", "zero or more");
  require(not_negative(filter.walk_angular_acceleration_deg),
          "filter.walk_angular_acceleration_deg", "zero or more");
  require(share(filter.velocity_smoothing), "filter.velocity_smoothing", "0 to 1");
  require(share(filter.resample_threshold), "filter.resample_threshold", "0 to 1");
  require(filter.ess_floor > 0 && filter.ess_floor < 1, "filter.ess_floor", "between 0 and 1");
  // Weights that tempering leaves at the floor would never be resampled, nor any image be used.
  const bool always_resamples = refinement.enabled && filter.refined_share > 0;
  require(always_resamples || !(filter.resample_threshold <= filter.ess_floor),
          "filter.resample_threshold", "above filter.ess_floor, without refinement");
  require(filter.refined_share >= 0 && filter.refined_share < 1, "filter.refined_share",
          "0 up to, not including, 1");
  require(filter.tail_share >= 0 && filter.tail_share < 1, "filter.tail_share",
          "0 up to, not including, 1");
  require(filter.tail_scale >= 1 && filter.tail_scale <= 100, "filter.tail_scale", "1 to 100");
  require(filter.recovery_alpha_slow >= 0 && filter.recovery_alpha_slow <= 1,
          "filter.recovery_alpha_slow", "0 to 1");
  require(
      filter.recovery_alpha_fast >= filter.recovery_alpha_slow && filter.recovery_alpha_fast <= 1,
      "filter.recovery_alpha_fast", "from filter.recovery_alpha_slow to 1");
  require((filter.recovery_alpha_slow > 0) == (filter.recovery_alpha_fast > 0),
          "filter.recovery_alpha_slow", "zero when recovery_alpha_fast is, positive when it is");
  require(positive(filter.recovery_std_position), "filter.recovery_std_position", "positive");
  require(positive(filter.recovery_std_angle_deg), "filter.recovery_std_angle_deg", "positive");
  require(not_negative(tracking.update_min_d), "tracking.update_min_d", "zero or more");
  require(not_negative(tracking.update_min_a_deg), "tracking.update_min_a_deg", "zero or more");
  require(tracking.min_visible_samples >= 0, "tracking.min_visible_samples", "zero or more");
  require(tracking.min_edge_pixels >= 0, "tracking.min_edge_pixels", "zero or more");
  require(share(tracking.max_masked_share), "tracking.max_masked_share", "0 to 1");
  require(share(tracking.min_match_ratio), "tracking.min_match_ratio", "0 to 1");
  require(std::isfinite(tracking.min_evidence), "tracking.min_evidence", "a number");
  require(share(tracking.min_depth_agreement), "tracking.min_depth_agreement", "0 to 1");
  require(not_negative(tracking.lost_after), "tracking.lost_after", "zero or more");
  require(positive(tracking.converged_std_position), "tracking.converged_std_position", "positive");
  require(positive(tracking.converged_std_angle_deg), "tracking.converged_std_angle_deg",
          "positive");
  require(positive(tracking.max_gap), "tracking.max_gap", "positive");
  require(filter.max_passes >= 1 && filter.max_passes <= 100, "filter.max_passes", "1 to 100");
  require(not_negative(search.clearance), "search.clearance", "zero or more");
  require(share(search.enclosure), "search.enclosure", "0 to 1");
  require(positive(search.place_spacing), "search.place_spacing", "positive");
  require(search.max_places >= 1 && search.max_places <= 1000000, "search.max_places",
          "1 to 1000000");
  require(search.headings >= 1 && search.headings <= 10000, "search.headings", "1 to 10000");
  require(search.orientations >= 1 && search.orientations <= 100000, "search.orientations",
          "1 to 100000");
  require(positive(search.tilt_sigma_deg), "search.tilt_sigma_deg", "positive");
  require(search.small_width >= 80, "search.small_width", "at least 80");
  require(search.refined >= 1, "search.refined", "at least 1");
  require(search.hypotheses >= 2, "search.hypotheses", "at least 2");
  require(not_negative(search.keyframe_distance), "search.keyframe_distance", "zero or more");
  require(not_negative(search.keyframe_angle_deg), "search.keyframe_angle_deg", "zero or more");
  require(not_negative(search.keyframe_period), "search.keyframe_period", "zero or more");
  require(search.min_keyframes >= 1, "search.min_keyframes", "at least 1");
  require(search.window >= std::max(2, search.min_keyframes) && search.window <= 1000,
          "search.window", "2 or search.min_keyframes to 1000");
  require(share(search.line_correlation), "search.line_correlation", "0 to 1");
  require(not_negative(search.min_margin), "search.min_margin", "zero or more");
  require(std::isfinite(search.min_evidence), "search.min_evidence", "a number");
  require(share(search.min_match_ratio), "search.min_match_ratio", "0 to 1");
  if (!faults.empty()) throw ParameterError("parameters: " + faults);
}

}  // namespace edge_mcl
