#include "samara/identification/report/fit_page.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "page_parts.h"
#include "samara/identification/pages/html_page.h"
#include "samara/identification/report/fit_report.h"

namespace samara::identification {

std::string fit_html(const FitResult& result) {
  const std::string data = nlohmann::ordered_json::parse(fit_json(result)).dump();
  return html_text({.title = fmt::format("Fit of {}", result.model),
                    .summary = result.message,
                    .markup = "<main id=\"report\"></main>\n",
                    .data = {{"fit", data}},
                    .scripts = {page::kFitPosterior, page::kFitPage}});
}

}  // namespace samara::identification
