#pragma once

#include <optional>
#include <string>
#include <vector>

#include "samara/codebooks/book/codebook.h"
#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/models/bodies/triangle_mesh.h"

/// A page for the browser that evaluates codebooks: sliders over the box, curves with the band of the certificate,
/// captures and residuals, sensitivities, the body in motion. It is complete in one file and loads nothing.
namespace samara::identification {

struct ExploredBook {
  codebooks::Codebook book;
  std::string file;  ///< its name, for lines to copy
};

struct ExplorerContent {
  std::vector<ExploredBook> books;        ///< at least one
  std::vector<std::string> outputs = {};  ///< to carry; empty: all
  std::vector<Capture> captures = {};     ///< to show beside the curves
  std::optional<FitResult> fit = {};      ///< where sliders begin
  /// To draw [m]; none: what the parameters of the model say (models/bodies/shown_body.h).
  std::optional<models::TriangleMesh> body = {};
  int times = 200;  ///< at which curves are drawn
};

struct ExplorerPage {
  std::string html;
  std::vector<std::string> warnings;  ///< what was given and cannot be shown
};

/// The most that the factors of all codebooks in a page may have [bytes].
inline constexpr double kMostExplorerBytes = 20e6;

/// The most triangles of a body, which the page draws one by one.
inline constexpr int kMostExplorerTriangles = 5000;

/// @throws ArgumentError if there is no book, an output is unknown to all of them, the factors that the outputs need
///   exceed kMostExplorerBytes, the body has more than kMostExplorerTriangles, `times` is not from 2 to 5000, or the
///   fit is of another model; InputError where a file of a book turns out damaged.
ExplorerPage explorer_page(const ExplorerContent& content);

}  // namespace samara::identification
