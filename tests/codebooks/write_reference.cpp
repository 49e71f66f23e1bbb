/// Usage: write_reference BOOK.h5 REFERENCE.csv
/// Builds a small codebook and writes it, and its values at random points, for evaluate_codebook.py.
#include <vector>

#include "samara/codebooks/build.h"
#include "samara/codebooks/query.h"
#include "samara/codebooks/store.h"
#include "samara/io/csv.h"
#include "samara/pgd/random.h"

int main(int argc, char** argv) {
  using namespace samara;
  if (argc != 3) return 2;
  const codebooks::Plan plan = codebooks::parse_plan(
      "model = \"vertical_fall\"\n[fixed]\narea = 4.7e-4\nthickness = 2.5e-3\ndensity = 6300\n"
      "[box]\nC_D = [0.8, 1.6]\n\"v(0)\" = [-0.1, 0.4]\n[time]\nend = 0.4\n[tolerance]\nrelative = 1e-2\n",
      "plan");
  const codebooks::Codebook book = codebooks::build(plan, {.certificate_points = 20}).book;
  codebooks::save(book, argv[1]);
  codebooks::Query query(book);
  pgd::Random random(11);
  constexpr int kPoints = 50;
  Eigen::MatrixXd table(kPoints, book.coordinate_count() + book.output_count());
  Eigen::VectorXd values(book.output_count());
  std::vector<std::string> header;
  for (const codebooks::Coordinate& c : book.coordinates()) header.push_back(c.name);
  for (const pgd::OutputLabel& o : book.outputs()) header.push_back(o.name);
  for (int i = 0; i < kPoints; ++i) {
    std::vector<double> x;
    for (const codebooks::Coordinate& c : book.coordinates())
      x.push_back(c.lower + random.uniform() * (c.upper - c.lower));
    query.values(x, values);
    table.row(i) << Eigen::Map<const Eigen::RowVectorXd>(x.data(), book.coordinate_count()),
        values.transpose();
  }
  io::write_csv(argv[2], header, table);
  return 0;
}
