#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "commands.h"
#include "output.h"
#include "samara/base/names.h"
#include "samara/codebooks/store.h"
#include "terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;

/// Numbers that the separated form stores, and those of the table of all nodes it stands for.
struct Numbers {
  double stored = 0.0;
  double table = 0.0;
};

Numbers count(const Codebook& book) {
  Numbers numbers;
  for (const codebooks::Piece& piece : book.pieces()) {
    for (const codebooks::FieldGroup& group : piece.groups()) {
      double nodes = 1.0;
      for (const pgd::Axis& axis : group.axes()) nodes *= axis.size();
      numbers.stored += static_cast<double>(group.entries());
      numbers.table += nodes * group.output_count();
    }
  }
  return numbers;
}

/// Of the numbers in memory; in the file they are deflated.
long bytes_of(const codebooks::FieldGroup& group) {
  return group.entries() * static_cast<long>(sizeof(double));
}

/// "12 terms", or "a train of ranks 6, 14, 9": between outputs and time, time and the next axis, ..
std::string form_of(const codebooks::FieldGroup& group) {
  if (const pgd::SeparatedField* sum = group.sum()) return fmt::format("{} terms", sum->rank());
  return fmt::format("a train of ranks {}", fmt::join(group.train()->train().ranks(), ", "));
}

Json to_json(const codebooks::FieldGroup& group) {
  Json object = {{"outputs", group.output_count()}, {"bytes", bytes_of(group)}};
  if (const pgd::SeparatedField* sum = group.sum()) {
    object["kind"] = "sum_of_products";
    object["rank"] = sum->rank();
  } else {
    object["kind"] = "train";
    object["ranks"] = group.train()->train().ranks();
  }
  return object;
}

Json to_json(const Codebook& book, const std::string& path) {
  const Numbers numbers = count(book);
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
  for (const codebooks::Piece& piece : book.pieces()) {
    Json groups = Json::array();
    for (const codebooks::FieldGroup& group : piece.groups()) groups.push_back(to_json(group));
    Json axes = Json::array();
    for (const pgd::Axis& axis : piece.groups().front().axes()) {
      axes.push_back({{"name", axis.name()},
                      {"basis", to_string(axis.basis())},
                      {"transform", to_string(axis.transform())},
                      {"nodes", axis.size()},
                      {"lower", axis.lower()},
                      {"upper", axis.upper()}});
    }
    object["pieces"].push_back({{"axes", axes}, {"groups", groups}});
  }
  const codebooks::ModelDescription& model = book.model();
  object["model"] = {{"name", model.name},     {"title", model.title},   {"equations", model.equations},
                     {"frames", model.frames}, {"source", model.source}, {"fixed", model.fixed}};
  const codebooks::BuildRecord& build = book.build();
  object["build"] = {{"builder", build.builder},         {"strategy", build.strategy},
                     {"status", build.status},           {"message", build.message},
                     {"evaluations", build.evaluations}, {"grid_size", build.grid_size},
                     {"iterations", build.iterations},   {"rounds", build.rounds}};
  object["certificate"] = book.certificate() ? apps::to_json(*book.certificate(), book) : Json(nullptr);
  const codebooks::Provenance& p = book.provenance();
  object["provenance"] = {{"generator", p.generator},
                          {"created", p.created},
                          {"host", p.host},
                          {"build_seconds", p.build_seconds},
                          {"plan", p.plan}};
  return object;
}

const char* what_was_counted(const Codebook& book) {
  if (book.is_of_command()) return "calls";
  return book.build().builder == "sampling" ? "trajectories"
                                            : "evaluations of the right-hand side and its Jacobian";
}

std::string describe(const Codebook& book, const std::string& path) {
  const Numbers numbers = count(book);
  std::string text = fmt::format("{}{}\nmodel {}: {}\n  {}\n", path,
                                 book.title().empty() ? "" : fmt::format(": {}", book.title()),
                                 book.model().name, book.model().title, book.model().equations);
  for (const auto& [name, value] : book.model().fixed) {
    const auto unit = book.model().fixed_units.find(name);
    text += fmt::format("  {} = {}{}\n", name, value,
                        unit == book.model().fixed_units.end() ? "" : unit_suffix(unit->second));
  }
  for (std::size_t k = 0; k < book.pieces().size(); ++k) {
    const codebooks::Piece& piece = book.pieces()[k];
    text += fmt::format("piece {}\n  {:<12} {:<8} {:<10} {:<10} {:>6} {:>12} {:>12}\n", k, "axis", "unit",
                        "role", "basis", "nodes", "lower", "upper");
    for (const pgd::Axis& axis : piece.groups().front().axes()) {
      text += fmt::format("  {:<12} {:<8} {:<10} {:<10} {:>6} {:>12.6g} {:>12.6g}\n", axis.name(),
                          axis.unit(), to_string(axis.role()), to_string(axis.basis()), axis.size(),
                          axis.lower(), axis.upper());
    }
    for (const codebooks::FieldGroup& group : piece.groups()) {
      std::string outputs;
      for (const pgd::OutputLabel& o : group.outputs())
        outputs += fmt::format("{}{}{}", outputs.empty() ? "" : ", ", o.name, unit_suffix(o.unit));
      text += fmt::format("  outputs {}: {}, {} bytes\n", outputs, form_of(group), bytes_of(group));
    }
  }
  text += fmt::format("size: {} bytes; {:.0f} numbers stand for a table of {:.3g}\n",
                      std::filesystem::file_size(path), numbers.stored, numbers.table);
  const codebooks::BuildRecord& build = book.build();
  text += fmt::format("build: {} ({}), {}: {}\n  {:.6g} {}, grid of {:.3g} nodes\n", build.builder,
                      build.strategy, build.status, build.message, build.evaluations, what_was_counted(book),
                      build.grid_size);
  text += book.certificate() ? to_table(*book.certificate(), book) : std::string("no certificate\n");
  text += fmt::format("made by {} on {} in {:.1f} s\n", book.provenance().generator,
                      book.provenance().created, book.provenance().build_seconds);
  return printable(text, "\n");
}

}  // namespace

int run(const InfoArguments& arguments) {
  const Codebook book = codebooks::load(arguments.book);
  if (arguments.json) {
    print(to_json(book, arguments.book));
  } else {
    print(describe(book, arguments.book));
  }
  return kDone;
}

}  // namespace samara::apps
