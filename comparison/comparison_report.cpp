#include "edge_mcl/comparison/comparison_report.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "edge_mcl/comparison/compared_methods.h"

namespace edge_mcl {

namespace {

template <class... Arguments>
std::string format(const char* pattern, Arguments... arguments) {
  char text[512];
  std::snprintf(text, sizeof text, pattern, arguments...);
  return text;
}

std::vector<std::string> sequencesOf(const std::vector<ComparedRow>& rows) {
  std::vector<std::string> names;
  for (const ComparedRow& r : rows)
    if (std::find(names.begin(), names.end(), r.sequence) == names.end())
      names.push_back(r.sequence);
  return names;
}

std::string tableOf(const std::vector<ComparedRow>& rows, const std::string& sequence) {
  std::string text =
      "| | particles | position, cm: median / p90 | in the plane, cm | rotation, deg | "
      "within 10 cm and 3 deg | lost runs | ms per update | MB |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  for (const ComparedRow& r : rows) {
    if (r.sequence != sequence) continue;
    text += "| " + r.title + (r.method == "mrpt_2d" ? " (1)" : "") + " | ";
    text += r.particles > 0 ? format("%d", r.particles) : std::string("-");
    if (r.failed == r.runs) {
      text += " | failed | | | | | | |\n";
      continue;
    }
    text += format(" | %.1f / %.1f | %.1f | %.2f | %.1f %% | %zu of %zu | %.1f | %.0f |\n",
                   100 * r.position, 100 * r.position_p90, 100 * r.plane, r.rotation,
                   100 * r.success, r.lost, r.runs, r.update_ms, r.peak_mb);
  }
  return text;
}

/// Compares the best method of edge_mcl with the best filter of MRPT by the figures, whichever
/// wins.
std::string verdictOf(const std::vector<ComparedRow>& rows, const std::string& sequence) {
  const ComparedRow *own = nullptr, *builtin = nullptr;
  for (const ComparedRow& r : rows) {
    if (r.sequence != sequence || r.failed == r.runs) continue;
    const ComparedMethod& method = comparedMethod(r.method);
    if (method.kind != MethodKind::kOwn && !r.builtin) continue;
    const ComparedRow*& best = r.builtin ? builtin : own;
    // The error in the plane decides, because MRPT's 2D filter estimates nothing else.
    if (!best || r.plane < best->plane) best = &r;
  }
  if (!own || !builtin) return "";
  const bool wins = builtin->plane < own->plane;
  const double ratio = wins ? own->plane / builtin->plane : builtin->plane / own->plane;
  std::string text = format(
      "In the plane, \"%s\" has the smallest error (%.1f cm, %zu of %zu runs lost). The best "
      "filter of the other project is \"%s\" (%.1f cm, %zu of %zu runs lost). The factor between "
      "the errors is %.1f.",
      (wins ? builtin : own)->title.c_str(), 100 * (wins ? builtin : own)->plane,
      (wins ? builtin : own)->lost, (wins ? builtin : own)->runs,
      (wins ? own : builtin)->title.c_str(), 100 * (wins ? own : builtin)->plane,
      (wins ? own : builtin)->lost, (wins ? own : builtin)->runs, ratio);
  if (wins) text += " **MRPT's filter wins here.**";
  return text + "\n";
}

std::string paperTable(const nlohmann::json& bench) {
  std::string text =
      "Table 1 of the paper gives the time per update in ms for four experiments. The paper\n"
      "gives neither the number of particles nor the hardware.\n\n"
      "| experiment | 1 | 2 | 3 | 4 |\n|---|---|---|---|---|\n"
      "| CPU | 123.6 | 102.83 | 150.12 | 131.84 |\n| CPU and GPU | 7.39 | 6.54 | 8.44 | 7.45 |\n"
      "| ratio | 16.7 | 15.7 | 17.7 | 17.6 |\n\n";
  if (bench.is_null())
    return text + "Without the option `--bench`, the times of edge_mcl are not measured.\n";
  text +=
      "The next table gives the time of the likelihood alone, on one thread and without a GPU.\n"
      "The plain flow is the paper's figure 2, written plainly. edge_mcl uses its CPU backend.\n"
      "The sequence is " +
      bench.at("sequence").get<std::string>() +
      ".\n\n"
      "| particles | plain flow, ms | edge_mcl, one core, ms | ratio |\n|---|---|---|---|\n";
  for (const auto& line : bench.at("table"))
    text += format("| %d | %.1f | %.2f | %.0f |\n", line.at("particles").get<int>(),
                   line.at("plain_ms").get<double>(), line.at("cpu_ms").get<double>(),
                   line.at("plain_ms").get<double>() / line.at("cpu_ms").get<double>());
  return text;
}

}  // namespace

