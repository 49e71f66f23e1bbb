#pragma once

#include <string>
#include <string_view>

/// Units of files and of the command line. Everything inside Samara is in SI units; texts such as "1.5 mm" or
/// "kg/m^3" are converted once, here.
///
/// A unit is a product of symbols with whole exponents: `m/s`, `m s^-1`, `kg/m^3`, `kg m^2`, `W/(m K)`,
/// `1/s`. Factors are separated by a blank, `*` or a middle dot; exponents are written `m^2`, `m**2`, `m2` or
/// as superscripts. A product after a slash (`W/m K`) is refused as ambiguous: parentheses say what is meant.
///
/// Symbols: m, g, s, K, Hz, N, Pa, J, W, l or L, rad, bar (these take the SI prefixes from f to T), and
/// min, h, deg (or a degree sign), rev, rpm, %, in, ft, lb (inch, foot and pound as mass), px, frame, A, mol, cd, 1.
/// Angles are dimensionless (rad = 1, deg = pi/180, rev = 2 pi, rpm = 2 pi/60 s^-1); Hz is plainly 1/s, so "2 Hz"
/// given for rad/s means 2 rad/s. Pixels and video frames count as dimensions of their own, so that a length in px is
/// never taken for one in m. Degrees Celsius (degC, or a degree sign and C) have an offset: they may stand alone after
/// the number of a temperature, "20 degC", and nowhere else.
namespace samara {

/// Exponents of the base quantities.
struct Dimension {
  int metre = 0;
  int kilogram = 0;
  int second = 0;
  int kelvin = 0;
  int ampere = 0;
  int mole = 0;
  int candela = 0;
  int pixel = 0;
  int frame = 0;

  bool operator==(const Dimension&) const = default;
  bool is_dimensionless() const { return *this == Dimension{}; }
};

/// As a unit of SI symbols: "kg m^-3"; "1" if dimensionless.
std::string to_string(const Dimension& dimension);

/// One of the unit is coefficient 10^power_of_ten of the SI unit with the same dimension. The power of ten
/// stands apart because dividing by 1000 is exact where multiplying by 0.001 is not: 2.7 mm gives the
/// double 2.7e-3.
struct Unit {
  double coefficient = 1.0;
  int power_of_ten = 0;
  Dimension dimension;

  /// `value` of this unit, in SI.
  double to_si(double value) const;
  /// A value in SI, in this unit.
  double from_si(double value) const;
  /// Size of the unit in SI.
  double factor() const { return to_si(1.0); }
};

/// @throws ArgumentError if a symbol is unknown (the nearest known is named), or the text is malformed or
/// ambiguous.
Unit parse_unit(std::string_view text);

/// Whether the text is a unit whose size in SI is 1, such as N s/m or rad/s, and that holds neither pixels nor
/// video frames: numbers in such units may be put into an equation as they are.
bool is_coherent_si(std::string_view text);

/// @throws ArgumentError if either is not a unit.
bool same_dimension(std::string_view first_unit, std::string_view second_unit);

/// A number with its unit ("1.5 mm", "20 deg"), in SI. Only the dimension of `expected_unit` counts. The unit
/// may be left out only where `expected_unit` is dimensionless; "rad", "deg" and "1" stand for one another.
/// @throws ArgumentError naming the text if its number is malformed, not finite or too large, or its unit is
/// missing, unknown, or of another dimension.
double quantity_to_si(std::string_view text, std::string_view expected_unit);

/// The same of what lies between two values: an error, a deviation, a tolerance. @throws also for degrees Celsius
double difference_to_si(std::string_view text, std::string_view expected_unit);

}  // namespace samara
