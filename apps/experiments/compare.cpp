// edge-mcl compare: compares this localizer with MRPT's own filters and writes a document.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include "apps/common_options.h"
#include "apps/experiments/compare_runs.h"
#include "apps/number_range.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "edge_mcl/comparison/compared_methods.h"
#include "edge_mcl/comparison/comparison_plot.h"
#include "edge_mcl/comparison/comparison_report.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/sim/sequence_writer.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {

namespace {

namespace fs = std::filesystem;

struct CompareOptions {
  std::string out, report, one;
  std::vector<std::string> flights, sequences, methods;
  int seeds = 5, particles = 1000, core = -1;
  uint64_t seed = 1;
  double budget_ms = 30, rate = 10;
  bool bench = false;
};

/// Checks that the flights in OUT have the image rate of this call, and writes the rate into a new
/// OUT. @throws ParameterError when the rates differ
void checkRate(const CompareOptions& o) {
  const std::string file = o.out + "/rate.json";
  if (!fs::exists(file)) {
    writeJson(file, {{"rate", o.rate}});
    return;
  }
  std::ifstream in(file);
  const nlohmann::json kept = nlohmann::json::parse(in, nullptr, false);
  if (!kept.is_object() || !kept.contains("rate") || kept["rate"] != o.rate)
    throw ParameterError("--rate: the flights in " + o.out +
                         " have another rate; use another directory");
}

/// Hash of a text, 16 hexadecimal digits. It is the same on every machine.
std::string fingerprintOf(const std::string& text) {
  uint64_t hash = 1469598103934665603ull;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  char hex[17];
  std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(hash));
  return hex;
}

/// Fingerprints of the sources of all sequences in OUT, by the name of the sequence.
nlohmann::json sourcesOf(const CompareOptions& o) {
  const std::string file = o.out + "/sources.json";
  nlohmann::json kept = nlohmann::json::object();
  if (std::ifstream in(file); in) kept = nlohmann::json::parse(in, nullptr, false);
  if (!kept.is_object()) throw InputError(file + ": the file is broken; use another directory");
  return kept;
}

/// Checks that OUT holds nothing of another sequence with the same name, because flights and runs
/// are kept by the name of their sequence. @throws InputError when it does
void checkSource(const CompareOptions& o, const std::string& name, const std::string& source,
                 const std::string& fingerprint) {
  const nlohmann::json kept = sourcesOf(o);
  if (kept.contains(name) && kept[name] != fingerprint)
    throw InputError(source + ": the data in " + o.out + " of " + name +
                     " come from another scenario or sequence; use another directory");
}

/// Stores the fingerprint of a sequence. To be called when OUT holds data of it.
void keepSource(const CompareOptions& o, const std::string& name, const std::string& fingerprint) {
  nlohmann::json kept = sourcesOf(o);
  if (kept.contains(name)) return;
  kept[name] = fingerprint;
  writeJson(o.out + "/sources.json", kept);
}

/// Checks that every sequence has a name of its own that can be part of a file name, because
/// results are kept by these names. @throws InputError, ParameterError
void checkNames(const std::vector<std::pair<std::string, Sequence>>& sequences) {
  std::set<std::string> names;
  for (const auto& [directory, sequence] : sequences) {
    if (sequence.name.empty() || sequence.name.find('/') != std::string::npos)
      throw InputError(directory + ": the name of the sequence, '" + sequence.name +
                       "', cannot be a file name");
    if (!names.insert(sequence.name).second)
      throw ParameterError("two sequences have the name " + sequence.name);
  }
}

/// Simulates a flight if OUT does not hold it yet. The directory of a flight appears only when the
/// flight is complete. @return this directory
std::string simulated(const std::string& scenario_file, const CompareOptions& o) {
  const std::string name = fs::path(scenario_file).stem().string();
  std::ifstream in(scenario_file);
  if (!in) throw InputError(scenario_file + ": cannot be read");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::string fingerprint = fingerprintOf("flight " + text);
  checkSource(o, name, scenario_file, fingerprint);
  const fs::path directory = fs::path(o.out) / "flights" / name;
  if (fs::exists(directory)) {
    keepSource(o, name, fingerprint);
    return directory.string();
  }
  const fs::path partial = fs::path(o.out) / "unfinished" / name;
  fs::remove_all(partial);
  fs::create_directories(partial.parent_path());
  fs::create_directories(directory.parent_path());
  Scenario scenario = Scenario::fromYamlFile(scenario_file);
  scenario.rate = o.rate;
  Simulator simulator(std::move(scenario));
  SequenceWriter writer(partial.string(), simulator.setup(), simulator.scenario().model_file,
                        simulator.notes());
  ProgressBar bar("simulate " + name, simulator.imageCount());
  for (size_t i = 0; i < simulator.imageCount(); ++i) {
    RecordedFrame frame;
    if (simulator.next(&frame)) writer.write(frame);
    bar.advance();
  }
  writer.close();
  fs::rename(partial, directory);
  keepSource(o, name, fingerprint);
  return directory.string();
}

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

int lastCore() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())) - 1; }

