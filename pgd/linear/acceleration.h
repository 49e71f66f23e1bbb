#pragma once

namespace samara::pgd {

/// How the iterates of the fixed point are extrapolated.
enum class Acceleration {
  none,
  /// Vector Aitken steps on the factors of all modes together (Irons and Tuck 1969), between 1 and 8.
  aitken,
};

}  // namespace samara::pgd
