#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "samara/models/wind/wind.h"
#include "samara/models/wind/wind_series.h"

/// Winds as text. Everything has a unit or is SI; all but the speed of [mean] may be left out.
///
///     [mean]
///     profile = "logarithmic"     # or "power" (exponent), "uniform" (no height)
///     speed = "4 m/s"
///     height = "10 m"             # of the speed
///     roughness = "3 cm"
///     displacement = "0 m"
///     towards = "0 deg"           # where it blows, from x to y
///
///     [turbulence]                # without it the wind is steady
///     kind = "modes"              # a field; "seen": the fluid along the path of each realisation (constants only)
///     height = "2 m"              # where the surface layer gives what is not here: that of the mean speed
///     sigma = "0.8 m/s"
///     length = "5 m"              # L of von Karman's spectrum; "iec": 0.8 Lambda of IEC 61400-1 at that height
///     constants = "kaimal"        # or "k-epsilon"
///     ratios = [1, 1, 1]          # deviations along, across, vertical over sigma
///     modes = 200
///     shortest = "8 cm"           # wave: the length of the body
///     longest = "3 km"            # 2 pi L/0.02
///     frozen = false
///
///     [[gusts]]
///     shape = "one_minus_cosine"  # or "step", "extreme_operating"
///     velocity = ["3 m/s", 0, 0]
///     start = "0.5 s"
///     duration = "1 s"
///     travel = ["4 m/s", 0, 0]    # everywhere at once
///
///     [series]                    # at points
///     spectrum = "iec"            # or "kaimal", which follows from the mean
///     sigma = "1.2 m/s"           # along the wind, of "iec"
namespace samara::codebooks {

/// The series that [series] describes; times and points are the caller's.
struct SeriesKind {
  models::wind::SeriesSpectrum spectrum = models::wind::SeriesSpectrum::iec;
  double sigma = 0.0;  ///< [m/s]; `iec` only
};

struct WindFile {
  models::wind::Wind wind;
  /// The surface layer, as the fluid that bodies see in it (fluid_seen.h), in place of a field of modes.
  std::optional<models::wind::EnergyConstants> seen = {};
  std::optional<SeriesKind> series = {};
};

/// @throws InputError at the key that is wrong
WindFile read_wind(const std::filesystem::path& path);

/// The same of a text. @param name of its file, in messages
WindFile parse_wind(std::string_view text, const std::string& name);

}  // namespace samara::codebooks
