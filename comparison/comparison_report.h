/// Writes the comparison as a Markdown page.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/comparison/compared_run.h"

namespace edge_mcl {

/// A row of a table: all seeds of one method on one sequence with one number of particles.
struct ComparedRow {
  std::string method, title, sequence;
  int particles = 0;
  bool builtin = false;                   ///< see ComparedMethod::isBuiltin
  size_t runs = 0, lost = 0, failed = 0;  ///< numbers of runs
  /// Means over the runs that did not fail. position, plane, rotation: of the median errors, m and
  /// deg. position_p90: of the 90th percentiles, m. success: of the shares.
  double position = 0, position_p90 = 0, plane = 0, rotation = 0, success = 0;
  double update_ms = 0, peak_mb = 0;  ///< mean of the medians; largest of all runs
};

/// Makes the rows, in the order of comparedMethods(); sequences are in the order of their first
/// run.
std::vector<ComparedRow> rowsOf(const std::vector<ComparedRun>& runs);

/// All data of the page.
struct Comparison {
  std::vector<ComparedRun> equal_count;  ///< runs with `particles` particles
  std::vector<ComparedRun> equal_time;   ///< runs with as many particles as fit into `budget_ms`
  int particles = 1000;
  double budget_ms = 30;      ///< time per update
  std::string machine;        ///< processor
  std::string command;        ///< the command that makes the page
  nlohmann::json bench;       ///< output of `edge-mcl bench --json`; null: not run
  std::string accuracy_plot;  ///< link in the page; empty: no plot
  std::string error_plot;     ///< link in the page; empty: no plot
};

/// Returns the page in GitHub's Markdown. For every sequence it names the method with the smallest
/// error, of edge_mcl or of MRPT.
std::string toMarkdown(const Comparison& comparison);

}  // namespace edge_mcl