/// Number of particles whose update takes `budget_ms`, by a straight line through two measured
/// points (particles, ms). It is rounded to two digits and lies between 10 and 20,000.
int particlesFor(double budget_ms, int few, double ms_of_few, int many, double ms_of_many) {
  const double slope = std::max(1e-6, (ms_of_many - ms_of_few) / (many - few));
  const double n = std::clamp(few + (budget_ms - ms_of_few) / slope, 10.0, 20000.0);
  const double digit = std::pow(10, std::floor(std::log10(n)) - 1);
  return static_cast<int>(std::lround(n / digit) * std::lround(digit));
}

/// Makes the runs that the document needs, one after the other.
class Plan {
 public:
  Plan(const CompareOptions& o, std::vector<std::pair<std::string, Sequence>> sequences)
      : options_(o),
        sequences_(std::move(sequences)),
        few_(std::max(10, o.particles / 5)),
        runs_(o.out + "/runs", o.core >= 0 ? o.core : lastCore()) {}

  Comparison run() {
    size_t total = 0;
    forEach([&](const auto&, const ComparedMethod& m) { total += m.hasParticles() ? 3 : 1; });
    ProgressBar bar("compare", total * static_cast<size_t>(options_.seeds));
    Comparison c;
    c.particles = options_.particles;
    c.budget_ms = options_.budget_ms;
    // Seed by seed: an interrupted command has then compared all methods on all sequences, with
    // fewer seeds.
    for (int seed = 1; seed <= options_.seeds; ++seed) {
      forEach([&](const auto& sequence, const ComparedMethod& m) {
        const auto get = [&](int particles) {
          ComparedRun r = runs_.get({m.name, sequence.first, sequence.second.name,
                                     static_cast<uint64_t>(seed), particles});
          bar.advance();
          if (!r.failure.empty())
            bar.note("warning: " + sequence.second.name + ", " + m.title + ": " + r.failure);
          return r;
        };
        if (!m.hasParticles()) {
          c.equal_count.push_back(get(0));
          c.equal_time.push_back(c.equal_count.back());
          return;
        }
        const ComparedRun few = get(few_), many = get(options_.particles);
        const double least = few.update_ms.median, most = many.update_ms.median;
        all_.push_back(few);
        c.equal_count.push_back(many);
        int& fitting = fitting_[sequence.second.name + "/" + m.name];
        if (fitting == 0)
          fitting = particlesFor(options_.budget_ms, few_, least, options_.particles, most);
        ComparedRun fits = get(fitting);
        // Far from the two measured numbers of particles, the time is not on the straight line
        // through them. So a second line starts at the number that was measured just now.
        const double time = fits.update_ms.median;
        if (seed == 1 && fits.failure.empty() && time < 0.75 * options_.budget_ms) {
          const bool fewer = fitting < few_;
          const int better = particlesFor(options_.budget_ms, fitting, time,
                                          fewer ? few_ : options_.particles, fewer ? least : most);
          if (better > fitting) fits = get(fitting = better);
        }
        c.equal_time.push_back(fits);
      });
    }
    all_.insert(all_.end(), c.equal_count.begin(), c.equal_count.end());
    for (const ComparedRun& r : c.equal_time)
      if (r.particles != 0 && r.particles != few_ && r.particles != options_.particles)
        all_.push_back(r);
    return c;
  }
  /// All runs, with every number of particles.
  const std::vector<ComparedRun>& all() const { return all_; }

 private:
  template <class F>
  void forEach(F&& f) const {
    for (const auto& sequence : sequences_)
      for (const ComparedMethod& m : comparedMethods()) {
        const auto& chosen = options_.methods;
        const bool wanted =
            chosen.empty() || std::find(chosen.begin(), chosen.end(), m.name) != chosen.end();
        if (wanted && m.fits(sequence.second)) f(sequence, m);
      }
  }

  const CompareOptions& options_;
  std::vector<std::pair<std::string, Sequence>> sequences_;  // directory and content
  int few_;
  ComparedRuns runs_;
  std::map<std::string, int> fitting_;
  std::vector<ComparedRun> all_;
};

std::string commandOf(const CompareOptions& o) {
  std::string text = "edge-mcl compare OUT";
  for (const std::string& f : o.flights)
    text += " --flight maps/" + fs::path(f).filename().string();
  for (const std::string& s : o.sequences)
    text += " --sequence " + fs::path(s).lexically_normal().filename().string();
  text += " --seeds " + std::to_string(o.seeds) + " --particles " + std::to_string(o.particles);
  if (!o.flights.empty()) {
    char rate[32];
    std::snprintf(rate, sizeof rate, " --rate %g", o.rate);
    text += rate;
  }
  const CompareOptions defaults;
  for (const std::string& m : o.methods) text += " --method " + m;
  if (o.budget_ms != defaults.budget_ms) {
    char budget[32];
    std::snprintf(budget, sizeof budget, " --budget-ms %g", o.budget_ms);
    text += budget;
  }
  if (o.core >= 0) text += " --core " + std::to_string(o.core);
  if (o.bench) text += " --bench";
  return text + (o.report.empty() ? "" : " --report docs/comparison.md");
}

