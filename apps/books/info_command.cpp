#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "flow/flow_output.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/certify/builder_end.h"
#include "samara/codebooks/file/load.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;

struct InfoArguments {
  std::string book;
  bool plan = false;  ///< the text of the plan alone
  std::string output;
  bool json = false;
};

/// Numbers that the separated form stores, and those of the table of all nodes it stands for.
struct Numbers {
  double stored = 0.0;
  double table = 0.0;
};

/// Of a large file, factors are not read for what is shown here.
using Outlines = std::vector<codebooks::PieceOutline>;

Outlines outlines_of(const Codebook& book) {
  Outlines outlines;
  for (const codebooks::Piece& piece : book.pieces()) outlines.push_back(piece.outline());
  return outlines;
}

Numbers count(const Outlines& outlines) {
  Numbers numbers;
  for (const codebooks::PieceOutline& piece : outlines) {
    double nodes = 1.0;
    for (const pgd::Axis& axis : piece.axes) nodes *= axis.size();
    for (const codebooks::GroupOutline& group : piece.groups) {
      numbers.stored += static_cast<double>(group.entries);
      numbers.table += nodes * static_cast<double>(group.outputs.size());
    }
  }
  return numbers;
}

/// Of the numbers in memory; in the file they are deflated.
long bytes_of(const codebooks::GroupOutline& group) {
  return group.entries * static_cast<long>(sizeof(double));
}

/// "12 terms", or "a tensor train of ranks 6, 14, 9": between outputs and time, time and the next axis, ..
std::string form_of(const codebooks::GroupOutline& group) {
  if (group.is_train) return fmt::format("a tensor train of ranks {}", fmt::join(group.ranks, ", "));
  return fmt::format("{} terms", group.ranks.front());
}

Json group_json(const codebooks::GroupOutline& group) {
  Json object = {{"outputs", group.outputs.size()}, {"bytes", bytes_of(group)}};
  if (group.is_train) {
    object["kind"] = "train";
    object["ranks"] = group.ranks;
  } else {
    object["kind"] = "sum_of_products";
    object["rank"] = group.ranks.front();
  }
  return object;
}

std::string name_of(const Codebook& book, int place) {
  return book.coordinates()[static_cast<std::size_t>(place)].name;
}

/// Of the coordinates that a front moves with.
std::vector<std::string> names_of_others(const Codebook& book, const codebooks::FrontMap& front) {
  std::vector<std::string> names;
  for (const codebooks::FrontMap::Other& other : front.others())
    names.push_back(name_of(book, other.coordinate));
  return names;
}

Json book_json(const Codebook& book, const std::string& path) {
  const Outlines outlines = outlines_of(book);
  const Numbers numbers = count(outlines);
  Json object = {{"schema", "samara-info/1"},
                 {"title", book.title()},
                 {"bytes", std::filesystem::file_size(path)},
                 {"numbers", numbers.stored},
                 {"numbers_of_table", numbers.table},
                 {"coordinates", Json::array()},
                 {"outputs", Json::array()},
                 {"pieces", Json::array()}};
  for (const codebooks::Coordinate& c : book.coordinates()) {
    object["coordinates"].push_back({{"name", c.name},
                                     {"unit", c.unit},
                                     {"role", to_string(c.role)},
                                     {"lower", c.lower},
                                     {"upper", c.upper}});
  }
  for (const pgd::OutputLabel& o : book.outputs())
    object["outputs"].push_back({{"name", o.name}, {"unit", o.unit}});
  for (const codebooks::PieceOutline& piece : outlines) {
    Json groups = Json::array();
    for (const codebooks::GroupOutline& group : piece.groups) groups.push_back(group_json(group));
    Json axes = Json::array();
    for (const pgd::Axis& axis : piece.axes) {
      axes.push_back({{"name", axis.name()},
                      {"basis", to_string(axis.basis())},
                      {"transform", to_string(axis.transform())},
                      {"nodes", axis.size()},
                      {"lower", axis.lower()},
                      {"upper", axis.upper()}});
    }
    object["pieces"].push_back({{"axes", axes}, {"groups", groups}});
  }
  object["mesh"] = nullptr;
  if (const codebooks::SpaceMesh* mesh = book.mesh()) {
    object["mesh"] = {{"directions", mesh->directions()},
                      {"unit", mesh->unit()},
                      {"nodes", mesh->node_count()},
                      {"cells", mesh->cells().cols()}};
  }
  object["front"] = nullptr;
  if (const codebooks::FrontMap* front = book.front())
    object["front"] = {{"coordinate", name_of(book, front->coordinate())},
                       {"others", names_of_others(book, *front)}};
  const codebooks::ModelDescription& model = book.model();
  object["model"] = {{"name", model.name},     {"title", model.title},   {"equations", model.equations},
                     {"frames", model.frames}, {"source", model.source}, {"fixed", model.fixed}};
  const codebooks::BuildRecord& build = book.build();
  object["build"] = {{"builder", build.builder},          {"strategy", build.strategy},
                     {"status", to_string(build.status)}, {"message", build.message},
                     {"evaluations", build.evaluations},  {"grid_size", build.grid_size},
                     {"iterations", build.iterations},    {"rounds", build.rounds}};
  object["certificate"] = book.certificate() ? to_json(*book.certificate(), book) : Json(nullptr);
  const codebooks::Provenance& p = book.provenance();
  object["provenance"] = {{"generator", p.generator},
                          {"created", p.created},
                          {"host", p.host},
                          {"build_seconds", p.build_seconds},
                          {"plan", p.plan}};
  return object;
}

