#include <catch2/catch.hpp>

#include "../allocation_counter.h"
#include "samara/codebooks/book/certificate_points.h"
#include "samara/codebooks/certify/certify_field.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "sample_books.h"

using namespace samara::codebooks;

namespace {

struct Load {
  int times;
  int rank;
};

/// One piece, several groups.
Codebook book_of_rank(int rank) {
  return Codebook(sample_model(), {random_piece({0.0, 1.0, 0.5, 1.0}, 1, rank)});
}

}  // namespace

TEST_CASE("the counter sees allocations") {
  CHECK(allocation_counter::during([] { Eigen::VectorXd::Ones(1000).eval(); }) > 0);
  CHECK(allocation_counter::during([] {}) == 0);
}

TEST_CASE("a query does not allocate after its construction") {
  for (const int rank : {1, 5, 30, 150, 1000}) {
    const Codebook book = book_of_rank(rank);
    Query query(book);
    Eigen::VectorXd values(3);
    Eigen::MatrixXd gradient(3, 3);
    const Eigen::MatrixXd points = random_points(book, 50, 1);
    CAPTURE(rank);
    CHECK(allocation_counter::during([&] {
            for (Eigen::Index j = 0; j < points.cols(); ++j) query.values(point(points, j), values);
          }) == 0);
    CHECK(allocation_counter::during([&] {
            for (Eigen::Index j = 0; j < points.cols(); ++j) query.values(point(points, j), values, gradient);
          }) == 0);
  }
}

TEST_CASE("queries of a train do not allocate after their construction") {
  for (const int rank : {1, 7, 60, 300}) {
    const Codebook book(sample_model(), {random_train_piece({0.0, 1.0, 0.5, 1.0}, 1, rank)});
    Query query(book);
    TrajectoryQuery trajectory(book, {0.0, 0.1, 0.5, 0.7, 1.0});
    Eigen::VectorXd values(3);
    Eigen::MatrixXd gradient(3, 3), rows(5, 3), derivatives(5, 6);
    const Eigen::MatrixXd points = random_points(book, 20, 1);
    CAPTURE(rank);
    CHECK(allocation_counter::during([&] {
            for (Eigen::Index j = 0; j < points.cols(); ++j) {
              query.values(point(points, j), values);
              query.values(point(points, j), values, gradient);
              trajectory.values(point(points, j).subspan(1), rows, derivatives);
            }
          }) == 0);
  }
}

TEST_CASE("a query of several pieces does not allocate after its construction") {
  const Codebook book = four_pieces();
  Query query(book);
  Eigen::VectorXd values(3);
  Eigen::MatrixXd gradient(3, 3);
  const Eigen::MatrixXd points = random_points(book, 50, 1);
  CHECK(allocation_counter::during([&] {
          for (Eigen::Index j = 0; j < points.cols(); ++j) query.values(point(points, j), values, gradient);
        }) == 0);
}

TEST_CASE("a trajectory query does not allocate after its construction, however large it is") {
  for (const Load& load : {Load{1, 5}, Load{60, 20}, Load{500, 60}, Load{3000, 150}, Load{20000, 20}}) {
    const Codebook book = book_of_rank(load.rank);
    std::vector<double> times;
    for (int i = 0; i < load.times; ++i) times.push_back((i + 0.5) / load.times);
    TrajectoryQuery query(book, times);
    Eigen::MatrixXd values(load.times, 3), derivatives(load.times, 6);
    const Eigen::MatrixXd points = random_points(book, 5, 1);
    CAPTURE(load.times, load.rank);
    CHECK(allocation_counter::during([&] {
            for (Eigen::Index j = 0; j < points.cols(); ++j)
              query.values(point(points, j).subspan(1), values);
          }) == 0);
    CHECK(allocation_counter::during([&] {
            for (Eigen::Index j = 0; j < points.cols(); ++j)
              query.values(point(points, j).subspan(1), values, derivatives);
          }) == 0);
  }
}

