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

/// The verdict is drawn from the figures, whoever wins.
std::string verdictOf(const std::vector<ComparedRow>& rows, const std::string& sequence) {
  const ComparedRow *own = nullptr, *builtin = nullptr;
  for (const ComparedRow& r : rows) {
    if (r.sequence != sequence || r.failed == r.runs) continue;
    const ComparedMethod& method = comparedMethod(r.method);
    if (method.kind != MethodKind::kOwn && !r.builtin) continue;
    const ComparedRow*& best = r.builtin ? builtin : own;
    // In the plane: all have that.
    if (!best || r.plane < best->plane) best = &r;
  }
  if (!own || !builtin) return "";
  const bool wins = builtin->plane < own->plane;
  const double ratio = wins ? own->plane / builtin->plane : builtin->plane / own->plane;
  std::string text = format(
      "In the plane, %s is the most exact (%.1f cm, %zu of %zu runs lost), then %s (%.1f cm, "
      "%zu of %zu lost): a factor of %.1f. ",
      (wins ? builtin : own)->title.c_str(), 100 * (wins ? builtin : own)->plane,
      (wins ? builtin : own)->lost, (wins ? builtin : own)->runs,
      (wins ? own : builtin)->title.c_str(), 100 * (wins ? own : builtin)->plane,
      (wins ? own : builtin)->lost, (wins ? own : builtin)->runs, ratio);
  if (wins) text += "**MRPT's filter wins here.** ";
  return text + "\n";
}

std::string paperTable(const nlohmann::json& bench) {
  std::string text =
      "The paper's Table 1 (ms per update, four experiments; neither the number of particles nor "
      "the hardware\nis given):\n\n"
      "| experiment | 1 | 2 | 3 | 4 |\n|---|---|---|---|---|\n"
      "| CPU | 123.6 | 102.83 | 150.12 | 131.84 |\n| CPU and GPU | 7.39 | 6.54 | 8.44 | 7.45 |\n"
      "| ratio | 16.7 | 15.7 | 17.7 | 17.6 |\n\n";
  if (bench.is_null()) return text + "Not measured anew in this run (`--bench`).\n";
  text +=
      "The same flow (its figure 2, written plainly, one thread) against our CPU backend on one "
      "thread,\n"
      "sequence " +
      bench.at("sequence").get<std::string>() +
      ", likelihood only, without a GPU:\n\n"
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
  std::string text = "# Comparison with MRPT's own filters\n\nMade by\n\n    " + c.command + "\n\n";
  text += format(
      "on one core of: %s. %zu seeds each. All filters get the same start (with the spread that "
      "the sequence says),\nthe same odometry and the same model of its noise, the same images, "
      "masks and depth images. Every run is a\nprocess of its own, bound to one core; a run that "
      "was made is kept, so the command goes on where it was stopped.\n\n",
      c.machine.c_str(), seeds);
  text +=
      "* **edge_mcl**: the localizer as it is, with refinement and recovery, one cue or both.\n"
      "* **MRPT's 3D filter on edge_mcl's map**: `CMonteCarloLocalization3D` with `CEdgeMap`, full "
      "power of the\n"
      "  likelihood (`powFactor = 1`) and edge_mcl's default parameters: what our likelihood does "
      "without our\n"
      "  filter. `docs/examples/pf_localization.ini` gives MRPT's filter `powFactor = 0.4` and "
      "`likelihood.sigma = 3`.\n"
      "* **MRPT's 3D filter on a point map**: the same on a `CSimplePointsMap` of the model's "
      "surfaces (5 cm\n"
      "  apart), with the 500 depth points that edge_mcl's depth cue takes.\n"
      "* **MRPT's 2D filter on a grid**: `CMonteCarloLocalization2D` on a `COccupancyGridMap2D` (1 "
      "cm) cut from\n"
      "  the model at the height of the start, with a scan made from the depth image there.\n"
      "  (1) It estimates x, y and heading; height, roll and pitch are given to it from the "
      "truth.\n"
      "* **dead reckoning**: the start and the odometry.\n\n"
      "MRPT's likelihoods have settings for the sensor. Those used were the best of those tried on "
      "the office\n"
      "flight: of sigmas of 2 to 50 mm for the point map 5 mm, spacings of 2 and 5 cm being "
      "equally good; of\n"
      "likelihood fields with 5 to 35 cm sigma and 1 to 5 cm cells 5 cm and 1 cm; full power of "
      "the likelihood\n"
      "rather than a fifth. Their defaults were worse. edge_mcl runs with its defaults,\nbut uses "
      "images however little of the model they show.\n\n"
      "Position and rotation are medians over the images of a run, then means over the seeds; a "
      "run is lost\n"
      "when its last image is off by more than 25 cm or 5 degrees. MB: largest resident size of "
      "the process,\n"
      "model and program included.\n";
  if (!c.accuracy_plot.empty())
    text += "\n![error over time per update](" + c.accuracy_plot + ")\n";
  if (!c.error_plot.empty()) text += "\n![error along the flights](" + c.error_plot + ")\n";
  text += format("\n## %d particles each\n", c.particles);
  for (const std::string& s : sequencesOf(count))
    text += "\n### " + s + "\n\n" + verdictOf(count, s) + "\n" + tableOf(count, s);
  text += format(
      "\n## As many particles as fit into %.0f ms on one core\n\n"
      "Their number follows from the time that updates took with two other numbers; at least "
      "10, at most 20,000.\n",
      c.budget_ms);
  for (const std::string& s : sequencesOf(time))
    text += "\n### " + s + "\n\n" + verdictOf(time, s) + "\n" + tableOf(time, s);
  text += "\n## The paper's claims\n\n" + paperTable(c.bench);
  text +=
      "\nThat a network's masks help where things are not in the map (its figure 5, without "
      "figures): compare\n"
      "\"edges\" and \"edges, without masks\" above; there masks are perfect. With the masks of "
      "the detector:\n"
      "[detector.md](detector.md).\n";
  return text;
}

}  // namespace edge_mcl
