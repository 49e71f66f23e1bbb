#include "samara/identification/explorer/explorer_page.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "page_parts.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/explorer/explored_data.h"
#include "samara/identification/pages/base64.h"
#include "samara/identification/pages/html_page.h"

namespace samara::identification {

namespace {

using Json = nlohmann::ordered_json;

void check_content(const ExplorerContent& content) {
  if (content.books.empty()) throw ArgumentError("no codebook is given, expected at least one");
  if (content.times < 2 || content.times > 5000)
    throw ArgumentError(fmt::format("the number of times is {}, expected 2 to 5000", content.times));
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

Json fit_json_of(const FitResult& fit) {
  Json json = {{"message", fit.message},
               {"converged", fit.status == FitStatus::converged},
               {"coefficients", Json::array()},
               {"captures", Json::array()}};
  for (const Coefficient& c : fit.coefficients) {
    json["coefficients"].push_back({{"name", c.name}, {"unit", c.unit}, {"value", c.value}});
    json["coefficients"].back()["error"] = c.standard_error ? Json(*c.standard_error) : Json(nullptr);
  }
  for (const CaptureFit& capture : fit.captures) {
    Json own = Json::object();
    for (const Nuisance& nuisance : capture.nuisances) own[nuisance.name] = nuisance.value;
    json["captures"].push_back({{"id", capture.id}, {"own", own}});
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
  for (const ExploredBook& explored : content.books)
    data["books"].push_back(
        explored_book(explored, outputs_to_show(explored.book, content.outputs), content.body, numbers));
  for (const Capture& capture : content.captures)
    data["captures"].push_back(capture_json(capture, content, page.warnings));
  std::ranges::sort(page.warnings);
  page.warnings.erase(std::unique(page.warnings.begin(), page.warnings.end()), page.warnings.end());

  const codebooks::Codebook& first = content.books.front().book;
  const std::string name = first.title().empty() ? first.model().title : first.title();
  page.html = html_text(
      {.title = name.empty() ? first.model().name : name,
       .summary = fmt::format("A codebook of the model {}, to explore.", first.model().name),
       .markup = page::kExplorerMarkup,
       .data = {{"explored", data.dump()}, {"numbers", base64(numbers.values()), false}},
       .styles = {page::kExplorerStyle},
       .scripts = {page::kExplorerEvaluate, page::kExplorerBody, page::kExplorerGlb, page::kExplorerState,
                   page::kExplorerCurves, page::kExplorerControls, page::kExplorerPage}});
  return page;
}

}  // namespace samara::identification
