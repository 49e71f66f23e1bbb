#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "book.h"
#include "calls.h"
#include "python_model.h"
#include "rooms.h"
#include "samara/base/errors.h"
#include "samara/codebooks/book/book_slice.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/builder_end.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/codebooks/query/derived_query.h"
#include "samara/codebooks/statistics/book_statistics.h"
#include "samara/io/text_file.h"
#include "samara/models/added_mass/body_in_fluid.h"

namespace samara::python {

namespace {

using codebooks::Codebook;
using Names = std::vector<std::string>;
using Held = std::map<std::string, double>;

/// Below it, threads cost more than they give.
constexpr py::ssize_t kLeastPerThreads = 4096;

codebooks::Precision precision_of(const std::string& name) {
  if (name == "double") return codebooks::Precision::double_precision;
  if (name == "single") return codebooks::Precision::single_precision;
  if (name == "auto") return codebooks::Precision::automatic;
  throw ArgumentError(fmt::format("precision is \"{}\", expected \"double\", \"single\" or \"auto\"", name));
}

int threads_for(const std::optional<int>& threads, py::ssize_t values) {
  return threads.value_or(values >= kLeastPerThreads ? 0 : 1);
}

Shape joined(Shape shape, std::initializer_list<py::ssize_t> more) {
  shape.insert(shape.end(), more);
  return shape;
}

py::ssize_t product(const Shape& shape) {
  py::ssize_t count = 1;
  for (const py::ssize_t size : shape) count *= size;
  return count;
}

/// Whether one of the names is of no stored output, and may be of one that the model derives.
bool asks_for_derived(const Codebook& book, const Names& outputs) {
  return std::ranges::any_of(outputs, [&](const std::string& name) {
    return std::ranges::find(book.outputs(), name, &pgd::OutputLabel::name) == book.outputs().end();
  });
}

/// As at(), of outputs that are derived, too; each call prepares them.
py::object derived_at(const Book& book, const Array& points, const codebooks::QueryOptions& options,
                      int order, const py::object& out) {
  codebooks::DerivedQuery query(*book, options);
  if (order > 1)
    throw ArgumentError("hessian is of stored outputs; outputs without what the model derives were expected");
  const auto d = static_cast<py::ssize_t>(query.coordinates().size());
  const auto m = static_cast<py::ssize_t>(query.outputs().size());
  const Shape leading = leading_shape(points, d, "points");
  py::array_t<double> values = room_for(joined(leading, {m}), out);
  py::array_t<double> gradients(order > 0 ? joined(leading, {d, m}) : Shape{0});
  const double* const from = points.data();
  double* const to = values.mutable_data();
  double* const slopes = gradients.mutable_data();
  {
    const py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < product(leading); ++i) {
      const std::span<const double> x(from + i * d, static_cast<std::size_t>(d));
      Eigen::Map<Eigen::VectorXd> y(to + i * m, m);
      if (order == 0) {
        query.values(x, y);
      } else {
        query.values(x, y, Eigen::Map<Eigen::MatrixXd>(slopes + i * m * d, m, d));
      }
    }
  }
  if (order == 0) return values;
  return py::make_tuple(values, gradients);
}

/// Points (.., coordinates) to values (.., outputs), with gradients (.., coordinates, outputs) and second derivatives
/// (.., coordinates, coordinates, outputs) as far as `order` asks for them.
py::object at(const Book& book, const Array& points, const Names& outputs, const Held& held,
              const std::string& precision, int order, const py::object& out,
              const std::optional<int>& threads) {
  const Choice choice{outputs, held, precision_of(precision)};
  if (asks_for_derived(*book, outputs)) return derived_at(book, points, choice.options(), order, out);
  auto query = book.query(choice);
  const auto d = static_cast<py::ssize_t>(query->coordinates().size());
  const py::ssize_t m = query->output_count();
  const Shape leading = leading_shape(points, d, "points");
  const py::ssize_t count = product(leading);
  py::array_t<double> values = room_for(joined(leading, {m}), out);
  py::array_t<double> gradients(order > 0 ? joined(leading, {d, m}) : Shape{0});
  py::array_t<double> hessians(order > 1 ? joined(leading, {d, d, m}) : Shape{0});
  const double* const from = points.data();
  double* const to = values.mutable_data();
  double* const slopes = gradients.mutable_data();
  double* const bends = hessians.mutable_data();
  {
    const py::gil_scoped_release release;
    const ConstColumns x(from, d, count);
    Columns y(to, m, count);
    const int used = threads_for(threads, count * m);
    if (order == 0 && count == 1) {
      query->values({from, static_cast<std::size_t>(d)}, Eigen::Map<Eigen::VectorXd>(to, m));
    } else if (order == 0) {
      query->batch(x, y, used);
    } else if (order == 1) {
      query->batch(x, y, Columns(slopes, m * d, count), used);
    } else {
      query->batch(x, y, Columns(slopes, m * d, count), Columns(bends, m * d * d, count), used);
    }
  }
  if (order == 0) return values;
  if (order == 1) return py::make_tuple(values, gradients);
  return py::make_tuple(values, gradients, hessians);
}

/// Parameters (.., parameters) to values (.., outputs, times), and with a gradient (.., parameters, outputs, times).
py::object trajectories(const Book& book, const Array& parameters, const Array& times, const Names& outputs,
                        const Held& held, const std::string& precision, bool gradient, const py::object& out,
                        const std::optional<int>& threads) {
  auto query = book.query(Book::Frames{{times.data(), times.data() + times.size()},
                                       Choice{outputs, held, precision_of(precision)}});
  const py::ssize_t d = query->parameter_count(), m = query->output_count(), t = query->time_count();
  const Shape leading = leading_shape(parameters, d, "parameters");
  const py::ssize_t count = product(leading);
  py::array_t<double> values = room_for(joined(leading, {m, t}), out);
  py::array_t<double> slopes(gradient ? joined(leading, {d, m, t}) : Shape{0});
  const double* const from = parameters.data();
  double* const to = values.mutable_data();
  double* const derivatives = slopes.mutable_data();
  {
    const py::gil_scoped_release release;
    const ConstColumns q(from, d, count);
    Columns y(to, m * t, count);
    const int used = threads_for(threads, count * m * t);
    if (gradient) {
      query->batch(q, y, Columns(derivatives, m * t * d, count), used);
    } else {
      query->batch(q, y, used);
    }
  }
  if (!gradient) return values;
  return py::make_tuple(values, slopes);
}

py::dict as_dict(const codebooks::Coordinate& c) {
  return py::dict(py::arg("name") = c.name, py::arg("unit") = c.unit,
                  py::arg("role") = pgd::to_string(c.role), py::arg("lower") = c.lower,
                  py::arg("upper") = c.upper);
}

py::dict as_dict(const codebooks::OutputError& o) {
  return py::dict(py::arg("name") = o.name, py::arg("unit") = o.unit, py::arg("range") = o.range,
                  py::arg("max") = o.max, py::arg("p95") = o.p95, py::arg("mean") = o.mean,
                  py::arg("rms") = o.rms, py::arg("max_si") = o.max_si, py::arg("worst") = o.worst);
}

/// As `samara info --json` has it.
py::object certificate_dict(const codebooks::Codebook& book) {
  if (!book.certificate()) return py::none();
  const codebooks::Certificate& c = *book.certificate();
  py::list outputs;
  for (const codebooks::OutputError& o : c.outputs) outputs.append(as_dict(o));
  py::dict result(py::arg("met") = c.met, py::arg("verdict") = codebooks::verdict(book.build(), c),
                  py::arg("tolerance") = c.tolerance, py::arg("max_error") = c.max_error,
                  py::arg("points") = c.points, py::arg("times") = c.times,
                  py::arg("failed_points") = c.failed_points, py::arg("wrong_points") = c.wrong_points,
                  py::arg("share_above") = py::none(), py::arg("climbed_points") = c.climbed_points,
                  py::arg("refuted_before") = c.refuted_before, py::arg("seed") = c.seed,
                  py::arg("integrator") = c.integrator,
                  py::arg("integrator_tolerance") = c.integrator_tolerance, py::arg("residual") = c.residual,
                  py::arg("spent") = py::dict(py::arg("discretisation") = c.spent.discretisation,
                                              py::arg("compression") = c.spent.compression,
                                              py::arg("nonlinearity") = c.spent.nonlinearity),
                  py::arg("norm_defect") = py::none(), py::arg("outputs") = outputs);
  if (c.norm_defect)
    result["norm_defect"] =
        py::dict(py::arg("max") = c.norm_defect->max, py::arg("rms") = c.norm_defect->rms);
  if (c.wrong_points)
    result["share_above"] = codebooks::share_above(*c.wrong_points, c.points, c.refuted_before);
  return result;
}

py::dict as_dict(const codebooks::GroupOutline& group) {
  Names outputs;
  for (const pgd::OutputLabel& o : group.outputs) outputs.push_back(o.name);
  return py::dict(py::arg("kind") = group.is_train ? "train" : "sum_of_products",
                  py::arg("outputs") = outputs, py::arg("ranks") = group.ranks,
                  py::arg("numbers") = group.entries);
}

py::list outlines(const Codebook& book) {
  const std::vector<codebooks::PieceOutline> read = [&] {
    const py::gil_scoped_release release;
    std::vector<codebooks::PieceOutline> all;
    for (const codebooks::Piece& piece : book.pieces()) all.push_back(piece.outline());
    return all;
  }();
  py::list pieces;
  for (const codebooks::PieceOutline& outline : read) {
    py::list axes, groups;
    for (const pgd::Axis& axis : outline.axes) {
      axes.append(py::dict(py::arg("name") = axis.name(), py::arg("basis") = pgd::to_string(axis.basis()),
                           py::arg("transform") = pgd::to_string(axis.transform()),
                           py::arg("nodes") = axis.size(), py::arg("lower") = axis.lower(),
                           py::arg("upper") = axis.upper()));
    }
    for (const codebooks::GroupOutline& group : outline.groups) groups.append(as_dict(group));
    pieces.append(py::dict(py::arg("axes") = axes, py::arg("groups") = groups));
  }
  return pieces;
}

/// What `samara info --json` says, but for the sizes of the file.
py::dict describe(const Book& handle) {
  const Codebook& book = *handle;
  py::list coordinates, outputs, derived;
  for (const codebooks::Coordinate& c : book.coordinates()) coordinates.append(as_dict(c));
  for (const pgd::OutputLabel& o : book.outputs())
    outputs.append(py::dict(py::arg("name") = o.name, py::arg("unit") = o.unit));
  for (const pgd::OutputLabel& o : codebooks::derived_outputs(book))
    derived.append(py::dict(py::arg("name") = o.name, py::arg("unit") = o.unit));
  const codebooks::ModelDescription& model = book.model();
  const codebooks::BuildRecord& build = book.build();
  const codebooks::Provenance& provenance = book.provenance();
  return py::dict(
      py::arg("title") = book.title(), py::arg("coordinates") = coordinates, py::arg("outputs") = outputs,
      py::arg("derived") = derived,
      py::arg("model") = py::dict(py::arg("name") = model.name, py::arg("title") = model.title,
                                  py::arg("equations") = model.equations, py::arg("frames") = model.frames,
                                  py::arg("source") = model.source, py::arg("fixed") = model.fixed),
      py::arg("build") =
          py::dict(py::arg("builder") = build.builder, py::arg("strategy") = build.strategy,
                   py::arg("status") = to_string(build.status), py::arg("message") = build.message,
                   py::arg("evaluations") = build.evaluations, py::arg("grid_size") = build.grid_size,
                   py::arg("iterations") = build.iterations, py::arg("rounds") = build.rounds),
      py::arg("provenance") =
          py::dict(py::arg("generator") = provenance.generator, py::arg("created") = provenance.created,
                   py::arg("host") = provenance.host, py::arg("build_seconds") = provenance.build_seconds,
                   py::arg("plan") = provenance.plan),
      py::arg("certificate") = certificate_dict(book));
}

/// The factors, or the cores, of a group, as views that keep the codebook.
py::dict numbers_of(const codebooks::FieldGroup& group, const py::handle& owner) {
  Names outputs;
  for (const pgd::OutputLabel& o : group.outputs()) outputs.push_back(o.name);
  if (const pgd::SeparatedField* sum = group.sum()) {
    py::list factors;
    for (const Eigen::MatrixXd& f : sum->factors())
      factors.append(view(f.data(), {f.rows(), f.cols()}, {1, f.rows()}, owner));
    const Eigen::MatrixXd& w = sum->weights();
    return py::dict(py::arg("kind") = "sum_of_products", py::arg("outputs") = outputs,
                    py::arg("factors") = factors,
                    py::arg("weights") = view(w.data(), {w.rows(), w.cols()}, {1, w.rows()}, owner));
  }
  py::list cores;
  for (const pgd::TrainCore& core : group.train()->train().cores) {
    const py::ssize_t left = core.left, size = core.size, right = core.right;
    cores.append(view(core.data.data(), {left, size, right}, {1, left, left * size}, owner));
  }
  return py::dict(py::arg("kind") = "train", py::arg("outputs") = outputs, py::arg("cores") = cores);
}

py::list numbers(const std::shared_ptr<Book>& handle) {
  {
    const py::gil_scoped_release release;  // a large file is read here
    for (const codebooks::Piece& piece : (*handle)->pieces()) piece.groups();
  }
  const py::object owner = py::cast(handle);
  py::list pieces;
  for (const codebooks::Piece& piece : (*handle)->pieces()) {
    py::list axes, groups;
    for (const pgd::Axis& axis : piece.groups().front().axes()) {
      const Eigen::VectorXd& nodes = axis.nodes();
      axes.append(py::dict(py::arg("name") = axis.name(), py::arg("basis") = pgd::to_string(axis.basis()),
                           py::arg("transform") = pgd::to_string(axis.transform()),
                           py::arg("nodes") = view(nodes.data(), {nodes.size()}, {1}, owner)));
    }
    for (const codebooks::FieldGroup& group : piece.groups()) groups.append(numbers_of(group, owner));
    py::dict stored(py::arg("axes") = axes, py::arg("groups") = groups);
    if (const codebooks::FrontMap* front = piece.front()) {
      const auto axis_name = [&](int place) {
        return piece.groups().front().axes()[static_cast<std::size_t>(place)].name();
      };
      py::list others;
      for (const codebooks::FrontMap::Other& other : front->others())
        others.append(py::make_tuple(axis_name(other.coordinate), other.coefficients));
      stored["front"] =
          py::dict(py::arg("coordinate") = axis_name(front->coordinate()), py::arg("others") = others,
                   py::arg("place") = view(front->place().data(), {front->place().size()}, {1}, owner));
    }
    pieces.append(stored);
  }
  return pieces;
}

/// Name, first and second number of a distribution.
using DistributionWords = std::tuple<std::string, double, double>;

py::dict statistics(const Book& book, const std::map<std::string, DistributionWords>& inputs,
                    const std::map<std::string, double>& fixed,
                    const std::vector<std::vector<std::string>>& groups, const std::vector<double>& quantiles,
                    int draws, std::uint64_t seed) {
  codebooks::StatisticsRequest request{
      .fixed = fixed, .groups = groups, .quantiles = quantiles, .draws = draws, .seed = seed};
  for (const auto& [name, words] : inputs) {
    const auto& [kind, first, second] = words;
    request.inputs[name] = {codebooks::distribution_from_string(kind), first, second};
  }
  const codebooks::BookStatistics s = [&] {
    const py::gil_scoped_release release;
    return codebooks::take_statistics(*book, request);
  }();
  py::list outputs;
  for (const codebooks::OutputStatistics& o : s.outputs) {
    outputs.append(
        py::dict(py::arg("name") = o.name, py::arg("mean") = copied(o.mean),
                 py::arg("deviation") = copied(o.deviation), py::arg("first_order") = copied(o.first_order),
                 py::arg("total") = copied(o.total), py::arg("group_closed") = copied(o.group_closed),
                 py::arg("group_total") = copied(o.group_total), py::arg("quantiles") = copied(o.quantiles)));
  }
  return py::dict(py::arg("inputs") = s.inputs, py::arg("groups") = s.groups,
                  py::arg("times") = copied(s.times), py::arg("outputs") = outputs,
                  py::arg("notes") = s.notes);
}

std::shared_ptr<Book> open(const std::filesystem::path& path) {
  const py::gil_scoped_release release;
  return std::make_shared<Book>(codebooks::load(path));
}

/// @param path of a plan, which `text` goes after; None where that is the plan
/// @param model None for the one that the plan names
/// @returns the codebook, whether it is met, and how the build ended
py::tuple build(const std::optional<std::filesystem::path>& path, const std::string& text,
                const py::object& model, const py::object& progress, const py::object& warn,
                const std::filesystem::path& checkpoint, bool resume,
                const std::optional<int>& certificate_points) {
  const auto failure = std::make_shared<Failure>();
  const auto definition = model.is_none() ? nullptr : model_of(model, failure);
  const codebooks::BuildOptions options{.certificate_points = certificate_points,
                                        .checkpoint = checkpoint,
                                        .resume = resume,
                                        .progress = progress_to(progress, *failure),
                                        .warning = warning_to(warn, *failure)};
  codebooks::BuildResult result = unlocked(*failure, [&] {
    const auto parameters_of = [&](const models::BodyDescription& description) {
      const models::BodyInFluid body = models::body_in_fluid(description);
      for (const std::string& sentence : body.warnings) options.warning(sentence);
      return models::kirchhoff_parameters(body);
    };
    const std::string whole = path ? io::read_text_file(*path) + text : text;
    return codebooks::build(
        codebooks::parse_plan(whole, path ? path->string() : "the plan", definition, parameters_of), options);
  });
  return py::make_tuple(std::make_shared<Book>(std::move(result.book)), result.met, result.message);
}

}  // namespace

