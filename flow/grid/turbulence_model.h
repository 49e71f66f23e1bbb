#pragma once

namespace samara::flow {

/// What is solved for the turbulence of the flow (turbulence/k_epsilon.h).
enum class TurbulenceModel { none, k_epsilon, kato_launder };

}  // namespace samara::flow
