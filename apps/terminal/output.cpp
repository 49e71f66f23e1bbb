#include "terminal/output.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include <fmt/format.h>
#include <unistd.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/build/effort.h"
#include "samara/codebooks/certify/builder_end.h"
#include "samara/io/animated_scene.h"
#include "samara/io/atomic_file.h"
#include "samara/io/hdf5_reader.h"
#include "terminal/terminal.h"
#include "terminal/text_layout.h"

namespace samara::apps {

void print(const std::string& text) {
  print_part(text);
}

void print_part(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (written && std::fflush(stdout) == 0) return;
  throw ArgumentError(fmt::format("the answer cannot be written to stdout: {}", std::strerror(errno)));
}

std::string json_line(const Json& object) {
  return object.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void print(const Json& object) {
  print(json_line(object));
}

void check_output(const std::string& path, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    std::error_code missing;
    if (std::filesystem::is_regular_file(path, missing) &&
        std::filesystem::equivalent(path, input, missing)) {
      throw ArgumentError(
          fmt::format("the output \"{}\" is the input \"{}\", which it would overwrite", path, input));
    }
  }
  io::require_writable(path);
}

void check_file_output(const std::string& path, const std::vector<std::string>& inputs) {
  if (path == "-")
    throw ArgumentError("the output is \"-\", but HDF5 goes to no stream; the name of a file was expected");
  check_output(path, inputs);
  io::require_name_of_format(path, ".h5");
  const io::PendingFile probe(path);
}

void check_text_output(const std::string& path, const std::vector<std::string>& inputs,
                       std::string_view ending) {
  check_output(path, inputs);
  io::require_name_of_format(path, ending);
}

void check_text_or_scene_output(const std::string& path, const std::vector<std::string>& inputs,
                                std::string_view ending) {
  check_output(path, inputs);
  if (io::is_scene_name(path)) return;
  io::check_scene_name(path);
  io::require_name_of_format(path, ending);
}

namespace {

/// What two names of one file have in common; links count, but not those of streams, which all may write to.
std::filesystem::path place_of(const std::string& name) {
  const std::filesystem::path path = std::filesystem::absolute(name);
  std::error_code problem;
  const std::filesystem::file_status status = std::filesystem::status(path, problem);
  if (std::filesystem::is_character_file(status) || std::filesystem::is_fifo(status))
    return path.lexically_normal();
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(path, problem);
  return problem ? path.lexically_normal() : canonical;
}

}  // namespace

void check_outputs_differ(const std::vector<std::pair<std::string, std::string>>& written) {
  for (std::size_t a = 0; a < written.size(); ++a) {
    for (std::size_t b = a + 1; b < written.size(); ++b) {
      if (written[a].second.empty() || written[b].second.empty()) continue;
      if (place_of(written[a].second) != place_of(written[b].second)) continue;
      throw ArgumentError(fmt::format("{} and {} both name \"{}\"; two files were expected", written[a].first,
                                      written[b].first, written[a].second));
    }
  }
}

void check_ending(const std::string& option, const std::string& path, const std::string& ending) {
  const std::string found = ending_of(path);
  const bool is_ending = found.size() > 1 && found[1] >= 'a' && found[1] <= 'z' &&
                         std::ranges::all_of(found.substr(1), [](char c) {
                           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
                         });
  if (!is_ending || found == ending) return;
  throw ArgumentError(fmt::format("{} is \"{}\", expected a name that ends in {}", option, path, ending));
}

void require_readable(const std::string& path) {
  if (::access(path.c_str(), R_OK) == 0) return;
  throw ArgumentError(
      fmt::format("the output \"{}\" is a file that cannot be read ({}): what would be lost is not known",
                  path, std::strerror(errno)));
}

void check_replaced(const std::string& path, const std::string& kind, const std::string& mark) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return;
  require_readable(path);
  constexpr std::size_t kLooked = 65536;
  std::string begin(kLooked, '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), kLooked);
  if (begin.find(mark) == std::string::npos)
    throw ArgumentError(
        fmt::format("the output \"{}\" is a file, and no {}: it would be overwritten", path, kind));
}

void check_replaced_hdf5(const std::string& path, const std::string& kind, const std::string& format) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return;
  require_readable(path);
  std::string found;
  try {
    const io::Hdf5Reader file(path);
    if (file.has_attribute("/", "format")) found = file.text_attribute("/", "format");
  } catch (const InputError&) {  // of another program, or damaged
  }
  if (found == format) return;
  const std::string said = found.empty() ? "" : fmt::format(" in the format \"{}\"", found);
  throw ArgumentError(
      fmt::format("the output \"{}\" is a file{}, and no {}: it would be overwritten", path, said, kind));
}

