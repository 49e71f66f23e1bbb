#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "motion.h"
#include "samara/motion/patterns/clusters.h"
#include "samara/motion/patterns/labelled_segments.h"

namespace samara::python {

namespace {

/// Capture, first and last frame, word.
using SegmentRow = std::tuple<std::string, Eigen::Index, Eigen::Index, std::string>;

motion::PatternClasses classes_of(const std::map<std::string, std::vector<std::string>>& words) {
  motion::PatternClasses classes;
  for (const auto& [word, names] : words) {
    for (const std::string& name : names) classes[word].push_back(motion::pattern_of(name));
  }
  return classes;
}

/// @param path of a table of segments, or else the rows of one
/// @returns words, confusion (words, words), share, balanced, kappa, adjusted Rand index, and per segment its
///   capture, frames and word, and the pattern, margin and reason of the rule
py::tuple segment_agreement(const std::vector<std::filesystem::path>& files, const py::list& tables,
                            const std::filesystem::path& sidecar,
                            const std::optional<std::filesystem::path>& path,
                            const std::vector<SegmentRow>& rows,
                            const std::map<std::string, std::vector<std::string>>& words, double length,
                            const std::map<std::string, double>& thresholds) {
  const motion::PatternClasses classes = classes_of(words);
  std::vector<motion::LabelledSegment> segments;
  if (path) segments = motion::read_labelled_segments(*path, classes);
  for (const auto& [capture, first, last, word] : rows) segments.push_back({capture, first, last, word});
  const std::vector<identification::Capture> captures = captures_from(files, tables, sidecar);
  const motion::SegmentAgreement both = [&] {
    const py::gil_scoped_release release;
    return motion::compare(segments, captures, classes, length, thresholds_of(thresholds));
  }();
  py::list told;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const motion::LabelledSegment& s = segments[n];
    const motion::PatternLabel& label = both.labels[n];
    told.append(py::make_tuple(s.capture, s.first, s.last, s.label, to_string(label.pattern), label.margin,
                               label.why));
  }
  const motion::Agreement& agreement = both.agreement;
  return py::make_tuple(both.words, copied(Eigen::MatrixXd(agreement.confusion.cast<double>())),
                        agreement.share, agreement.balanced, agreement.kappa, agreement.adjusted_rand, told);
}

/// @param points (points, columns)
/// @returns assignment, centres (clusters, columns), objective, whether it converged, message
py::tuple clusters(const Array& points, bool mixture, int count, int restarts, std::uint64_t seed) {
  const Shape shape = shape_of(points);
  const ConstColumns columns(points.data(), shape.at(1), shape.at(0));
  const motion::ClusterOptions options = {.clusters = count, .restarts = restarts, .seed = seed};
  const motion::Clusters found = [&] {
    const py::gil_scoped_release release;
    return mixture ? motion::gaussian_mixture(columns.transpose(), options)
                   : motion::k_means(columns.transpose(), options);
  }();
  return py::make_tuple(found.assignment, copied(found.centres), found.objective, found.converged,
                        found.message);
}

}  // namespace

void add_pattern_tools(py::module_& module) {
  module.def("segment_agreement", &segment_agreement, py::arg("files"), py::arg("tables"), py::arg("sidecar"),
             py::arg("path"), py::arg("rows"), py::arg("words"), py::arg("length"), py::arg("thresholds"));
  module.def("clusters", &clusters, py::arg("points"), py::arg("mixture"), py::arg("count"),
             py::arg("restarts"), py::arg("seed"));
  module.def("adjusted_rand", &motion::adjusted_rand, py::arg("first"), py::arg("second"),
             py::call_guard<py::gil_scoped_release>());
}

}  // namespace samara::python
