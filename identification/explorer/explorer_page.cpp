#include "samara/identification/explorer/explorer_page.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "page_parts.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/explorer/explored_data.h"
#include "samara/identification/pages/base64.h"
#include "samara/identification/pages/html_page.h"

namespace samara::identification {

namespace {

using Json = nlohmann::ordered_json;

void check_content(const ExplorerContent& content) {
  if (content.books.empty()) throw ArgumentError("no codebook is given, expected at least one");
  require(content.times >= 2 && content.times <= 5000, "number of times", content.times, "2 to 5000");
  if (content.body && content.body->triangles.cols() > kMostExplorerTriangles) {
    throw ArgumentError(fmt::format(
        "the body has {} triangles, more than the {} that a page draws: a coarser mesh was expected",
        content.body->triangles.cols(), kMostExplorerTriangles));
  }
  std::vector<std::string> known;
  for (const ExploredBook& explored : content.books)
    for (const pgd::OutputLabel& output : explored.book.outputs()) known.push_back(output.name);
  for (const std::string& name : content.outputs) {
    if (std::ranges::count(known, name) == 0) {
      throw ArgumentError(fmt::format("no codebook has an output \"{}\"{}", name, suggestion(name, known)));
    }
  }
  for (const ExploredBook& explored : content.books) {
    if (outputs_to_show(explored.book, content.outputs).empty())
      throw ArgumentError(fmt::format("{} has none of the chosen outputs", explored.file));
    if (content.fit && content.fit->model != explored.book.model().name) {
      throw ArgumentError(
          fmt::format("the fit is of the model \"{}\", and {} of \"{}\": the same was expected",
                      content.fit->model, explored.file, explored.book.model().name));
    }
  }
}

void check_size(const ExplorerContent& content) {
  double bytes = 0.0;
  for (const ExploredBook& explored : content.books)
    bytes += factor_bytes(explored.book, outputs_to_show(explored.book, content.outputs));
  if (bytes <= kMostExplorerBytes) return;
  throw ArgumentError(
      fmt::format("the factors have {:.1f} MB, more than the {:.0f} MB that a page takes: fewer outputs "
                  "(--outputs) were expected",
                  1e-6 * bytes, 1e-6 * kMostExplorerBytes));
}

/// The channels of a capture that some book has as an output of the same unit.
Json capture_json(const Capture& capture, const ExplorerContent& content,
                  std::vector<std::string>& warnings) {
  Json json = {{"id", capture.id},
               {"times", std::vector<double>(capture.times.begin(), capture.times.end())},
               {"channels", Json::array()}};
  for (const Channel& channel : capture.channels) {
    const bool is_known = std::ranges::any_of(content.books, [&](const ExploredBook& explored) {
      return std::ranges::any_of(outputs_to_show(explored.book, content.outputs), [&](int o) {
        const pgd::OutputLabel& output = explored.book.outputs()[static_cast<std::size_t>(o)];
        return output.name == channel.quantity && output.unit == channel.unit;
      });
    });
    if (!is_known) {
      warnings.push_back(
          fmt::format("capture \"{}\": {} in {} is no output of the codebook, and is not shown", capture.id,
                      channel.quantity, channel.unit));
      continue;
    }
    json["channels"].push_back(
        {{"quantity", channel.quantity},
         {"unit", channel.unit},
         {"isAngle", is_angle(channel)},
         {"values", std::vector<double>(channel.values.begin(), channel.values.end())}});
  }
  return json;
}

/// Whether a name of a file ends in another, folder by folder: a fit may have been made in a folder further in.
bool ends_in(const std::string& file, const std::string& end) {
  const std::filesystem::path whole(file), tail(end);
  const std::vector<std::filesystem::path> parts(whole.begin(), whole.end()), last(tail.begin(), tail.end());
  return last.size() <= parts.size() && std::equal(last.rbegin(), last.rend(), parts.rbegin());
}

/// Where a fit has this capture, whole or in spans. Captures of one name are told apart by their files, others are
/// not.
std::vector<std::size_t> places_in(const FitResult& fit, const Capture& capture,
                                   std::vector<std::string>& warnings) {
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < fit.captures.size(); ++k)
    if (fit.captures[k].whole == capture.id || fit.captures[k].id == capture.id) places.push_back(k);
  const auto file_of = [&](std::size_t k) { return fit.captures[k].file; };
  const auto are_of_one_file = [&](const std::vector<std::size_t>& of) {
    return std::ranges::adjacent_find(of, std::not_equal_to(), file_of) == of.end();
  };
  if (are_of_one_file(places)) return places;
  std::vector<std::size_t> same, alike;
  for (const std::size_t k : places) {
    if (is_same_file(file_of(k), capture.file)) same.push_back(k);
    if (ends_in(capture.file, file_of(k))) alike.push_back(k);
  }
  if (!same.empty()) return same;
  if (!alike.empty() && are_of_one_file(alike)) return alike;
  warnings.push_back(
      fmt::format("capture \"{}\": the fit has several of that name, none of which is known to be of \"{}\", "
                  "and is not shown beside it",
                  capture.id, capture.file));
  return {};
}

/// What the page shows of a capture.
struct ShownCapture {
  Capture capture;
  std::optional<std::size_t> place = {};  ///< in the fit
};

/// The windows of a capture that a fit saw, each with times from its own first frame, as spans() names and cuts them;
/// else the capture itself.
std::vector<ShownCapture> captures_of_fit(const Capture& capture, const std::optional<FitResult>& fit,
                                          std::vector<std::string>& warnings) {
  std::vector<ShownCapture> windows;
  std::optional<std::size_t> whole;
  if (fit) {
    for (const std::size_t place : places_in(*fit, capture, warnings)) {
      const CaptureFit& seen = fit->captures[place];
      if (seen.id == capture.id) whole = place;
      if (seen.id == capture.id || seen.times.size() == 0) continue;
      std::vector<Eigen::Index> begins;
      for (Eigen::Index i = 0; i < capture.times.size(); ++i)
        if (span_id(capture.id, capture.times[i]) == seen.id) begins.push_back(i);
      if (begins.size() != 1) {
        warnings.push_back(
            fmt::format("{} of the frames of capture \"{}\" may be the first of \"{}\" of the "
                        "fit, which is not shown",
                        begins.size(), capture.id, seen.id));
        continue;
      }
      const Eigen::VectorXd times = capture.times.array() - capture.times[begins[0]];
      const auto end = std::ranges::upper_bound(times, seen.times[seen.times.size() - 1] + 1e-9);
      const auto count = end - times.begin() - begins[0];
      Capture window = capture;
      window.id = seen.id;
      window.times = times.segment(begins[0], count);
      for (Channel& channel : window.channels)
        channel.values = channel.values.segment(begins[0], count).eval();
      windows.push_back({std::move(window), place});
    }
  }
  if (windows.empty()) windows.push_back({capture, whole});
  return windows;
}

/// What the fit knows of how captures were seen that the page leaves out, in words; empty for nothing.
std::string left_out_of(const FitResult& fit) {
  std::vector<std::string> parts;
  if (fit.setup.camera.scale) parts.emplace_back("the scale of a camera");
  if (fit.setup.camera.rotation) parts.emplace_back("the turn of a camera");
  if (fit.setup.compared.averaged_frames > 1)
    parts.push_back(fmt::format("frames that are means of {}", fit.setup.compared.averaged_frames));
  if (parts.empty()) return {};
  return fmt::format("the fit has {}: residuals on the page are without", fmt::join(parts, " and "));
}

/// Names of coordinates of the measurement with the values that the fit holds for all captures.
Json measurement_json(const FitResult& fit) {
  Json json = Json::object();
  const auto add = [&](const std::string& name, double value) {
    if (name == kDelay || name.starts_with("gain of ")) json[name] = value;
  };
  for (const auto* values : {&fit.fixed, &fit.setup.unknowns.fixed})
    for (const auto& [name, value] : *values) add(name, value);
  for (const Coefficient& c : fit.coefficients) add(c.name, c.value);
  return json;
}

Json fit_json_of(const FitResult& fit) {
  Json json = {{"message", fit.message},
               {"converged", fit.status == Termination::converged},
               {"leftOut", left_out_of(fit)},
               {"periods", fit.setup.compared.periods},
               {"measurement", measurement_json(fit)},
               {"coefficients", Json::array()},
               {"captures", Json::array()}};
  for (const Coefficient& c : fit.coefficients) {
    json["coefficients"].push_back({{"name", c.name}, {"unit", c.unit}, {"value", c.value}});
    json["coefficients"].back()["error"] = c.standard_error ? Json(*c.standard_error) : Json(nullptr);
  }
  for (const CaptureFit& capture : fit.captures) {
    Json own = capture.known;
    for (const Nuisance& nuisance : capture.nuisances) own[nuisance.name] = nuisance.value;
    json["captures"].push_back({{"id", capture.id}, {"start", capture.start}, {"own", own}});
  }
  return json;
}

}  // namespace