/// "7", or "7..13" where pieces differ.
std::string nodes_of(const Outlines& outlines, std::size_t coordinate) {
  int least = std::numeric_limits<int>::max(), most = 0;
  for (const codebooks::PieceOutline& piece : outlines) {
    const int nodes = piece.axes[coordinate].size();
    least = std::min(least, nodes);
    most = std::max(most, nodes);
  }
  return least == most ? fmt::format("{}", most) : fmt::format("{}..{}", least, most);
}

std::string axis_table(const Codebook& book, const Outlines& outlines) {
  const bool transforms = std::ranges::any_of(
      outlines.front().axes, [](const pgd::Axis& axis) { return axis.transform() != pgd::Transform::none; });
  std::string text = fmt::format("{:<12} {:<8} {:<10} {:<10} {:>7} {:>12} {:>12}{}\n", "axis", "unit", "role",
                                 "basis", "nodes", "lower", "upper", transforms ? "  transform" : "");
  for (std::size_t k = 0; k < book.coordinates().size(); ++k) {
    const codebooks::Coordinate& c = book.coordinates()[k];
    const pgd::Axis& axis = outlines.front().axes[k];
    text += fmt::format("{:<12} {:<8} {:<10} {:<10} {:>7} {:>12.6g} {:>12.6g}{}\n", c.name,
                        shown_unit(c.unit), to_string(c.role), to_string(axis.basis()), nodes_of(outlines, k),
                        c.lower, c.upper, transforms ? "  " + to_string(axis.transform()) : "");
  }
  return text;
}

/// A line per group: where the piece lies on the coordinates that are split, and what it holds.
std::string piece_table(const Codebook& book, const Outlines& outlines) {
  std::string text = fmt::format("{:>5}  {:<28} {:>10}  {}\n", "piece", "outputs", "bytes", "form");
  for (std::size_t p = 0; p < book.pieces().size(); ++p) {
    const codebooks::Piece& piece = book.pieces()[p];
    std::string where;
    for (std::size_t k = 0; k < book.coordinates().size(); ++k) {
      const codebooks::Coordinate& c = book.coordinates()[k];
      if (piece.lower()[k] == c.lower && piece.upper()[k] == c.upper) continue;
      where += fmt::format("; {} from {:.6g} to {:.6g}", c.name, piece.lower()[k], piece.upper()[k]);
    }
    for (const codebooks::GroupOutline& group : outlines[p].groups) {
      std::string outputs;
      for (const pgd::OutputLabel& o : group.outputs)
        outputs += fmt::format("{}{}{}", outputs.empty() ? "" : ", ", o.name, unit_suffix(o.unit));
      text += fmt::format("{:>5}  {:<28} {:>10}  {}{}\n", p, outputs, bytes_of(group), form_of(group), where);
    }
  }
  return text;
}

