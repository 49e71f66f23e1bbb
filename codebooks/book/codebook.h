#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "samara/base/termination.h"
#include "samara/codebooks/book/certificate.h"
#include "samara/codebooks/book/field_group.h"
#include "samara/codebooks/book/front_map.h"
#include "samara/codebooks/book/space_mesh.h"

namespace samara::models {
class Model;
}

/// A codebook is the separated solution of a parametric model over time and a box of parameters and initial
/// values, or the separated form of what a program answers over a box of its inputs (and time, if it knows one),
/// or a field of space (and time, if it changes) over a box of parameters, with a certificate of its error.
/// Coordinates and outputs are in SI units.
///
/// Usage:
///   const Codebook book = load("coin.h5");
///   Query query(book);
///   Eigen::VectorXd values(book.output_count());
///   query.values({{0.3, 1.15, 0.0}}, values);        // t, C_D, v(0)
namespace samara::codebooks {

/// The name of the model of a codebook that was sampled from a program.
inline constexpr const char* kCommandModel = "command";

/// What the codebook is a solution of, enough to integrate it again; of a program, its call as "equations".
struct ModelDescription {
  std::string name;
  std::string title;
  std::string equations;  ///< as text
  std::string frames;     ///< in words
  std::string source;
  std::map<std::string, double> fixed;             ///< parameters and initial values the plan fixed, SI
  std::map<std::string, std::string> fixed_units;  ///< their units
  /// Of a model that is text: the codebook brings it along. Null of others, which go by their name.
  std::shared_ptr<const models::Model> of_text = {};
};

/// The model itself; null where this program does not know it.
std::shared_ptr<const models::Model> known_model(const ModelDescription& description);

/// How it was made: the only part that differs from build to build of the same plan.
struct Provenance {
  std::string generator;  ///< "samara 0.1.0"
  std::string plan;       ///< text of the plan
  std::string created;    ///< UTC, ISO 8601
  std::string host;
  double build_seconds = 0.0;
};

/// How the builder went; the same on every machine and after every resume.
struct BuildRecord {
  std::string builder;  ///< "pgd", "sampling", or "fit": of a series of coefficients
  /// One of pgd::strategy_names(); of sampling "cross" or "steps", and of flows "grid" or "modes"; of a fit "series";
  /// in older files also "newton".
  std::string strategy;
  Termination status = Termination::failed;
  std::string message;     ///< in one sentence
  double evaluations = 0;  ///< of the right-hand side and its Jacobian; of sampling: trajectories, or calls
  /// What a plain sweep over the parameter grid of the codebook would take, in the same measure, see
  /// codebooks/build/effort.h; of sampling the points of its grid. 0: not known.
  double grid_size = 0;
  int iterations = 0;  ///< most that a strategy took on a slab; of slabs and sampling: none
  int rounds = 0;      ///< of sampling; else marches
};

/// Axes and shapes of a piece, without the numbers of its groups.
struct PieceOutline {
  std::vector<pgd::Axis> axes;
  std::vector<GroupOutline> groups;
};

/// One time slab of one parameter cell: its own axes and field groups, all groups over the same axes. It may
/// stand for what a file holds, and be read when it is first asked for. Cheap to copy, safe to share between
/// threads.
class Piece {
 public:
  using Groups = std::vector<FieldGroup>;

  Piece() : Piece(Groups()) {}
  Piece(Groups groups);  // NOLINT(google-explicit-constructor): groups are a piece
  /// One of whose axes is counted from a front. @param front of points of all its axes
  /// @throws ArgumentError unless the front's intervals are those of parameters among its axes, the
  ///   counted one of elements or a polynomial
  Piece(Groups groups, FrontMap front);
  /// @param lower,upper of the box, coordinate by coordinate
  /// @param read called once, when the groups are first asked for; what it throws passes to the caller, and
  ///   the next call tries again
  /// @param outline called as long as the groups are not read
  Piece(std::vector<double> lower, std::vector<double> upper, std::function<Groups()> read,
        std::function<PieceOutline()> outline);