void write_answer(const std::string& path, const std::string& text) {
  if (path.empty()) {
    print(text);
  } else {
    io::write_text_atomically(path, text);
  }
}

void write_readable(const std::string& path, const std::string& text) {
  write_answer(path, wrapped_lines(text, path.empty() ? screen_width() : kUsualWidth));
}

void tell_of_file(const std::string& path, bool json) {
  if (!json) return;
  std::error_code problem;  // of a stream, which has no size
  const std::uintmax_t size = std::filesystem::file_size(path, problem);
  print(Json{{"schema", "samara-file/1"}, {"output", path}, {"bytes", problem ? Json() : Json(size)}});
}

namespace {

std::string counted(long count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace

std::string count_text(double count) {
  constexpr double kInFull = 1e9;
  const std::string rounded = fmt::format("{:.3g}", count);
  return count < kInFull ? fmt::format("{:.0f}", std::strtod(rounded.c_str(), nullptr)) : rounded;
}

std::string effort(const codebooks::Codebook& book) {
  const codebooks::BuildRecord& record = book.build();
  const double sweep = record.grid_size;
  if (record.builder == "sampling") {
    const char* calls = book.is_of_command() ? "calls" : "trajectories";
    const std::string grid = sweep > 0.0 ? fmt::format("; its grid has {:.6g} points", sweep) : "";
    return fmt::format("{}, {:.6g} {} with those of the checks{}", counted(record.rounds, "round", "rounds"),
                       record.evaluations, calls, grid);
  }
  if (book.space()) return counted(record.rounds, "attempt", "attempts");
  std::string text = counted(record.rounds, "march", "marches");
  if (record.strategy == "newton") {
    text = fmt::format("{}, {}", counted(record.rounds, "round", "rounds"),
                       counted(record.iterations, "Newton iteration", "Newton iterations"));
  }
  text += fmt::format(", {} evaluations in all", count_text(record.evaluations));
  if (record.builder != "pgd" || !(sweep > 0.0)) return text;
  text += fmt::format("; a sweep over its grid, {:.6g} trajectories, would take about {}",
                      codebooks::sweep_size(book.pieces()), count_text(sweep));
  return sweep < record.evaluations ? text + " and cost less" : text;
}

std::string miss_of(const codebooks::Codebook& book) {
  const codebooks::Certificate& c = *book.certificate();
  if (c.failed_points > 0) {
    return fmt::format("{} of {} {} of its certificate failed", c.failed_points, c.points,
                       book.is_of_command() ? "points" : "integrations");
  }
  if (c.max_error > c.tolerance)
    return fmt::format("largest error {:.3g} > {:.3g} ({})", c.max_error, c.tolerance, book.build().message);
  if (book.build().status == Termination::converged) return "its certificate is marked so";
  return fmt::format("the builder ended with \"{}\": {}", to_string(book.build().status),
                     book.build().message);
}

void warn_of_missed_tolerance(const codebooks::Codebook& book, const std::string& path) {
  if (!book.certificate()) {
    warn(fmt::format("{} has no certificate", path));
  } else if (!book.certificate()->met) {
    const bool unfinished = codebooks::is_only_unfinished(book.build(), *book.certificate());
    warn(fmt::format("{} {}: {}", path, unfinished ? "did not converge" : "missed its tolerance",
                     miss_of(book)));
  }
}

bool keep_numbers(const std::string& name, Eigen::Ref<Eigen::VectorXd, 0, Eigen::InnerStride<>> values) {
  Eigen::Index missing = 0;
  for (double& value : values) {
    if (std::isfinite(value)) continue;
    value = std::numeric_limits<double>::quiet_NaN();
    ++missing;
  }
  if (missing == 0) return true;
  warn(fmt::format("{} is no number in {} of {} rows, which are left empty", name, missing, values.size()));
  return false;
}

Json to_json(const codebooks::Certificate& c, const codebooks::Codebook& book) {
  Json object = {{"met", c.met},
                 {"verdict", codebooks::verdict(book.build(), c)},
                 {"tolerance", c.tolerance},
                 {"max_error", c.max_error},
                 {"points", c.points},
                 {"times", c.times},
                 {"places", c.places},
                 {"failed_points", c.failed_points},
                 {"wrong_points", nullptr},
                 {"share_above", nullptr},
                 {"climbed_points", c.climbed_points},
                 {"refuted_before", c.refuted_before},
                 {"seed", c.seed},
                 {"integrator", c.integrator},
                 {"integrator_tolerance", c.integrator_tolerance},
                 {"residual", c.residual},
                 {"spent",
                  {{"discretisation", c.spent.discretisation},
                   {"compression", c.spent.compression},
                   {"nonlinearity", c.spent.nonlinearity}}},
                 {"norm_defect", nullptr},
                 {"outputs", Json::array()}};
  if (c.wrong_points) {
    object["wrong_points"] = *c.wrong_points;
    object["share_above"] = codebooks::share_above(*c.wrong_points, c.points, c.refuted_before);
  }
  if (c.norm_defect) object["norm_defect"] = {{"max", c.norm_defect->max}, {"rms", c.norm_defect->rms}};
  for (const codebooks::OutputError& o : c.outputs) {
    Json worst = Json::object();
    for (std::size_t k = 0; k < o.worst.size(); ++k) worst[book.coordinates()[k].name] = o.worst[k];
    object["outputs"].push_back({{"name", o.name},
                                 {"unit", o.unit},
                                 {"range", o.range},
                                 {"max", o.max},
                                 {"p95", o.p95},
                                 {"mean", o.mean},
                                 {"rms", o.rms},
                                 {"max_si", o.max_si},
                                 {"worst", worst}});
  }
  return object;
}

namespace {

/// A course or a series: nothing was drawn from a box, and nothing integrated.
bool is_of_time_alone(const codebooks::Certificate& c, const codebooks::Codebook& book) {
  return book.has_time() && book.coordinates().size() == 1 && c.points == 1;
}

/// At how many points, and at all of what at each of them.
std::string spread_of(const codebooks::Certificate& c, const codebooks::Codebook& book) {
  if (is_of_time_alone(c, book)) return fmt::format("{} times", c.times);
  std::string text = fmt::format("{} points", c.points);
  if (book.has_time()) text += fmt::format(" x {} times", c.times);
  if (c.places > 0) text += fmt::format(" x {} places", c.places);
  return text;
}

/// How tight what a certificate compares with is, where that has a tolerance.
std::string tolerance_of(const codebooks::Certificate& c, const codebooks::Codebook& book) {
  const bool has_none = book.is_of_command() || c.integrator_tolerance == 0.0;
  return has_none ? std::string() : fmt::format(", relative tolerance {:.0e}", c.integrator_tolerance);
}

/// Of a share, to two digits and never in powers of ten.
std::string percent_of(double share) {
  const std::string two_digits = fmt::format("{:.2g}", 100.0 * share);
  std::string text = fmt::format("{:.10f}", std::strtod(two_digits.c_str(), nullptr));
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

/// Of what was compared with: without a seed where nothing was drawn.
std::string reference_of(const codebooks::Certificate& c, const codebooks::Codebook& book) {
  constexpr std::string_view kNone = "none: ";
  if (c.integrator.starts_with(kNone)) return c.integrator.substr(kNone.size());
  return fmt::format("against {}{}{}", c.integrator, tolerance_of(c, book),
                     is_of_time_alone(c, book) ? std::string() : fmt::format("; seed {}", c.seed));
}

/// A number, or "-" where there is none.
std::string shown(double value, const char* format, const std::string& suffix = "") {
  return std::isnan(value) ? std::string("-") : fmt::format(fmt::runtime(format), value) + suffix;
}

}  // namespace

std::string to_table(const codebooks::Certificate& c, const codebooks::Codebook& book) {
  const bool unfinished = codebooks::is_only_unfinished(book.build(), c);
  std::string verdict = unfinished ? "NOT CONVERGED" : "MISSED";
  if (c.met) verdict = is_of_time_alone(c, book) ? "met" : codebooks::verdict(book.build(), c);
  std::string text = fmt::format("certificate: {}, largest error {} (asked for {:.3g}) at {}\n", verdict,
                                 shown(c.max_error, "{:.3g}"), c.tolerance, spread_of(c, book));
  const bool is_of_builder = !c.met && book.build().status != Termination::converged &&
                             c.failed_points == 0 && c.max_error <= c.tolerance;
  if (is_of_builder)
    text += fmt::format("  no point errs by more than was asked, but {} ended with \"{}\"\n",
                        unfinished ? "the builder" : "points of the builder did: it",
                        to_string(book.build().status));
  if (c.failed_points > 0) {
    text += fmt::format("  {} points {}{}{}\n", c.failed_points,
                        book.is_of_command() ? "have no answer" : "could not be integrated",
                        c.failure.empty() ? "" : ", the first with: ", c.failure);
  }
  if (c.wrong_points) {
    text += fmt::format("  with 95 % confidence at most {} % of the box errs by more: {} of {} points do\n",
                        percent_of(codebooks::share_above(*c.wrong_points, c.points, c.refuted_before)),
                        *c.wrong_points == 0 ? "none" : std::to_string(*c.wrong_points), c.points);
  }
  if (c.climbed_points > 0)
    text += fmt::format("  {} climbs went from the worst points to what is largest around them\n",
                        c.climbed_points);
  text += fmt::format("  {}\n", reference_of(c, book));
  text += fmt::format("  {:<10} {:>10} {:>10} {:>10} {:>10} {:>14}  {}\n", "output", "max", "95 %", "mean",
                      "rms", "max in SI", "worst at");
  for (const codebooks::OutputError& o : c.outputs) {
    std::string worst;
    for (std::size_t k = 0; k < o.worst.size(); ++k) {
      const codebooks::Coordinate& coordinate = book.coordinates()[k];
      worst += fmt::format("{}{} = {:.4g}{}", k == 0 ? "" : ", ", coordinate.name, o.worst[k],
                           unit_suffix(coordinate.unit));
    }
    text += fmt::format("  {:<10} {:>10} {:>10} {:>10} {:>10} {:>14}  {}\n", o.name, shown(o.max, "{:.2e}"),
                        shown(o.p95, "{:.2e}"), shown(o.mean, "{:.2e}"), shown(o.rms, "{:.2e}"),
                        shown(o.max_si, "{:.2e}", unit_suffix(o.unit)), worst.empty() ? "-" : worst);
  }
  if (c.norm_defect) {
    text += fmt::format("  norm of the quaternion, as stored: off by {} at most, {} rms\n",
                        shown(c.norm_defect->max, "{:.2e}"), shown(c.norm_defect->rms, "{:.2e}"));
  }
  // A field is made as a whole: nothing says which part of it errs.
  if (c.spent.total() > 0.0)
    text += fmt::format("  spent: discretisation {:.1e}, compression {:.1e}, nonlinearity {:.1e}\n",
                        c.spent.discretisation, c.spent.compression, c.spent.nonlinearity);
  return printable(text, "\n");
}

}  // namespace samara::apps
