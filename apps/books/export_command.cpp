#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/assignments.h"
#include "inputs/value_lists.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/file/flat_file.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/query/query.h"
#include "samara/flow/files/flow_xdmf.h"
#include "samara/io/atomic_file.h"
#include "samara/io/text_file.h"
#include "samara/io/vtk_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;
namespace fs = std::filesystem;

struct ExportArguments {
  std::string book;
  std::string to;  ///< "paraview", "flat"
  std::vector<std::string> set;
  std::vector<std::string> at;
  std::string output;
  bool json = false;
};

int space_of(const Codebook& book, const std::string& path) {
  if (const auto space = book.space()) return *space;
  throw ArgumentError(
      fmt::format("{} has no coordinate of space, or several: ParaView is given a field over one", path));
}

/// The mesh of the codebook; of a line, its nodes, one after the other.
io::VtkGrid grid_of(const Codebook& book, int space) {
  if (book.mesh() != nullptr) return {book.mesh()->points(), book.mesh()->cells()};
  const pgd::Axis axis = book.pieces().front().outline().axes[static_cast<std::size_t>(space)];
  if (axis.is_list()) {
    throw ArgumentError(
        fmt::format("the codebook does not say where the nodes of \"{}\" are: it has no mesh", axis.name()));
  }
  io::VtkGrid line{axis.nodes().transpose(), Eigen::MatrixXi(2, axis.size() - 1)};
  for (int i = 0; i + 1 < axis.size(); ++i) line.cells.col(i) << i, i + 1;
  return line;
}

/// Where the nodes are on the coordinate of space.
Eigen::VectorXd nodes_of(const Codebook& book, int space) {
  return book.pieces().front().outline().axes[static_cast<std::size_t>(space)].nodes();
}

std::vector<double> times_of(const Codebook& book, const ExportArguments& arguments) {
  if (!book.has_time() && arguments.at.empty()) return {};
  const codebooks::Coordinate& time = book.time("--at");
  const std::vector<double> times = numbers_of("--at", arguments.at, time.unit);
  if (!times.empty()) return times;
  const Eigen::VectorXd all = even_times(11, time.lower, time.upper);
  return {all.begin(), all.end()};
}

/// All coordinates at one time and every node; only time is left open.
Eigen::MatrixXd exported_points(const Codebook& book, const ExportArguments& arguments, int space) {
  std::map<std::string, std::string> units;
  for (const codebooks::Coordinate& c : book.parameters()) {
    if (c.role != pgd::AxisRole::space) units[c.name] = c.unit;
  }
  const std::map<std::string, double> values = parse_assignments(arguments.set, units);
  const Eigen::VectorXd nodes = nodes_of(book, space);
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(book.coordinate_count(), nodes.size());
  points.row(space) = nodes.transpose();
  for (int k = book.has_time() ? 1 : 0; k < book.coordinate_count(); ++k) {
    if (k == space) continue;
    const codebooks::Coordinate& c = book.coordinates()[static_cast<std::size_t>(k)];
    const auto value = values.find(c.name);
    if (value == values.end()) {
      throw ArgumentError(fmt::format("{} is not set, expected --set \"{}=VALUE\" with a value in [{}, {}]{}",
                                      c.name, c.name, c.lower, c.upper, unit_suffix(c.unit)));
    }
    points.row(k).setConstant(value->second);
  }
  return points;
}

std::vector<io::VtkField> fields_of(const Codebook& book, const Eigen::Ref<const Eigen::MatrixXd>& points) {
  Eigen::MatrixXd values(book.output_count(), points.cols());
  codebooks::Query(book).batch(points, values, 0);
  std::vector<io::VtkField> fields;
  for (int o = 0; o < book.output_count(); ++o) {
    const pgd::OutputLabel& output = book.outputs()[static_cast<std::size_t>(o)];
    fields.push_back({fmt::format("{}[{}]", output.name, output.unit), values.row(o).transpose()});
  }
  return fields;
}

void check_name(const fs::path& output, std::size_t times) {
  const std::string ending = ending_of(output);
  if (ending != ".vtu" && ending != ".pvd")
    throw ArgumentError(fmt::format(
        "the output is \"{}\", expected a name in .vtu, or .pvd for several times", output.string()));
  if (ending == ".vtu" && times > 1) {
    throw ArgumentError(
        fmt::format("\"{}\" holds one time, but there are {}: expected --at one of them, or a name in .pvd",
                    output.string(), times));
  }
  if (ending == ".pvd" && times == 0)
    throw ArgumentError(fmt::format(
        "\"{}\" lists times, of which the codebook has none: expected a name in .vtu", output.string()));
}

