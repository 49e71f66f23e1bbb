#include "samara/flow/files/flow_plan.h"

#include <array>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/flow/grid/mesh_shape.h"
#include "samara/io/text_file.h"
#include "samara/io/toml_document.h"
#include "samara/models/equations/time_function.h"

namespace samara::flow {

namespace {

using io::TomlTable;

constexpr const char* kKind = "a plan of a flow";  // of such a file, in messages

double positive(const TomlTable& table, const std::string& key, double value) {
  if (value > 0.0) return value;
  throw table.error(key, fmt::format("is {}, expected a positive number", value));
}

double positive_number(const TomlTable& table, const std::string& key) {
  return positive(table, key, table.number(key));
}

Shape read_polygon(const TomlTable& table) {
  const std::vector<double> x = table.numbers("x"), y = table.numbers("y");
  if (x.size() != y.size())
    throw table.error("y", fmt::format("has {} numbers, expected {}, one for each of x", y.size(), x.size()));
  Eigen::Matrix2Xd corners(2, static_cast<Eigen::Index>(x.size()));
  for (std::size_t i = 0; i < x.size(); ++i) corners.col(static_cast<Eigen::Index>(i)) << x[i], y[i];
  return polygon_section(corners);
}

/// Sizes are in body lengths, so that a plate needs its thickness only.
Shape read_shape(const TomlTable& flow, int dimensions, const MeshReader& mesh_reader) {
  const TomlTable table = flow.table("shape");
  const std::vector<std::string> kinds =
      dimensions == 2 ? std::vector<std::string>{"plate", "rectangle", "ellipse", "polygon"}
                      : std::vector<std::string>{"box", "ellipsoid", "mesh"};
  if (!table.has("kind")) throw table.error("kind", "is missing");
  const std::string kind = table.choice("kind", kinds);
  try {
    if (kind == "plate") {
      table.expect_keys({"kind", "thickness", "baffle"});
      if (table.optional_boolean("baffle").value_or(false)) {
        if (table.has("thickness"))
          throw table.error("thickness",
                            "stands beside baffle = true, which has none: expected one of the two");
        return baffle_section(1.0);
      }
      return rectangle_section(1.0, positive_number(table, "thickness"));
    }
    if (kind == "rectangle") {
      table.expect_keys({"kind", "length", "thickness"});
      return rectangle_section(positive_number(table, "length"), positive_number(table, "thickness"));
    }
    if (kind == "ellipse") {
      table.expect_keys({"kind", "length", "thickness"});
      return ellipse_section(0.5 * positive_number(table, "length"),
                             0.5 * positive_number(table, "thickness"));
    }
    if (kind == "polygon") {
      table.expect_keys({"kind", "x", "y"});
      return read_polygon(table);
    }
    if (kind == "mesh") {
      table.expect_keys({"kind", "file", "thickness"});
      const std::filesystem::path file =
          std::filesystem::path(flow.file()).parent_path() / table.string("file");
      if (!mesh_reader) throw table.error("file", "is a mesh, which this program does not read");
      return mesh_shape(mesh_reader(file.string()), positive_number(table, "thickness"));
    }
    table.expect_keys({"kind", "length", "thickness", "width"});
    const Eigen::Vector3d sides(positive_number(table, "length"), positive_number(table, "thickness"),
                                positive_number(table, "width"));
    return kind == "box" ? box_shape(sides) : ellipsoid_shape(0.5 * sides);
  } catch (const ArgumentError& error) {
    throw flow.error("shape", error.what());
  }
}

std::int64_t whole(const TomlTable& table, const std::string& key, std::int64_t otherwise, std::int64_t least,
                   std::int64_t largest) {
  const std::int64_t value = table.optional_integer(key).value_or(otherwise);
  if (value < least || value > largest)
    throw table.error(key, fmt::format("is {}, expected {} to {}", value, least, largest));
  return value;
}

double number_or(const TomlTable& table, const std::string& key, double otherwise) {
  return positive(table, key, table.optional_number(key).value_or(otherwise));
}

/// How far the domain reaches from the body's centre.
double length_or(const TomlTable& extent, const std::string& key, double otherwise) {
  const double length = number_or(extent, key, otherwise);
  if (length > kLeastExtent && length <= kMostExtent) return length;
  throw extent.error(key, fmt::format("is {}, expected more than {} and at most {} body lengths", length,
                                      kLeastExtent, kMostExtent));
}

/// The path of a body: its coordinates by expressions in t.
BodyMotion read_motion(const TomlTable& table, int dimensions) {
  std::vector<std::string> coordinates = {"x", "y", "angle"};
  if (dimensions == 3) coordinates.insert(coordinates.begin() + 2, "z");
  std::vector<std::string> known = coordinates;
  known.insert(known.end(), {"stream", "period"});
  table.expect_keys(known);
  BodyMotion motion;
  std::vector<models::TimeFunction> functions(4, models::TimeFunction("0"));
  for (const std::string& key : coordinates) {
    if (!table.has(key)) continue;
    const std::string text = table.string(key);
    try {
      const std::size_t at = key == "x" ? 0 : key == "y" ? 1 : key == "z" ? 2 : 3;
      functions[at] = models::TimeFunction(text);
    } catch (const ArgumentError& error) {
      throw table.error(key, error.what());
    }
    motion.text += fmt::format("{}{} = {}", motion.text.empty() ? "" : ", ", key, text);
  }
  if (const auto period = table.optional_number("period")) motion.period = positive(table, "period", *period);
  motion.path = [functions](double t) {
    BodyPose pose;
    for (int d = 0; d < 3; ++d) {
      const models::TimeFunction::Value value = functions[static_cast<std::size_t>(d)].at(t);
      pose.place(d) = value.value;
      pose.velocity(d) = value.rate;
      pose.acceleration(d) = value.second_rate;
    }
    const models::TimeFunction::Value angle = functions[3].at(t);
    pose.angle = angle.value;
    pose.angular_rate = angle.rate;
    pose.angular_acceleration = angle.second_rate;
    return pose;
  };
  return motion;
}

/// What makes a book of the plan.
void read_book(const TomlTable& root, FlowPlan& plan) {
  const TomlTable box = root.table("box");
  box.expect_keys({"angle_of_attack", "log10_reynolds"});
  for (const std::string& key : box.keys()) {
    const std::vector<double> range = box.quantities(key, key == "angle_of_attack" ? "rad" : "1");
    if (range.size() != 2 || !(range[0] < range[1]))
      throw box.error(key, "is no interval [lower, upper] with lower below upper");
    plan.box.push_back({.name = key, .lower = range[0], .upper = range[1]});
  }
  if (plan.box.empty()) throw root.error("box", "is empty, expected angle_of_attack or log10_reynolds in it");
  if (const auto book = root.optional_table("book")) {
    book->expect_keys({"kind", "max_calls", "certificate_points"});
    plan.of_fields = book->choice("kind", {"energy", "fields"}) == "fields";
    plan.max_calls = static_cast<long>(whole(*book, "max_calls", plan.max_calls, 4, 100'000));
    plan.certificate_points =
        static_cast<int>(whole(*book, "certificate_points", plan.certificate_points, 2, 10'000));
  }
  if (const auto tolerance = root.optional_table("tolerance")) {
    tolerance->expect_keys({"relative"});
    plan.relative = number_or(*tolerance, "relative", plan.relative);
    // The mean drag of a call is known to 1 %.
    constexpr double kLeast = 0.03;
    if (plan.end == FlowEnd::mean && plan.relative < kLeast)
      throw tolerance->error("relative",
                             fmt::format("is {}, expected at least {}, three times what the means of the "
                                         "unsteady flow are known to",
                                         plan.relative, kLeast));
  }
}

/// What no key alone is to blame for: the size of the body in its stream, the memory, where a path leads.
/// @throws InputError at the table that it belongs to
void check_flow(const TomlTable& root, const FlowPlan& plan) {
  const auto check = [&root](const char* table, const auto& what) {
    try {
      what();
    } catch (const ArgumentError& error) {
      throw root.error(table, error.what());
    }
  };
  check("flow", [&] { check_case(plan.flow, plan.max_memory); });
  if (plan.flow.motion)
    check("motion", [&] { check_path(plan.flow, {.end = plan.end, .max_time = plan.max_time}); });
}

FlowPlan read(const TomlTable& root, std::string text, const MeshReader& mesh_reader) {
  root.expect_keys({"title", "flow", "motion", "box", "book", "tolerance"});
  FlowPlan plan;
  plan.text = std::move(text);
  plan.title = root.optional_string("title").value_or("");
  const TomlTable table = root.table("flow");
  table.expect_keys({"dimensions", "shape", "angle_of_attack", "reynolds", "intensity", "turbulence",
                     "cells_per_length", "advection", "end", "max_time", "max_memory", "seed", "threads",
                     "extent"});
  FlowCase& flow = plan.flow;
  const auto dimensions = static_cast<int>(whole(table, "dimensions", 2, 2, 3));
  flow.shape = read_shape(table, dimensions, mesh_reader);
  flow.angle_of_attack = table.optional_quantity("angle_of_attack", "rad").value_or(0.0);
  flow.reynolds = positive_number(table, "reynolds");
  flow.intensity = number_or(table, "intensity", flow.intensity);
  if (flow.intensity > 1.0)
    throw table.error("intensity", fmt::format("is {}, expected at most 1", flow.intensity));
  const std::string turbulence = table.choice("turbulence", {"k-epsilon", "k-epsilon-kato-launder", "none"});
  flow.turbulence = turbulence == "none"        ? TurbulenceModel::none
                    : turbulence == "k-epsilon" ? TurbulenceModel::k_epsilon
                                                : TurbulenceModel::kato_launder;
  flow.cells_per_length = static_cast<int>(whole(table, "cells_per_length", flow.cells_per_length, 4, 1000));
  flow.central = table.choice("advection", {"van-leer", "central"}) == "central";
  if (const auto extent = table.optional_table("extent")) {
    extent->expect_keys({"before", "behind", "side"});
    flow.extent.before = length_or(*extent, "before", flow.extent.before);
    flow.extent.behind = length_or(*extent, "behind", flow.extent.behind);
    flow.extent.side = length_or(*extent, "side", flow.extent.side);
  }
  if (const auto motion = root.optional_table("motion")) {
    flow.motion = read_motion(*motion, dimensions);
    if (flow.motion->text.empty())
      throw root.error("motion", "has no path: expected x, y or angle as an expression in t");
    flow.stream = motion->optional_number("stream").value_or(1.0);
    if (!(flow.stream >= 0.0 && flow.stream <= kMostStream))
      throw motion->error(
          "stream", fmt::format("is {}, expected its speed in U, from 0 to {}", flow.stream, kMostStream));
    if (root.has("box"))
      throw root.error("motion", "stands beside a [box]: a book is of bodies that are held");
    // Fields of a body that moves have no mean, and its loads repeat with its motion.
    table.choice("end", {"time"});
    plan.end = FlowEnd::time;
  } else {
    plan.end = table.choice("end", {"mean", "steady"}) == "mean" ? FlowEnd::mean : FlowEnd::steady;
  }
  plan.max_time = number_or(table, "max_time", plan.max_time);
  if (flow.motion && flow.motion->period > plan.max_time)
    throw root.table("motion").error(
        "period",
        fmt::format("is {}, expected at most max_time, {}: no whole period is there to take means over",
                    flow.motion->period, plan.max_time));
  // In less than that there are hardly any steps to take means over.
  if (flow.motion && flow.motion->period > 0.0 && flow.motion->period * flow.cells_per_length < 1.0)
    throw root.table("motion").error(
        "period", fmt::format("is {}, expected at least {:.4g} l/U, in which the stream passes a cell",
                              flow.motion->period, 1.0 / flow.cells_per_length));
  plan.max_memory = number_or(table, "max_memory", plan.max_memory);
  plan.seed = static_cast<std::uint64_t>(whole(table, "seed", 1, 0, INT64_MAX));
  plan.threads = static_cast<int>(whole(table, "threads", 0, 0, 1024));
  if (root.has("box")) {
    read_book(root, plan);
    plan.box_line = root.line("box");
  } else {
    for (const char* key : {"book", "tolerance"}) {
      if (root.has(key)) throw root.error(key, "stands without a [box], which makes a plan one of a book");
    }
    check_flow(root, plan);
  }
  return plan;
}

}  // namespace

FlowPlan read_flow_plan(const std::filesystem::path& path, const MeshReader& mesh_reader) {
  return parse_flow_plan(io::read_text_file(path, {.expected = kKind}), path.string(), mesh_reader);
}

FlowPlan parse_flow_plan(const std::string& text, const std::string& name, const MeshReader& mesh_reader) {
  return read(TomlTable::parse(text, name, kKind), text, mesh_reader);
}

}  // namespace samara::flow
