#include "samara/codebooks/file/certificate_format.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace samara::codebooks {

using io::Hdf5Reader;
using io::Hdf5Writer;

void write_certificate(Hdf5Writer& file, const Certificate& c) {
  const std::string path = "/certificate";
  file.create_group(path);
  file.write_text_attribute(
      path, "definition",
      "error = largest |codebook - integrator| over points and times, divided by max(range of the "
      "output, absolute tolerance), or by the size of an output that is constant up to rounding");
  file.write_number_attribute(path, "tolerance", c.tolerance);
  file.write_integer_attribute(path, "met", c.met ? 1 : 0);
  file.write_number_attribute(path, "max_error", c.max_error);
  file.write_integer_attribute(path, "points", c.points);
  file.write_integer_attribute(path, "times", c.times);
  if (c.places > 0) file.write_integer_attribute(path, "places", c.places);
  file.write_integer_attribute(path, "failed_points", c.failed_points);
  if (c.wrong_points) {
    file.write_integer_attribute(path, "wrong_points", *c.wrong_points);
    file.write_number_attribute(path, "share_above",
                                share_above(*c.wrong_points, c.points, c.refuted_before));
  }
  file.write_integer_attribute(path, "climbed_points", c.climbed_points);
  file.write_integer_attribute(path, "refuted_before", c.refuted_before);
  // Seeds use all 64 bits, integers of the file are signed: as text.
  file.write_text_attribute(path, "seed", std::to_string(c.seed));
  file.write_text_attribute(path, "integrator", c.integrator);
  file.write_number_attribute(path, "integrator_tolerance", c.integrator_tolerance);
  file.write_number_attribute(path, "residual", c.residual);
  file.write_number_attribute(path, "spent_discretisation", c.spent.discretisation);
  file.write_number_attribute(path, "spent_compression", c.spent.compression);
  file.write_number_attribute(path, "spent_nonlinearity", c.spent.nonlinearity);
  if (c.norm_defect) {
    file.write_number_attribute(path, "norm_defect_max", c.norm_defect->max);
    file.write_number_attribute(path, "norm_defect_rms", c.norm_defect->rms);
  }
  for (const OutputError& o : c.outputs) {
    const std::string output = path + "/" + o.name;
    file.create_group(output);
    file.write_text_attribute(output, "units", o.unit);
    file.write_number_attribute(output, "range", o.range);
    file.write_number_attribute(output, "max", o.max);
    file.write_number_attribute(output, "p95", o.p95);
    file.write_number_attribute(output, "mean", o.mean);
    file.write_number_attribute(output, "rms", o.rms);
    file.write_number_attribute(output, "max_si", o.max_si);
    file.write_numbers_attribute(output, "worst", o.worst);
  }
}

namespace {

/// Numbers of a certificate. Those of one that is met are finite; else, errors may be infinite, and NaN where
/// nothing was measured.
struct CertificateNumbers {
  const Hdf5Reader& file;
  bool met = false;
  bool measured = true;

  double operator()(const std::string& path, const std::string& name) const {
    const double value = file.number_attribute(path, name);
    if (met && !std::isfinite(value))
      throw file.error(path, fmt::format("{} is {}, expected a finite number where met is 1", name, value));
    if (measured && std::isnan(value))
      throw file.error(path, fmt::format("{} is nan, expected a number where integrations succeeded", name));
    return value;
  }
};

int count_attribute(const Hdf5Reader& file, const std::string& path, const std::string& name) {
  const std::int64_t value = file.integer_attribute(path, name);
  if (value < 0 || value > std::numeric_limits<int>::max())
    throw file.error(path, fmt::format("{} is {}, expected a count", name, value));
  return static_cast<int>(value);
}

bool read_met(const Hdf5Reader& file, const std::string& path) {
  const std::int64_t met = file.integer_attribute(path, "met");
  if (met != 0 && met != 1) throw file.error(path, fmt::format("met is {}, expected 0 or 1", met));
  return met == 1;
}

}  // namespace

Certificate read_certificate(const Hdf5Reader& file) {
  const std::string path = "/certificate";
  Certificate c;
  c.tolerance = file.finite_attribute(path, "tolerance");
  c.met = read_met(file, path);
  c.points = count_attribute(file, path, "points");
  c.times = count_attribute(file, path, "times");
  if (file.has_attribute(path, "places")) c.places = count_attribute(file, path, "places");
  if (file.has_attribute(path, "wrong_points")) {
    c.wrong_points = count_attribute(file, path, "wrong_points");
    if (c.points == 0)
      throw file.error(path, "points is 0, expected at least 1 where there are wrong_points");
    if (*c.wrong_points > c.points || (c.met && *c.wrong_points > 0)) {
      throw file.error(path,
                       fmt::format("wrong_points is {}, expected {}", *c.wrong_points,
                                   c.met ? "0 where met is 1" : fmt::format("at most points, {}", c.points)));
    }
  }
  if (file.has_attribute(path, "climbed_points"))
    c.climbed_points = count_attribute(file, path, "climbed_points");
  if (file.has_attribute(path, "refuted_before"))
    c.refuted_before = count_attribute(file, path, "refuted_before");
  if (c.met && c.points == 0) throw file.error(path, "points is 0, expected at least 1 where met is 1");
  c.failed_points = count_attribute(file, path, "failed_points");
  if (const int most = c.met ? c.points - 1 : c.points; c.failed_points > most) {
    throw file.error(path,
                     fmt::format("failed_points is {}, expected at most {} of {} points where met is {}",
                                 c.failed_points, most, c.points, c.met ? 1 : 0));
  }
  const CertificateNumbers number{file, c.met, c.failed_points < c.points};
  c.max_error = number(path, "max_error");
  if (c.met && !(c.max_error <= c.tolerance)) {
    throw file.error(path, fmt::format("met is 1, but max_error {} is more than the tolerance {}",
                                       c.max_error, c.tolerance));
  }
  const std::string seed = file.text_attribute(path, "seed");
  const auto [rest, problem] = std::from_chars(seed.data(), seed.data() + seed.size(), c.seed);
  if (problem != std::errc() || rest != seed.data() + seed.size())
    throw file.error(path, fmt::format("seed is \"{}\", expected a whole number", seed));
  c.integrator = file.text_attribute(path, "integrator");
  c.integrator_tolerance = file.finite_attribute(path, "integrator_tolerance");
  c.residual = number(path, "residual");
  c.spent.discretisation = number(path, "spent_discretisation");
  c.spent.compression = number(path, "spent_compression");
  c.spent.nonlinearity = number(path, "spent_nonlinearity");
  const CertificateNumbers square{file, false, number.measured};  // squares may overflow
  if (file.has_attribute(path, "norm_defect_max") || file.has_attribute(path, "norm_defect_rms"))
    c.norm_defect = {number(path, "norm_defect_max"), square(path, "norm_defect_rms")};
  for (const std::string& name : file.children(path)) {
    const std::string output = path + "/" + name;
    OutputError o;
    o.name = name;
    o.unit = file.text_attribute(output, "units");
    o.range = number(output, "range");
    o.max = number(output, "max");
    o.p95 = number(output, "p95");
    o.mean = number(output, "mean");
    o.rms = square(output, "rms");
    o.max_si = number(output, "max_si");
    o.worst = file.numbers_attribute(output, "worst");
    c.outputs.push_back(std::move(o));
  }
  return c;
}

}  // namespace samara::codebooks