ExplorerPage explorer_page(const ExplorerContent& content) {
  check_content(content);
  check_size(content);
  ExplorerPage page;
  NumberStore numbers;
  Json data = {{"times", content.times},
               {"books", Json::array()},
               {"captures", Json::array()},
               {"fit", content.fit ? fit_json_of(*content.fit) : Json(nullptr)}};
  for (const ExploredBook& explored : content.books) {
    data["books"].push_back(
        explored_book(explored, outputs_to_show(explored.book, content.outputs), content.body, numbers));
    if (content.body && data["books"].back()["pose"].is_null())
      page.warnings.push_back(fmt::format(
          "{} moves no body with the outputs of the page, and the body is not drawn", explored.file));
  }
  if (content.fit && !content.captures.empty()) {
    const std::string sentence = left_out_of(*content.fit);
    if (!sentence.empty()) page.warnings.push_back(sentence);
  }
  for (const Capture& capture : content.captures) {
    const bool is_named_twice = std::ranges::count(content.captures, capture.id, &Capture::id) > 1;
    for (const ShownCapture& shown : captures_of_fit(capture, content.fit, page.warnings)) {
      Json json = capture_json(shown.capture, content, page.warnings);
      json["label"] =
          is_named_twice ? fmt::format("{}, {}", shown.capture.id, capture.file) : shown.capture.id;
      json["placeInFit"] = shown.place ? Json(*shown.place) : Json(nullptr);
      data["captures"].push_back(std::move(json));
    }
  }
  std::ranges::sort(page.warnings);
  page.warnings.erase(std::unique(page.warnings.begin(), page.warnings.end()), page.warnings.end());

  const codebooks::Codebook& first = content.books.front().book;
  const std::string name = first.title().empty() ? first.model().title : first.title();
  page.html =
      html_text({.title = name.empty() ? first.model().name : name,
                 .summary = fmt::format("A codebook of the model {}, to explore.", first.model().name),
                 .markup = page::kExplorerMarkup,
                 .data = {{"explored", data.dump(-1, ' ', false, Json::error_handler_t::replace)},
                          {"numbers", base64(numbers.values()), false}},
                 .styles = {page::kExplorerStyle},
                 .scripts = {page::kExplorerEvaluate, page::kExplorerBody, page::kExplorerGlb,
                             page::kExplorerState, page::kExplorerCurves, page::kExplorerControls,
                             page::kExplorerView, page::kExplorerPage}});
  return page;
}

}  // namespace samara::identification