/// Of one time: a file by a name that nobody gave is only replaced where it is such a file.
void check_step_file(const fs::path& file, const std::string& book) {
  check_output(file, {book});
  std::error_code ignored;
  if (fs::exists(file, ignored) && io::read_text_file(file).find("<VTKFile") == std::string::npos)
    throw ArgumentError(
        fmt::format("{} is in the way, and no file of ParaView: it would be overwritten", file.string()));
}

/// XDMF, which names the flow file as it lies from there.
void export_flow(const ExportArguments& arguments, const fs::path& output) {
  if (ending_of(output) != ".xdmf")
    throw ArgumentError(
        fmt::format("the output is \"{}\", expected a name in .xdmf for a flow", output.string()));
  if (!arguments.set.empty() || !arguments.at.empty())
    throw ArgumentError("a flow has no parameters and no times, expected neither --set nor --at");
  const fs::path from = fs::absolute(output).parent_path();
  io::write_text_atomically(
      output, flow::format_xdmf(flow::load_flow(arguments.book),
                                fs::absolute(arguments.book).lexically_relative(from).string()));
}

void export_flat(const ExportArguments& arguments) {
  if (!arguments.set.empty() || !arguments.at.empty())
    throw ArgumentError("a flat file holds the whole codebook, expected neither --set nor --at");
  if (flow::is_flow_file(arguments.book))
    throw ArgumentError(fmt::format("{} is a flow file, expected a codebook for --to flat", arguments.book));
  check_ending("--output", arguments.output, ".flat");
  check_replaced(arguments.output, "flat file", "SAMFLAT");
  const Codebook book = codebooks::load(arguments.book);
  warn_of_missed_tolerance(book, arguments.book);
  codebooks::save_flat(book, arguments.output);
}

int export_any(const ExportArguments& arguments) {
  const fs::path output = arguments.output;
  check_output(arguments.output, {arguments.book});
  if (arguments.to == "flat") {
    export_flat(arguments);
    return kDone;
  }
  if (flow::is_flow_file(arguments.book)) {
    export_flow(arguments, output);
    return kDone;
  }
  const Codebook book = codebooks::load(arguments.book);
  warn_of_missed_tolerance(book, arguments.book);
  const int space = space_of(book, arguments.book);
  const std::vector<double> times = times_of(book, arguments);
  check_name(output, times.size());
  const io::VtkGrid grid = grid_of(book, space);
  Eigen::MatrixXd points = exported_points(book, arguments, space);
  if (ending_of(output) == ".vtu") {
    if (!times.empty()) points.row(0).setConstant(times.front());
    io::write_text_atomically(output, io::format_vtu(grid, fields_of(book, points)));
    return kDone;
  }
  std::vector<io::VtkStep> steps;
  for (const double time : times) {
    const std::string file = fmt::format("{}_{:04}.vtu", output.stem().string(), steps.size());
    check_step_file(output.parent_path() / file, arguments.book);
    steps.push_back({time, file});
  }
  // What cannot be asked is refused before anything is written.
  for (const io::VtkStep& step : steps) {
    points(0, 0) = step.time;
    fields_of(book, points.leftCols(1));
  }
  // The list comes last: what it names is there.
  for (const io::VtkStep& step : steps) {
    points.row(0).setConstant(step.time);
    io::write_text_atomically(output.parent_path() / step.file,
                              io::format_vtu(grid, fields_of(book, points)));
  }
  io::write_text_atomically(output, io::format_pvd(steps));
  return kDone;
}

int run_export(const ExportArguments& arguments) {
  const int code = export_any(arguments);
  tell_of_file(arguments.output, arguments.json);
  return code;
}

}  // namespace

void add_export(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<ExportArguments>();
  CLI::App* command =
      app.add_subcommand("export", "a codebook for programs without Samara; fields of space, flows");
  command->add_option("BOOK", values->book, "codebook file, or flow file")->required();
  command
      ->add_option("--to", values->to,
                   "for whom: paraview (a field of space at chosen parameters, as VTK files), or flat (the "
                   "codebook as samara_eval.h reads it, a header in C for programs without any library)")
      ->required()
      ->check(CLI::IsMember({"paraview", "flat"}));
  command->add_option("--set", values->set, kAssignments)->allow_extra_args(false);
  command->add_option("--at", values->at, kTimes);
  command
      ->add_option("-o,--output", values->output,
                   "file to write: NAME.vtu for one time, NAME.pvd for several, with NAME_0000.vtu and so on "
                   "beside it; of a flow NAME.xdmf, which refers to the flow file; NAME.flat")
      ->required();
  command->add_flag("--json", values->json, kJsonOfFile);
  on_call(*command, arguments, values, run_export);
}

}  // namespace samara::apps
