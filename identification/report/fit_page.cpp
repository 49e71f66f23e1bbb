#include "samara/identification/report/fit_page.h"

#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "page_parts.h"
#include "samara/base/text.h"
#include "samara/identification/report/fit_report.h"

namespace samara::identification {

namespace {

/// JSON that no text inside can end as a script: "<" as an escape, which JSON reads as the same.
std::string for_script(const std::string& json) {
  std::string result;
  for (const char c : json) {
    if (c == '<') {
      result += "\\u003c";
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace

std::string fit_html(const FitResult& result) {
  const std::string data = nlohmann::ordered_json::parse(fit_json(result)).dump();
  std::string page = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
)";
  page += fmt::format("<title>Fit of {}</title>\n", escaped_for_markup(result.model));
  page += fmt::format("<style>\n{}\n{}</style>\n</head>\n<body>\n", page::kChartStyle, page::kStyle);
  page += fmt::format("<h1>Fit of {}</h1>\n<noscript><p>{}</p><p>The rest needs JavaScript.</p></noscript>\n",
                      escaped_for_markup(result.model), escaped_for_markup(result.message));
  page += "<main id=\"report\"></main>\n<pre id=\"errors\" hidden></pre>\n";
  page += fmt::format("<!-- The charts are drawn by uPlot:\n{}-->\n", page::kChartLicence);
  page += fmt::format("<script type=\"application/json\" id=\"fit\">{}</script>\n", for_script(data));
  page += fmt::format("<script>{}</script>\n<script>\n{}{}</script>\n</body>\n</html>\n", page::kChartScript,
                      page::kPosteriorScript, page::kScript);
  return page;
}

}  // namespace samara::identification
