#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

/// How numerical work ends. That it ends without what was asked for is no error: it is said in the result.
namespace samara {

/// One list for all work: marches, strategies, crosses, samples, builds, fits. Each function documents which values it
/// returns.
enum class Termination {
  converged,       ///< to the tolerance, as far as the work itself can tell
  missed,          ///< finished, but not to the tolerance
  not_resolved,    ///< nodes, ranks and cells are used up, and the solution still differs within a cell
  ceases,          ///< somewhere the solution grows beyond all bounds
  no_contraction,  ///< somewhere the equations of the shortest slab have no solution that was found
  diverged,        ///< corrections grow: no contraction on a slab of this length
  max_iterations,
  rank_limit,      ///< ranks or terms allowed do not suffice for the tolerance
  exhausted,       ///< ranks and nodes allowed to a sample are used up
  stagnated,       ///< much more work no longer lowered the error: a kink, a pole
  noise,           ///< values are not smooth enough for the tolerance
  refuted,         ///< new points found the field wrong again and again
  not_finite,      ///< a value is infinite or not a number; where is said beside
  sign_change,     ///< a denominator is zero or changes its sign; where is said beside
  failed,          ///< a function threw an exception or gave no answer
  not_determined,  ///< of a fit: the data do not tell the coefficients
  max_calls,       ///< no more evaluations, or calls, are allowed
  max_seconds,
  cancelled,
};

std::string to_string(Termination termination);

/// The one of this name; none: there is no such name.
std::optional<Termination> termination_of(std::string_view name);

/// Why there is no result.
struct Ending {
  Termination status = Termination::failed;
  std::string message;             ///< in one sentence
  std::vector<double> where = {};  ///< coordinates at which it ended; empty: not known
};

/// What work returns that may end without a result: the result, or why there is none.
template <class T>
class Outcome {
 public:
  Outcome(T result) : content_(std::move(result)) {}
  Outcome(Ending ending) : content_(std::move(ending)) {}

  explicit operator bool() const { return std::holds_alternative<T>(content_); }
  /// Only if there is one.
  T& operator*() { return std::get<T>(content_); }
  const T& operator*() const { return std::get<T>(content_); }
  T* operator->() { return &std::get<T>(content_); }
  const T* operator->() const { return &std::get<T>(content_); }
  /// Only if there is no result.
  const Ending& ending() const { return std::get<Ending>(content_); }

 private:
  std::variant<T, Ending> content_;
};

}  // namespace samara
