#include "samara/identification/trajectories/codebook_trajectories.h"

#include <algorithm>
#include <optional>

#include "samara/base/errors.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/identification/trajectories/model_symmetry.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"

namespace samara::identification {

namespace {

/// Empty if the model is not one of Samara's, or has other coordinates than the codebook.
std::optional<models::ParametricModel> equations_of(const codebooks::Codebook& book) {
  const std::vector<std::string> models = models::model_names();
  if (std::ranges::count(models, book.model().name) == 0) return {};
  try {
    return codebooks::model_of(book);
  } catch (const ArgumentError&) {
    return {};
  }
}

FamilyInfo describe(const codebooks::Codebook& book,
                    const std::optional<models::ParametricModel>& equations) {
  FamilyInfo info{.model = book.model().name, .source = "codebook", .fixed = book.model().fixed};
  const auto& coordinates = book.coordinates();
  info.end_time = book.time("a fit").upper;
  for (std::size_t k = 1; k < coordinates.size(); ++k) {
    const codebooks::Coordinate& c = coordinates[k];
    info.coordinates.push_back({c.name, c.unit, c.role == pgd::AxisRole::initial, c.lower, c.upper});
  }
  for (const pgd::OutputLabel& output : book.outputs()) info.outputs.push_back({output.name, output.unit});
  const std::vector<std::string> models = models::model_names();
  if (equations) {
    describe_equations(*equations, info);
  } else if (std::ranges::count(models, info.model) > 0) {
    info.translations = translated_outputs(models::find_model(info.model)->info(), info.outputs);
  }
  return info;
}

class CodebookSource final : public TrajectorySource {
 public:
  CodebookSource(const codebooks::Codebook& book, const std::vector<double>& times,
                 const std::vector<std::string>& outputs)
      : query_(book, times, outputs) {}

  bool evaluate(std::span<const double> q, Eigen::MatrixXd& values, Eigen::MatrixXd* derivatives) override {
    try {
      if (derivatives) {
        query_.values(q, values, *derivatives);
      } else {
        query_.values(q, values);
      }
    } catch (const OutsideBoxError&) {
      return false;  // an attitude moves on the sphere, not in a box
    }
    return true;
  }

 private:
  codebooks::TrajectoryQuery query_;
};

class CodebookTrajectories final : public TrajectoryFamily {
 public:
  explicit CodebookTrajectories(const codebooks::Codebook& book)
      : book_(book), equations_(equations_of(book)), info_(describe(book, equations_)) {}

  const FamilyInfo& info() const override { return info_; }
  const models::ParametricModel* equations() const override { return equations_ ? &*equations_ : nullptr; }

  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    return std::make_unique<CodebookSource>(book_, times, outputs);
  }

 private:
  const codebooks::Codebook& book_;
  std::optional<models::ParametricModel> equations_;
  FamilyInfo info_;
};

}  // namespace

std::unique_ptr<TrajectoryFamily> codebook_trajectories(const codebooks::Codebook& book) {
  return std::make_unique<CodebookTrajectories>(book);
}

}  // namespace samara::identification
