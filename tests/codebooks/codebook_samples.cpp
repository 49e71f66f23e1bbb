// Writes sample codebooks.
//
//   codebook_samples reference DIRECTORY   codebooks, DIRECTORY/{pieces,trains,kinds,coin,command,mesh}.h5, each
//   with a table of
//                                          reference values beside it (.csv): coordinates, then outputs
//   codebook_samples flat DIRECTORY        the same but the coin as flat files, DIRECTORY/pieces.flat and so on
//   codebook_samples large FILE            two groups of factors of 12 MB each
//   codebook_samples golden FILE           the golden file of the present format version (golden_test.cpp);
//                                          made once per version, then kept for ever

#include <cstdio>
#include <filesystem>
#include <string>

#include "samara/codebooks/file/flat_file.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/io/atomic_file.h"
#include "samara/io/csv.h"
#include "sample_books.h"

namespace {

using namespace samara::codebooks;

/// Corners, borders of pieces and elements, and random points.
Eigen::MatrixXd reference_points(const Codebook& book) {
  const Eigen::MatrixXd random = random_points(book, 200, 11);
  Eigen::MatrixXd points(random.rows(), random.cols() + 8);
  points << random, random.leftCols(8);
  for (Eigen::Index corner = 0; corner < 8; ++corner) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      const auto& axes = book.pieces().front().groups().front().axes();
      const samara::pgd::Axis& axis = axes[static_cast<std::size_t>(k)];
      const bool upper = (corner >> k) % 2 != 0;
      points(k, random.cols() + corner) = upper ? axis.upper() : axis.lower();
    }
  }
  return points;
}

/// u and w, each a sum of 1,000 products that are all the same.
Codebook large_factors() {
  using samara::pgd::Axis;
  const std::vector<Axis> axes = {Axis::p1({"t", "s", samara::pgd::AxisRole::time}, 0.0, 1.0, 500),
                                  Axis::p1({"k", "1", samara::pgd::AxisRole::parameter}, 0.0, 1.0, 1000)};
  const std::vector<Eigen::MatrixXd> factors = {Eigen::MatrixXd::Ones(500, 1000),
                                                Eigen::MatrixXd::Ones(1000, 1000)};
  const Eigen::RowVectorXd weights = Eigen::RowVectorXd::Constant(1000, 1e-3);
  using samara::pgd::SeparatedField;
  return Codebook(sample_model(), {{{SeparatedField(axes, {{"u", "1"}}, factors, weights),
                                     SeparatedField(axes, {{"w", "1"}}, factors, weights)}}});
}

void write_reference(const Codebook& book, const std::filesystem::path& stem) {
  save(book, stem.string() + ".h5");
  const Eigen::MatrixXd points = reference_points(book);
  Eigen::MatrixXd table(points.cols(), book.coordinate_count() + book.output_count());
  std::vector<std::string> header;
  for (const Coordinate& c : book.coordinates()) header.push_back(c.name);
  for (const auto& output : book.outputs()) header.push_back(output.name);
  Query query(book);
  Eigen::VectorXd values(book.output_count());
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    query.values(point(points, j), values);
    table.row(j) << points.col(j).transpose(), values.transpose();
  }
  samara::io::write_text_atomically(stem.string() + ".csv", samara::io::format_csv(header, table));
}

}  // namespace

int main(int count, char** arguments) {
  const std::string verb = count == 3 ? arguments[1] : "";
  if (verb == "golden") {
    save(golden_front(), arguments[2]);
    return 0;
  }
  if (verb == "large") {
    save(large_factors(), arguments[2]);
    return 0;
  }
  if (verb == "reference") {
    const std::filesystem::path directory = arguments[2];
    write_reference(four_pieces(), directory / "pieces");
    write_reference(four_pieces_of_trains(), directory / "trains");
    write_reference(all_kinds(), directory / "kinds");
    write_reference(coin_build().book, directory / "coin");
    write_reference(golden_command(), directory / "command");
    write_reference(golden_mesh(), directory / "mesh");
    write_reference(golden_front(), directory / "front");
    return 0;
  }
  if (verb == "flat") {
    const std::filesystem::path directory = arguments[2];
    std::filesystem::create_directories(directory);
    save_flat(four_pieces(), directory / "pieces.flat");
    save_flat(four_pieces_of_trains(), directory / "trains.flat");
    save_flat(all_kinds(), directory / "kinds.flat");
    save_flat(golden_command(), directory / "command.flat");
    save_flat(golden_mesh(), directory / "mesh.flat");
    return 0;
  }
  std::fputs("usage: codebook_samples reference DIRECTORY | flat DIRECTORY | large FILE | golden FILE\n",
             stderr);
  return 2;
}
