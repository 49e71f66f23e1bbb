#include "samara/identification/pages/html_page.h"

#include <algorithm>

#include <fmt/format.h>

#include "page_parts.h"
#include "samara/base/errors.h"
#include "samara/base/text.h"

namespace samara::identification {

namespace {

/// JSON that no text inside can end as a script: "<" as an escape, which JSON reads as the same.
std::string for_script(const std::string& json) {
  std::string result;
  result.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      result += "\\u003c";
    } else {
      result += c;
    }
  }
  return result;
}

std::string element(const HtmlPage::Data& data) {
  if (data.is_json) {
    return fmt::format("<script type=\"application/json\" id=\"{}\">{}</script>\n", data.id,
                       for_script(data.text));
  }
  const bool is_harmless = std::ranges::all_of(data.text, [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '+' ||
           c == '/' || c == '=';
  });
  if (!is_harmless) throw ArgumentError(fmt::format("the data \"{}\" of a page are not base64", data.id));
  return fmt::format("<script type=\"text/plain\" id=\"{}\">{}</script>\n", data.id, data.text);
}

}  // namespace

std::string html_text(const HtmlPage& page) {
  const std::string title = escaped_for_markup(page.title);
  std::string text = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'">
<meta name="viewport" content="width=device-width, initial-scale=1">
)";
  text += fmt::format("<title>{}</title>\n<style>\n{}\n{}", title, page::kChartStyle, page::kStyle);
  for (const char* style : page.styles) text += style;
  text += fmt::format("</style>\n</head>\n<body>\n<header><h1>{}</h1></header>\n", title);
  text += fmt::format("<noscript><p>{}</p><p>The rest needs JavaScript.</p></noscript>\n",
                      escaped_for_markup(page.summary));
  text += page.markup;
  text += "<pre id=\"errors\" hidden></pre>\n";
  text += fmt::format("<!-- The charts are drawn by uPlot:\n{}-->\n", page::kChartLicence);
  for (const HtmlPage::Data& data : page.data) text += element(data);
  text += fmt::format("<script>{}</script>\n<script>\n{}", page::kChartLibrary, page::kKit);
  for (const char* script : page.scripts) text += script;
  text += "</script>\n</body>\n</html>\n";
  return text;
}

}  // namespace samara::identification