TEST_CASE("sources of one family share what is prepared for the same times, as long as one is used") {
  const Codebook book(sample_model(), {random_train_piece({0.0, 1.0, 0.5, 1.0}, 1, 60)});
  const auto family = codebook_trajectories(book);
  const std::vector<double> times = {0.0, 0.1, 0.5, 0.7, 1.0};
  std::vector<std::unique_ptr<samara::models::TrajectorySource>> sources;
  const auto make = [&] { sources.push_back(family->at(times, {"x", "v"})); };
  const long first = allocation_counter::during(make);
  const long second = allocation_counter::during(make);
  CHECK(3 * second < first);
  sources.clear();
  CHECK(allocation_counter::during(make) > 2 * second);

  // What they share they do not change.
  make();
  Eigen::MatrixXd one(5, 2), other(5, 2), by_one(5, 4), by_other(5, 4);
  const Eigen::MatrixXd points = random_points(book, 2, 1);
  REQUIRE(sources[0]->evaluate(point(points, 0).subspan(1), one, &by_one));
  CHECK(allocation_counter::during(
            [&] { sources[1]->evaluate(point(points, 1).subspan(1), other, &by_other); }) == 0);
  REQUIRE(sources[1]->evaluate(point(points, 0).subspan(1), other, &by_other));
  CHECK(one == other);
  CHECK(by_one == by_other);
}

namespace {

/// u = k t over many nodes of space and elements of time, exact to round-off.
Codebook field_over(int nodes, int elements) {
  using samara::pgd::Axis;
  using samara::pgd::AxisRole;
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, elements, 5);
  const Axis k = Axis::chebyshev({"k"}, 0.0, 1.0, 2);
  samara::pgd::SparseMatrix mass(nodes, nodes);
  mass.setIdentity();
  const Axis node = Axis::imported({"node", "1", AxisRole::space}, mass);
  const samara::pgd::SeparatedField field({t, node, k}, {{"u", "K"}},
                                          {t.nodes(), Eigen::VectorXd::Ones(nodes), k.nodes()},
                                          Eigen::MatrixXd::Ones(1, 1));
  ModelDescription model = sample_model();
  model.name = "a field";
  model.fixed.clear();
  return Codebook(model, {Piece{{field}}});
}

}  // namespace

TEST_CASE("the certificate of a field of 30,000 nodes holds blocks of it, however many times there are") {
  constexpr int kNodes = 30000;
  FieldReference reference;
  reference.name = "k t";
  reference.values = [](std::span<const double>, const std::vector<double>&, const Eigen::VectorXd&) {
    return Eigen::MatrixXd();  // never all at once
  };
  reference.time_by_time = [](std::span<const double> q, const std::vector<double>& times,
                              const Eigen::VectorXd& places, const FieldReference::Take& take) {
    Eigen::VectorXd values(places.size());
    for (std::size_t i = 0; i < times.size(); ++i) {
      values.setConstant(q[0] * times[i]);
      values[17] += i == 33 ? 0.25 : 0.0;
      take(i, values);
    }
  };
  CertifyOptions options;
  options.points = 1;
  options.tolerance = 1e-6;
  options.threads = 1;
  long long least = 0;
  for (const int elements : {4, 12}) {
    const Codebook book = field_over(kNodes, elements);
    const std::vector<double> times = certificate_times(book);
    Certificate certificate;
    const long long most =
        allocation_counter::most_bytes_during([&] { certificate = certify(book, reference, options); });
    const OutputError& error = certificate.outputs.front();
    CHECK(error.max_si == Approx(0.25));
    CHECK(error.worst[0] == times[33]);
    CHECK(error.worst[1] == 17.0);
    CHECK_FALSE(certificate.met);
    if (elements == 4) least = most;
    CAPTURE(times.size(), most);
    CHECK(times.size() > 8 * static_cast<std::size_t>(elements));
    // All times at once would be 8 bytes for each of them and of the nodes, several times over.
    if (elements == 12) CHECK(most < 8LL * kNodes * static_cast<long long>(times.size()));
    CHECK(most < least + least / 10);
  }
}