std::string describe(const Codebook& book, const std::string& path) {
  const Outlines outlines = outlines_of(book);
  const Numbers numbers = count(outlines);
  std::string text;
  if (book.certificate() && !book.certificate()->met)
    text +=
        fmt::format("{}: {}\n",
                    codebooks::is_only_unfinished(book.build(), *book.certificate()) ? "NOT CONVERGED"
                                                                                     : "MISSED ITS TOLERANCE",
                    miss_of(book));
  text += fmt::format("{}{}\nmodel {}: {}\n  {}\n", path,
                      book.title().empty() ? "" : fmt::format(": {}", book.title()), book.model().name,
                      book.model().title, book.model().equations);
  for (const auto& [name, value] : book.model().fixed) {
    const auto unit = book.model().fixed_units.find(name);
    text += fmt::format("  {} = {}{}\n", name, value,
                        unit == book.model().fixed_units.end() ? "" : unit_suffix(unit->second));
  }
  text += axis_table(book, outlines);
  if (const codebooks::FrontMap* front = book.front()) {
    const std::vector<std::string> others = names_of_others(book, *front);
    text += fmt::format("{} is counted from a front{}{}\n", name_of(book, front->coordinate()),
                        others.empty() ? "" : " that moves with ", fmt::join(others, " and "));
  }
  if (const codebooks::SpaceMesh* mesh = book.mesh()) {
    text += fmt::format("mesh: {} nodes in {}{}, {} cells\n", mesh->node_count(),
                        fmt::join(mesh->directions(), ", "), unit_suffix(mesh->unit()), mesh->cells().cols());
  }
  text += piece_table(book, outlines);
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  const double table_bytes = numbers.table * static_cast<double>(sizeof(double));
  text +=
      fmt::format("size: {:.0f} bytes; a table of all nodes would take {}: {:.0f} numbers in place of {}\n",
                  bytes, count_text(table_bytes), numbers.stored, count_text(numbers.table));
  const codebooks::BuildRecord& build = book.build();
  text += fmt::format("build: {} ({}), {}: {}\n", build.builder, build.strategy, to_string(build.status),
                      build.message);
  if (build.rounds > 0) text += fmt::format("  {}\n", effort(book));
  text += book.certificate() ? to_table(*book.certificate(), book) : std::string("no certificate\n");
  const codebooks::Provenance& made = book.provenance();
  text += fmt::format("made by {}", made.generator);
  if (!made.created.empty()) text += fmt::format(" on {}", made.created);
  if (made.build_seconds > 0.0) text += fmt::format(" in {:.1f} s", made.build_seconds);
  text += "\n";
  return printable(text, "\n");
}

int run_info(const InfoArguments& arguments) {
  if (!arguments.output.empty())
    check_text_output(arguments.output, {arguments.book},
                      arguments.plan   ? ".toml"
                      : arguments.json ? ".json"
                                       : ".txt");
  if (flow::is_flow_file(arguments.book)) {
    if (arguments.plan)
      throw ArgumentError(fmt::format("--plan is of codebooks, and {} is a flow", arguments.book));
    const flow::StoredFlow stored = flow::load_flow(arguments.book);
    write_answer(arguments.output,
                 arguments.json ? json_line(to_json(stored)) : to_table(stored, arguments.book));
    return kDone;
  }
  const Codebook book = codebooks::load(arguments.book);
  if (arguments.plan) {
    const std::string& plan = book.provenance().plan;
    if (plan.empty()) throw InputError(arguments.book, "was not built from a plan");
    write_answer(arguments.output, printable(plan, "\n\t\r"));
    return kDone;
  }
  if (arguments.json)
    write_answer(arguments.output, json_line(book_json(book, arguments.book)));
  else
    write_readable(arguments.output, describe(book, arguments.book));
  return kDone;
}

}  // namespace

void add_info(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<InfoArguments>();
  CLI::App* command = app.add_subcommand(
      "info", "axes, ranks, size, certificate and provenance of a codebook; loads and checks of a flow");
  command->add_option("BOOK", values->book, "codebook file, or flow file")->required();
  CLI::Option* json = command->add_flag("--json", values->json, kJson);
  command->add_flag("--plan", values->plan, "the plan that a codebook was built from, and nothing else")
      ->excludes(json);
  command->add_option("-o,--output", values->output, kAnswerFile);
  on_call(*command, arguments, values, run_info);
}

}  // namespace samara::apps
