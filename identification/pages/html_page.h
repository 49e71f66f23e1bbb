#pragma once

#include <string>
#include <vector>

namespace samara::identification {

/// What stands in a page beside the parts that all pages share (web/shared, uPlot).
struct HtmlPage {
  /// Data for the scripts: the text of an element <script id=".." type="application/json">, or of plain text.
  struct Data {
    std::string id;
    std::string text;
    bool is_json = true;
  };

  std::string title;                      ///< of the document, and its heading
  std::string summary;                    ///< for those who run no scripts
  std::string markup;                     ///< of the body, ours: where the scripts put what they show
  std::vector<Data> data = {};            ///< ours or of files: it is shut in
  std::vector<const char*> styles = {};   ///< after that of all pages
  std::vector<const char*> scripts = {};  ///< after uPlot and the kit
};

/// A page for the browser, complete in one file: it holds data, style, scripts and the library of charts (uPlot, MIT),
/// loads nothing, and forbids itself the network. Title and summary are shown as text, whatever they hold; no data can
/// end the element that it stands in.
/// @throws ArgumentError if plain data holds anything but letters, digits, "+", "/" and "=", as base64 has
std::string html_text(const HtmlPage& page);

}  // namespace samara::identification
