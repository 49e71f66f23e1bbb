#include "samara/identification/captures/exports/export_formats.h"

#include "samara/identification/captures/exports/export_lines.h"
#include "samara/identification/captures/exports/kinovea_export.h"
#include "samara/identification/captures/exports/motive_export.h"
#include "samara/identification/captures/exports/tracker_export.h"

namespace samara::identification {

namespace {

/// Its first lines: most files are plain tables, and long.
std::string_view head_of(std::string_view text) {
  constexpr int kLines = 3;
  std::size_t end = 0;
  for (int k = 0; k < kLines && end != std::string_view::npos; ++k)
    end = text.find('\n', end + (k > 0 ? 1 : 0));
  return text.substr(0, end);
}

}  // namespace

std::optional<Export> read_export(std::string_view text, const ExportHints& hints) {
  const std::vector<std::string> head = lines_of(head_of(text));
  if (is_motive_export(head)) return read_motive_export(lines_of(text), hints);
  if (is_kinovea_export(head)) return read_kinovea_export(lines_of(text), hints);
  if (is_tracker_export(head)) return read_tracker_export(lines_of(text), hints);
  return std::nullopt;
}

}  // namespace samara::identification
