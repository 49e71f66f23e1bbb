// The norm of stored quaternions, which certificates measure before queries mend it.
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "damaged_codebook.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/pgd/tensors/tensor_train.h"
#include "same_codebook.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using samara::pgd::TrainField;

namespace {

constexpr double kTolerance = 1e-3;

/// A bottom-heavy body that starts on its side and swings upright in a second. The quaternion begins with
/// the length 2: defects are relative.
/// @param free the rest of the fixed values, and the box
Plan swing(const std::string& free) {
  return parse_plan(R"toml(model = "kirchhoff_body"
[fixed]
mass = 1.0
I_xx = 0.4
I_yy = 0.6
I_zz = 0.9
r_cz = -0.05
K_11 = 0.1
K_22 = 0.2
K_33 = 0.6
"qw(0)" = 1.6
"wy(0)" = 1.5
)toml" + free + R"toml(
[time]
end = 1.0
[tolerance]
relative = 1e-3
[builder]
kind = "sampling"
)toml",
                    "swing.toml");
}

const Codebook& body() {
  static const Codebook book =
      build(swing("\"qx(0)\" = 1.2\n[box]\ndisplaced_mass = [0.8, 0.95]\n\"wx(0)\" = [0.5, 1.5]"),
            {.certificate_points = 100})
          .book;
  return book;
}

/// The same with ranks cut until the error is `error` of the train's norm.
Codebook cut(const Codebook& book, double error) {
  const TrainField& whole = *book.pieces().front().groups().front().train();
  samara::pgd::TensorTrain train = rounded(whole.train(), error * norm(whole.train()));
  return Codebook(book.model(), {Piece{{TrainField(whole.axes(), whole.outputs(), std::move(train))}}},
                  book.build(), book.provenance());
}

Certificate measured(const Codebook& book) {
  return certify(book, model_of(book), {.points = 100, .tolerance = kTolerance});
}

}  // namespace

TEST_CASE("a body's codebook stores quaternions whose norm is off by less than its certified error") {
  REQUIRE(body().certificate()->met);
  const std::optional<NormDefect>& defect = body().certificate()->norm_defect;
  REQUIRE(defect.has_value());
  CHECK(defect->max < body().certificate()->max_error);
  CHECK(defect->rms < defect->max);
  CHECK(defect->rms > 0.0);
}

TEST_CASE("a body's codebook of few terms has a norm that gives it away") {
  const Certificate certificate = measured(cut(body(), 0.1));
  CHECK_FALSE(certificate.met);
  REQUIRE(certificate.norm_defect.has_value());
  CHECK(certificate.norm_defect->max > 10.0 * kTolerance);
  CHECK(certificate.norm_defect->max > 10.0 * body().certificate()->norm_defect->max);
}

TEST_CASE("the norm's defect is that of the numbers as they are stored") {
  const Codebook rough = cut(body(), 0.1);
  const std::vector<double> q = {0.9, 0.7};
  const auto norms = [&](bool as_stored) -> Eigen::VectorXd {
    TrajectoryQuery query(rough, {0.0, 0.4, 0.8},
                          QueryOptions{.outputs = {"qw", "qx", "qy", "qz"}, .as_stored = as_stored});
    Eigen::MatrixXd values(3, 4);
    query.values(q, values);
    return values.rowwise().norm();
  };
  CHECK((norms(false).array() - 2.0).abs().maxCoeff() < 1e-14);
  const double defect = (norms(true).array() / 2.0 - 1.0).abs().maxCoeff();
  CHECK(defect > kTolerance);
  CHECK(defect < 2.0 * measured(rough).norm_defect->max);
}

TEST_CASE("where attitudes begin anywhere, the norm is compared with that of the beginning") {
  const BuildResult window =
      build(swing("[box]\n\"qx(0)\" = [0.6, 1.4]\n\"wx(0)\" = [0.5, 1.5]"), {.certificate_points = 100});
  INFO(window.message);
  REQUIRE(window.book.certificate()->norm_defect.has_value());
  // Norms of the beginning go from 1.7 to 2.1.
  CHECK(window.book.certificate()->norm_defect->max < 2.0 * window.book.certificate()->max_error);
}

TEST_CASE("a codebook without a whole quaternion has no such defect") {
  CHECK_FALSE(coin_build().book.certificate()->norm_defect.has_value());
}

TEST_CASE("the norm's defect is kept in the file, and files without it are read") {
  const TemporaryDirectory directory;
  save(body(), directory / "body.h5");
  check_same_codebook(load(directory / "body.h5"), body());
  Certificate certificate = *body().certificate();
  certificate.norm_defect.reset();
  const Codebook without = body().with_certificate(certificate);
  save(without, directory / "without.h5");
  check_same_codebook(load(directory / "without.h5"), without);
}

TEST_CASE("a norm's defect that is no number, or a half of it, is refused") {
  using damaged_codebook::error_after, damaged_codebook::Patient;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const char* name : {"norm_defect_max", "norm_defect_rms"}) {
    CHECK_THAT(error_after([&](Patient& file) { file.set_number("/certificate", name, nan); }, body()),
               Contains("/certificate: ") && Contains(name) && Contains("is nan"));
    CHECK_THAT(error_after([&](Patient& file) { file.remove_attribute("/certificate", name); }, body()),
               Contains("/certificate") && Contains(name));
  }
}