void add_codebooks(py::module_& module) {
  py::class_<Book, std::shared_ptr<Book>>(module, "Book")
      .def_static("open", &open, py::arg("path"))
      .def(
          "save", [](const Book& book, const std::filesystem::path& path) { codebooks::save(*book, path); },
          py::arg("path"), py::call_guard<py::gil_scoped_release>())
      .def("describe", &describe)
      .def("outlines", [](const Book& book) { return outlines(*book); })
      .def("numbers", &numbers)
      .def("statistics", &statistics, py::arg("inputs"), py::arg("fixed"), py::arg("groups"),
           py::arg("quantiles"), py::arg("draws"), py::arg("seed"))
      .def(
          "slice",
          [](const Book& book, const Held& held) {
            return std::make_shared<Book>(codebooks::slice(*book, held));
          },
          py::arg("held"), py::call_guard<py::gil_scoped_release>())
      .def("at", &at, py::arg("points"), py::arg("outputs") = Names(), py::arg("held") = Held(),
           py::arg("precision") = "double", py::arg("order") = 0, py::arg("out") = py::none(),
           py::arg("threads") = py::none())
      .def("trajectories", &trajectories, py::arg("parameters"), py::arg("times"),
           py::arg("outputs") = Names(), py::arg("held") = Held(), py::arg("precision") = "double",
           py::arg("gradient") = false, py::arg("out") = py::none(), py::arg("threads") = py::none());
  module.def("build", &build, py::arg("path"), py::arg("text"), py::arg("model"), py::arg("progress"),
             py::arg("warn"), py::arg("checkpoint"), py::arg("resume"), py::arg("certificate_points"));
}

}  // namespace samara::python
