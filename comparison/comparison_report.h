/// The comparison as a document.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/comparison/compared_run.h"

namespace edge_mcl {

/// All seeds of one method on one sequence with one number of particles.
struct ComparedRow {
  std::string method, title, sequence;
  int particles = 0;
  bool builtin = false;
  size_t runs = 0, lost = 0, failed = 0;
  /// Means over the seeds that ran: of medians and 90th percentiles, m and deg; of shares.
  double position = 0, position_p90 = 0, plane = 0, rotation = 0, success = 0;
  double update_ms = 0, peak_mb = 0;  ///< mean of medians; largest
};

/// Rows in the order of comparedMethods(), sequences in the order of their first run.
std::vector<ComparedRow> rowsOf(const std::vector<ComparedRun>& runs);

struct Comparison {
  std::vector<ComparedRun> equal_count;  ///< with `particles` each
  std::vector<ComparedRun> equal_time;   ///< with as many as fit into `budget_ms`
  int particles = 1000;
  double budget_ms = 30;
  std::string machine;        ///< processor
  std::string command;        ///< that makes the document anew
  nlohmann::json bench;       ///< of `edge-mcl bench --json`; null: not run
  std::string accuracy_plot;  ///< as linked in the document; empty: none
  std::string error_plot;
};

/// In GitHub's Markdown. Says of every sequence which method is the most exact, MRPT's or ours.
std::string toMarkdown(const Comparison& comparison);

}  // namespace edge_mcl
