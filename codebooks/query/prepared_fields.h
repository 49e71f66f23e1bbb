#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <variant>
#include <vector>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/book/front_map.h"
#include "samara/codebooks/book/piece_finder.h"
#include "samara/codebooks/query/kernels/packed_field.h"

namespace samara::codebooks {

/// The fields of all pieces of a codebook, reduced to one choice of outputs and times, ready for the kernels:
/// some rows (outputs, or outputs at times), as functions of the coordinates that are left free. Shared
/// between queries; nothing changes but that pieces of a large file are read and packed when a point falls
/// into them, once.
class PreparedFields {
 public:
  /// What is asked.
  struct Choice {
    std::vector<int> outputs;                  ///< places in the codebook, in the order wanted
    std::optional<std::vector<double>> times;  ///< rows are outputs at times, times running fastest
    std::vector<std::optional<double>> fixed;  ///< per coordinate
    bool single = false;                       ///< single floats
  };
  PreparedFields(const Codebook& book, const Choice& choice);

  int rows() const { return rows_; }
  const std::vector<Coordinate>& coordinates() const { return coordinates_; }
  int coordinate_count() const { return static_cast<int>(coordinates_.size()); }
  /// Ranks or terms in front of the first coordinate, where rows stand before it; the most of all pieces.
  int inner_size() const;
  int piece_count() const { return static_cast<int>(pieces_.size()); }
  const PieceFinder& finder() const { return *finder_; }
  /// Whether every piece holds all points: then it needs no look.
  bool all_hold_the_box() const { return all_hold_the_box_; }
  /// Places of the times that a piece answers for.
  const std::vector<int>& times_of(int piece) const;

  /// Whether every axis of every piece has one element only.
  bool has_one_cell() const { return has_one_cell_; }

  /// Coordinates of the fields themselves: the free ones, and with a front (front_map.h) the one that is counted from
  /// it.
  int axis_count() const { return static_cast<int>(axis_places_.size()); }
  /// The point of the axes for a free point: itself, or where there is a front what is written to `axis_point`, of
  /// axis_point_size() numbers.
  const double* on_axes(const double* x, double* axis_point) const {
    return front_ ? map_to_axes(x, axis_point) : x;
  }
  std::size_t axis_point_size() const { return axis_places_.size() + held_.size(); }
  /// Number of the element of an axis in a piece: points that share all elements may go in one block.
  /// @param x on the axis
  int cell(int piece, int axis, double x) const;

  /// Scratch space of one thread.
  struct Workspace {
    using Part =
        std::variant<kernels::PackedField<double>::Workspace, kernels::PackedField<float>::Workspace>;
    struct Piece {
      bool is_made = false;
      std::vector<Part> parts;
    };
    std::vector<Piece> pieces;
    std::vector<double*> columns;
    std::ptrdiff_t lead = 0;  ///< of rows
    kernels::Buffer<double> rows;
    // Of a field with a front: a point, and the rows with their derivatives along axes.
    std::vector<double> axis_point;
    Eigen::MatrixXd on_axes;
    std::vector<double*> axis_columns;
  };
  Workspace make_workspace() const;

  /// Writes the rows of a piece that holds x into columns of all rows: the values, then derivatives, as
  /// PackedField::point says. A piece that was not read before is read, and packed: this allocates.
  /// @throws InputError if it is damaged
  void point(int piece, const double* x, int order, Workspace& workspace, double* const* columns) const;

  /// Points of one block, in one element of every axis. @param x on the axes, axis by axis, points running
  /// fastest
  /// @param columns per point, of all rows; null ones are left out
  void block(int piece, const double* x, Workspace& workspace, double* const* columns) const;
  int block_size() const;

 private:
  /// Rows that follow each other, in the field and among all.
  struct Stretch {
    int from = 0;
    int to = 0;
    int count = 0;
  };
  using Packed = std::variant<kernels::PackedField<double>, kernels::PackedField<float>>;
  struct Part {
    Packed packed;
    int rows = 0;
    std::vector<Stretch> stretches;
  };
  struct Prepared {
    codebooks::Piece source;
    std::vector<int> times;  ///< places of those it holds
    std::once_flag once;
    std::atomic<bool> is_ready = false;  ///< a look at it is cheaper than one at `once`
    std::vector<Part> parts;
  };

  bool is_free(std::size_t k) const { return !choice_.fixed[k] && !(k == 0 && choice_.times); }
  PieceFinder::Box box_of(const codebooks::Piece& piece, bool by_box) const;
  bool is_whole_box(const PieceFinder::Box& box) const;
  void look_at(int piece);
  const Prepared& at(int piece) const;
  void prepare(Prepared& prepared) const;
  Workspace::Piece& scratch(int piece, Workspace& workspace) const;
  void point_on_axes(int piece, const double* x, int order, Workspace& workspace,
                     double* const* columns) const;
  const double* map_to_axes(const double* x, double* axis_point) const;
  void chain(int order, const Workspace& workspace, double* const* columns) const;
  template <class Run>
  void in_rows(const std::vector<Stretch>& stretches, int columns, double* const* target,
               Workspace& workspace, const Run& run) const;

  Choice choice_;
  int rows_ = 0;
  bool all_hold_the_box_ = true;
  bool has_one_cell_ = true;
  std::vector<Coordinate> coordinates_;
  std::vector<int> free_places_, axis_places_;  ///< of free coordinates and of axes, in the codebook
  std::optional<FrontMap> front_;               ///< of points of the codebook
  std::vector<double> held_;                    ///< a point of the codebook, where free coordinates are 0
  std::vector<std::unique_ptr<Prepared>> pieces_;
  std::optional<PieceFinder> finder_;
};

/// Splits points into blocks of one piece and element and answers them; what a batch does in one thread.
class BatchRun {
 public:
  explicit BatchRun(const PreparedFields& fields);

  /// A point to answer, and the piece that does.
  struct Place {
    int piece = 0;
    int point = 0;
  };
  std::vector<Place>& places() { return places_; }
  /// Answers places(), and sorts them: column `point` of values (rows x points, leading dimension `lead`).
  void run(const double* points, PreparedFields::Workspace& workspace, double* values, std::ptrdiff_t lead);

 private:
  bool same_cell(const Place& a, const Place& b) const;
  bool before(const Place& a, const Place& b) const;
  void answer(const Place* first, const Place* last, const double* points,
              PreparedFields::Workspace& workspace, double* values, std::ptrdiff_t lead);
  const double* on_axes(const double* points, const Place& place) {
    return fields_.on_axes(points + std::ptrdiff_t{place.point} * fields_.coordinate_count(),
                           axis_point_.data());
  }

  const PreparedFields& fields_;
  std::vector<Place> places_;
  std::vector<int> cells_;  ///< axes x points
  std::vector<double*> columns_;
  kernels::Buffer<double> x_;
  std::vector<double> axis_point_;
};

/// Points of a chunk of a batch: places are sorted within it.
inline constexpr int kBatchChunk = 512;

}  // namespace samara::codebooks
