/// Shows the progress of a command, with the rate per second and the remaining time.
#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

namespace edge_mcl {

/// A progress bar on stderr. It is shown only when stderr is a terminal.
class ProgressBar {
 public:
  ProgressBar(std::string title, size_t total)
      : title_(std::move(title)),
        total_(total),
        on_terminal_(isatty(fileno(stderr)) != 0),
        start_(std::chrono::steady_clock::now()) {}
  ~ProgressBar() {
    if (on_terminal_ && shown_) std::fprintf(stderr, "\n");
  }
  /// Counts one step, and draws the bar at most ten times a second.
  void advance() {
    ++done_;
    if (!on_terminal_) return;
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    if (done_ != total_ && seconds - last_ < 0.1) return;
    last_ = seconds;
    shown_ = true;
    const double rate = static_cast<double>(done_) / (seconds > 0 ? seconds : 1e-9);
    constexpr int kWidth = 30;
    const int filled = static_cast<int>(kWidth * done_ / (total_ ? total_ : 1));
    std::fprintf(stderr, "\r%s [%.*s%*s] %zu/%zu  %.1f/s  %.0f s left ", title_.c_str(), filled,
                 "##############################", kWidth - filled, "", done_, total_, rate,
                 static_cast<double>(total_ - done_) / rate);
    std::fflush(stderr);
  }
  /// Prints a line on stderr, in place of the bar. The next advance() draws the bar below it.
  void note(const std::string& text) {
    std::fprintf(stderr, "%s%s\n", on_terminal_ && shown_ ? "\r\033[K" : "", text.c_str());
  }

 private:
  std::string title_;
  size_t total_, done_ = 0;
  bool on_terminal_, shown_ = false;
  double last_ = 0;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace edge_mcl