nlohmann::json benchOf(const CompareOptions& o, const std::string& directory) {
  const std::string file = o.out + "/bench.json";
  if (!fs::exists(file)) {
    const int code = runSelf({"--threads", "1", "bench", directory, "--updates", "0", "--table",
                              "100,500,1000,5000,50000", "--json"},
                             file + ".part");
    if (code != kExitOk) throw InputError("edge-mcl bench " + directory + " failed");
    fs::rename(file + ".part", file);
  }
  std::ifstream in(file);
  return nlohmann::json::parse(in);
}

int run(const CompareOptions& o) {
  if (!o.one.empty()) {
    if (o.sequences.size() != 1) throw ParameterError("--one needs exactly one --sequence");
    runAndKeep({o.one, o.sequences.front(), "", o.seed, o.particles},
               o.core >= 0 ? o.core : lastCore(), o.out);
    return kExitOk;
  }
  for (const std::string& m : o.methods) comparedMethod(m);
  if (o.particles < 20) throw ParameterError("--particles: must be at least 20");
  makeDirectory(o.out);
  if (!o.flights.empty()) checkRate(o);
  std::vector<std::string> directories;
  for (const std::string& f : o.flights) directories.push_back(simulated(f, o));
  directories.insert(directories.end(), o.sequences.begin(), o.sequences.end());
  if (directories.empty()) throw ParameterError("nothing to compare: give --flight or --sequence");
  std::vector<std::pair<std::string, Sequence>> sequences;
  sequences.reserve(directories.size());
  for (const std::string& d : directories) sequences.emplace_back(d, readSequence(d));
  checkNames(sequences);
  for (const auto& [directory, sequence] : sequences)
    if (std::find(o.sequences.begin(), o.sequences.end(), directory) != o.sequences.end()) {
      const std::string print = fingerprintOf("directory " + fs::canonical(directory).string());
      checkSource(o, sequence.name, directory, print);
      keepSource(o, sequence.name, print);
    }
  Plan plan(o, std::move(sequences));
  Comparison comparison = plan.run();
  comparison.machine = processor();
  comparison.command = commandOf(o);
  if (o.bench) comparison.bench = benchOf(o, directories.front());
  const fs::path report = o.report.empty() ? fs::path(o.out) / "comparison.md" : fs::path(o.report);
  const fs::path pictures = report.parent_path() / "images";
  makeDirectory(pictures.string());
  writePicture((pictures / "comparison-accuracy.png").string(), drawAccuracy(rowsOf(plan.all())));
  writePicture((pictures / "comparison-errors.png").string(), drawErrors(comparison.equal_count));
  comparison.accuracy_plot = "images/comparison-accuracy.png";
  comparison.error_plot = "images/comparison-errors.png";
  std::ofstream out(report);
  out << toMarkdown(comparison);
  if (!out.flush()) throw InputError(report.string() + ": cannot be written");
  std::printf("%s\n", report.c_str());
  return kExitOk;
}

}  // namespace

void addCompare(CLI::App* app, Action* action) {
  auto o = std::make_shared<CompareOptions>();
  CLI::App* c = app->add_subcommand(
      "compare",
      "compare this localizer with MRPT's own filters on the same recordings and write a document "
      "with tables and plots. Finished runs are kept in OUT, so the same command continues after "
      "an interruption. When the program or a model has changed, use a new OUT");
  c->add_option("out", o->out,
                "directory for runs and simulated flights; it is created if it does not exist")
      ->required();
  c->add_option("--flight", o->flights,
                "YAML file as for simulate, whose flight is simulated; can be given several times")
      ->take_all();
  c->add_option("--sequence", o->sequences,
                "sequence directory, whose map has z up; can be given several times")
      ->take_all();
  c->add_option("--method", o->methods,
                "name of a method to run; can be given several times; default: all methods")
      ->take_all();
  c->add_option("--seeds", o->seeds,
                "number of runs per method and sequence, with the seeds 1, 2, ...; default 5")
      ->check(CLI::PositiveNumber);
  c->add_option("--particles", o->particles,
                "number of particles of every filter, at least 20; default 1000")
      ->check(CLI::Range(0, 1000000));
  c->add_option("--budget-ms", o->budget_ms,
                "time of an update in the second table, ms; default 30")
      ->check(numberFrom(0.1, 10000));
  c->add_option("--rate", o->rate, "images per second of the simulated flights; default 10")
      ->check(numberFrom(0.01, 1000));
  c->add_option("--core", o->core,
                "number of the processor core for all runs; default: the last core");
  c->add_flag("--bench", o->bench,
              "also time the paper's algorithm, plainly written (edge-mcl bench)");
  c->add_option("--report", o->report,
                "document to write, with its pictures in the folder images/ beside it; default: "
                "OUT/comparison.md");
  // Hidden options for the processes that this command starts.
  c->add_option("--one", o->one, "")->group("");
  c->add_option("--seed", o->seed, "")->group("");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