  const Groups& groups() const;
  /// Reads no more than it has to.
  PieceOutline outline() const;
  /// Whether the groups are there without reading.
  bool is_read() const;
  /// Ends of the box, in the order of the axes.
  const std::vector<double>& lower() const;
  const std::vector<double>& upper() const;
  /// From which one of its axes is counted; else null. The axes of its groups hold what FrontMap::to_axis() says.
  const FrontMap* front() const;

 private:
  struct Content;
  std::shared_ptr<Content> content_;
};

/// One coordinate of the whole codebook: time first, if it has time, then parameters and initial values.
struct Coordinate {
  std::string name;
  std::string unit;
  pgd::AxisRole role = pgd::AxisRole::parameter;
  double lower = 0.0;
  double upper = 0.0;
};

/// The whole: pieces that each answer in a part of the box, with what is known of how they came about. Does not change
/// once it is made; cheap to copy, as copies share their pieces, and safe to share between threads.
class Codebook {
 public:
  /// Keeps the pieces in the order of their lower corners.
  /// @throws ArgumentError if there is no piece, or more than one where one has a front, pieces differ in their
  /// coordinates or outputs, groups of a piece in their axes, two outputs have one name, or time is not first or not
  /// made of elements, or missing where the codebook is one of a model and has no coordinate of space either. Of
  /// pieces that are not read yet the first is looked at in outline, others are not: see check_piece().
  Codebook(ModelDescription model, std::vector<Piece> pieces, BuildRecord build = {},
           Provenance provenance = {}, std::optional<Certificate> certificate = {}, std::string title = {});

  const std::vector<Coordinate>& coordinates() const { return coordinates_; }
  const std::vector<pgd::OutputLabel>& outputs() const { return outputs_; }
  int coordinate_count() const { return static_cast<int>(coordinates_.size()); }
  int output_count() const { return static_cast<int>(outputs_.size()); }
  /// Whether the first coordinate is time; if not, there is none.
  bool has_time() const { return coordinates_.front().role == pgd::AxisRole::time; }
  /// Time. @throws ArgumentError if there is none, saying that `what` needs it.
  const Coordinate& time(const char* what) const;
  /// The coordinates that are not time.
  std::span<const Coordinate> parameters() const {
    return std::span(coordinates_).subspan(has_time() ? 1 : 0);
  }
  /// The place of the coordinate of space among coordinates(); empty if there is none, or more than one.
  std::optional<int> space() const;
  /// The nodes of that coordinate in space, where it numbers the nodes of a mesh and the mesh is known; else null.
  const SpaceMesh* mesh() const { return mesh_.get(); }
  /// From which one of its coordinates is counted inside its only piece; else null. Queries do not show it.
  const FrontMap* front() const { return pieces_.front().front(); }
  /// Whether a program was sampled, not a model solved.
  bool is_of_command() const { return model_.name == kCommandModel; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  const ModelDescription& model() const { return model_; }
  const BuildRecord& build() const { return build_; }
  const Provenance& provenance() const { return provenance_; }
  const std::optional<Certificate>& certificate() const { return certificate_; }
  const std::string& title() const { return title_; }

  /// The place of a name among coordinates(), and among outputs(), which are stored: not of derived_outputs().
  /// @throws ArgumentError with the nearest known name.
  int coordinate_index(const std::string& name) const;
  int output_index(const std::string& name) const;

  /// Whether a piece has coordinates and outputs like this codebook.
  /// @throws ArgumentError as the constructor
  void check_piece(const Piece& piece) const;

  /// The same codebook with another certificate.
  Codebook with_certificate(Certificate certificate) const;
  /// The same codebook with the mesh whose nodes its coordinate of space numbers.
  /// @throws ArgumentError if there is no such coordinate, or it has another number of nodes
  Codebook with_mesh(SpaceMesh mesh) const;

 private:
  ModelDescription model_;
  std::vector<Piece> pieces_;
  BuildRecord build_;
  Provenance provenance_;
  std::optional<Certificate> certificate_;
  std::string title_;
  std::vector<Coordinate> coordinates_;
  std::vector<pgd::OutputLabel> outputs_;
  std::shared_ptr<const SpaceMesh> mesh_;
};

/// What the model derives from its states (models::ModelInfo::outputs), where it is known and the codebook holds all of
/// them; else none.
std::vector<pgd::OutputLabel> derived_outputs(const Codebook& book);

}  // namespace samara::codebooks