std::vector<ComparedRow> rowsOf(const std::vector<ComparedRun>& runs) {
  std::vector<std::string> sequences;
  std::map<std::tuple<std::string, std::string, int>, std::vector<const ComparedRun*>> groups;
  for (const ComparedRun& run : runs) {
    if (std::find(sequences.begin(), sequences.end(), run.sequence) == sequences.end())
      sequences.push_back(run.sequence);
    groups[{run.sequence, run.method, run.particles}].push_back(&run);
  }
  std::vector<ComparedRow> rows;
  for (const std::string& sequence : sequences) {
    for (const ComparedMethod& method : comparedMethods()) {
      for (const auto& [key, members] : groups) {
        if (std::get<0>(key) != sequence || std::get<1>(key) != method.name) continue;
        ComparedRow row;
        row.method = method.name;
        row.title = method.title;
        row.sequence = sequence;
        row.particles = std::get<2>(key);
        row.builtin = method.isBuiltin();
        for (const ComparedRun* run : members) {
          ++row.runs;
          row.lost += run->lost ? 1 : 0;
          row.peak_mb = std::max(row.peak_mb, run->peak_mb);
          if (!run->failure.empty()) {
            ++row.failed;
            continue;
          }
          row.position += run->position.median;
          row.position_p90 += run->position.p90;
          row.plane += run->plane.median;
          row.rotation += run->rotation.median;
          row.success += run->success;
          row.update_ms += run->update_ms.median;
        }
        const auto good = static_cast<double>(std::max<size_t>(1, row.runs - row.failed));
        for (double* value : {&row.position, &row.position_p90, &row.plane, &row.rotation,
                              &row.success, &row.update_ms})
          *value /= good;
        rows.push_back(row);
      }
    }
  }
  return rows;
}

std::string toMarkdown(const Comparison& c) {
  const std::vector<ComparedRow> count = rowsOf(c.equal_count), time = rowsOf(c.equal_time);
  size_t seeds = 0;
  for (const ComparedRow& r : count) seeds = std::max(seeds, r.runs);
  std::string text =
      "# Comparison with MRPT's own filters\n\nThis command makes the page:\n\n    " + c.command +
      "\n\n";
  text += format("It ran on one core of: %s. Every method ran with %zu seeds.\n", c.machine.c_str(),
                 seeds);
  text +=
      "All filters get the same start pose (with the standard deviations that the sequence\n"
      "gives), the same odometry, the same model of the odometry noise, and the same images,\n"
      "masks and depth images. Every run is a process of its own and is bound to one core.\n"
      "Finished runs are kept, so a stopped command continues where it stopped.\n\n"
      "* **edge_mcl**: the complete localizer with refinement and recovery. It uses edges,\n"
      "  depth or both. \"The paper's likelihood\" means `likelihood.model = paper`. \"Without\n"
      "  masks\" means that it does not use the masks of the sequence.\n"
      "* **MRPT's 3D filter on edge_mcl's map**: `CMonteCarloLocalization3D` with `CEdgeMap`.\n"
      "  The likelihood has its full power (`powFactor = 1`), and all parameters of edge_mcl\n"
      "  have their defaults. This row shows edge_mcl's likelihood without edge_mcl's filter.\n"
      "  The example `docs/examples/pf_localization.ini` uses other values: `powFactor = 0.4`\n"
      "  and `likelihood.sigma = 3`.\n"
      "* **MRPT's 3D filter on a point map**: `CMonteCarloLocalization3D` with a\n"
      "  `CSimplePointsMap` of the model's surfaces (points 5 cm apart). Every depth image\n"
      "  gives the same 500 points as for edge_mcl's depth cue.\n"
      "* **MRPT's 2D filter on a grid**: `CMonteCarloLocalization2D` with a\n"
      "  `COccupancyGridMap2D` (cells of 1 cm). The grid is the section of the model at the\n"
      "  height of the start pose. The scan is made from the points of the depth image near\n"
      "  this height. (1) The filter estimates x, y and heading. It gets height, roll and pitch\n"
      "  from the ground truth.\n"
      "* **dead reckoning**: the start pose, moved by the odometry alone.\n\n"
      "MRPT's likelihoods have settings that depend on the sensor. The comparison uses the best\n"
      "values of a trial on the office flight. MRPT's defaults were worse in this trial.\n\n"
      "* Point map: sigma 5 mm was the best of 2 to 50 mm. Points 2 cm and 5 cm apart were\n"
      "  equally good.\n"
      "* Grid: sigma 5 cm was the best of 5 to 35 cm, and cells of 1 cm were the best of 1 to 5\n"
      "  cm.\n"
      "* Power of the likelihood: 1 was better than 0.2.\n\n"
      "edge_mcl runs with its defaults, with one exception: it uses an image even when the\n"
      "image shows little of the model (`tracking.min_visible_samples = 0`).\n\n"
      "The errors and the times per update are medians over the images of a run, then means\n"
      "over the seeds. A run is lost when its last image has an error of more than 25 cm or 5\n"
      "degrees. MB is the largest resident size of the process, including model and program.\n";
  if (!c.accuracy_plot.empty())
    text += "\n![error over time per update](" + c.accuracy_plot + ")\n";
  if (!c.error_plot.empty()) text += "\n![error along the flights](" + c.error_plot + ")\n";
  text += format("\n## %d particles each\n", c.particles);
  for (const std::string& s : sequencesOf(count))
    text += "\n### " + s + "\n\n" + verdictOf(count, s) + "\n" + tableOf(count, s);
  text += format(
      "\n## As many particles as fit into %.0f ms on one core\n\n"
      "The number of particles is computed from the update times with two other numbers of\n"
      "particles. It is at least 10 and at most 20,000.\n",
      c.budget_ms);
  for (const std::string& s : sequencesOf(time))
    text += "\n### " + s + "\n\n" + verdictOf(time, s) + "\n" + tableOf(time, s);
  text += "\n## The paper's claims\n\n" + paperTable(c.bench);
  text +=
      "\nThe paper also says that the masks of a network help when objects are not in the map\n"
      "(figure 5, without numbers). To see this effect, compare \"edges\" with \"edges, without\n"
      "masks\" above. The masks there are perfect. [detector.md](detector.md) has the results\n"
      "with the masks of the detector.\n";
  return text;
}

}  // namespace edge_mcl
