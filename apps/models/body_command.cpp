#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/assignments.h"
#include "inputs/bodies.h"
#include "options/option_parts.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

struct BodyArguments {
  BodyWords words;
  std::string viscosity;  ///< empty: no Reynolds number
  std::string output;
  bool json = false;
  bool toml = false;
};

template <class Matrix>
Json rows_of(const Matrix& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

template <class Vector>
Json list_of(const Vector& vector) {
  return Json(std::vector<double>(vector.begin(), vector.end()));
}

std::string toml_of(const std::map<std::string, double>& parameters) {
  std::string text = "model = \"kirchhoff_body\"\n\n[fixed]\n";
  for (const auto& [name, value] : parameters) text += fmt::format("{} = {}\n", name, value);
  return text;
}

std::string words_of(const models::BodyInFluid& described, const std::map<std::string, double>& numbers) {
  const models::Body& body = described.body;
  const auto three = [](const auto& v, const char* unit) {
    return fmt::format("{:.6g}, {:.6g}, {:.6g} {}", v[0], v[1], v[2], unit);
  };
  std::string text = fmt::format("mass            {:.6g} kg, volume {:.6g} m^3\n", body.mass, body.volume);
  text +=
      fmt::format("centre of mass  {}, in the frame of the description\n", three(body.centre_of_mass, "m"));
  text +=
      fmt::format("inertia         {}, about it, along body axes\n", three(body.principal.moments, "kg m^2"));
  for (int k = 0; k < 3; ++k)
    text +=
        fmt::format("body {}          {}\n", "xyz"[k], three(body.principal.axes.col(k), "of that frame"));
  text += fmt::format("half extents    {}, of the proxy ellipsoid\n", three(body.proxy_semi_axes, "m"));
  const Eigen::Vector3d linear = described.added_mass.diagonal().head<3>(),
                        angular = described.added_mass.diagonal().tail<3>();
  text +=
      fmt::format("added mass      {}\nadded inertia   {}\n", three(linear, "kg"), three(angular, "kg m^2"));
  for (const auto& [name, value] : numbers) text += fmt::format("{} = {:.6g}\n", name, value);
  return text;
}

int run_body(const BodyArguments& arguments) {
  if (!arguments.output.empty())
    check_text_output(arguments.output, {arguments.words.body},
                      arguments.toml   ? ".toml"
                      : arguments.json ? ".json"
                                       : ".txt");
  std::optional<double> viscosity;
  if (!arguments.viscosity.empty()) viscosity = positive_quantity("--viscosity", arguments.viscosity, "Pa s");
  const models::BodyInFluid described = work_out(description_of(arguments.words));
  const models::Body& body = described.body;
  const std::map<std::string, double> numbers = models::scaling_numbers(described, viscosity);
  const std::map<std::string, double> parameters = models::kirchhoff_parameters(described);
  if (arguments.toml) {
    write_answer(arguments.output, toml_of(parameters));
  } else if (arguments.json) {
    Json object = {{"schema", "samara-body/1"},
                   {"mass", body.mass},
                   {"volume", body.volume},
                   {"density", body.density},
                   {"fluid_density", described.fluid_density},
                   {"centre_of_mass", list_of(body.centre_of_mass)},
                   {"inertia", list_of(body.principal.moments)},
                   {"body_axes", rows_of(body.principal.axes)},
                   {"proxy_semi_axes", list_of(body.proxy_semi_axes)},
                   {"added_mass", rows_of(described.added_mass)},
                   {"added_mass_by", described.by_panels ? "panels" : "ellipsoid"},
                   {"scaling_numbers", numbers},
                   {"kirchhoff_body", parameters}};
    write_answer(arguments.output, json_line(object));
  } else {
    write_answer(arguments.output, words_of(described, numbers));
  }
  return kDone;
}

}  // namespace

void add_body(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<BodyArguments>();
  CLI::App* command =
      app.add_subcommand("body", "mass, inertia, added mass and scaling numbers of a body in a fluid");
  command->add_option("BODY", values->words.body, kBody)->required();
  add_body_words(*command, values->words, true);
  CLI::Option* viscosity = command->add_option("--viscosity", values->viscosity,
                                               "of the fluid, Pa s or with a unit: for the Reynolds number");
  CLI::Option* json = command->add_flag("--json", values->json, kJson);
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--toml", values->toml, "print the lines of a plan of kirchhoff_body")
      ->excludes(json)
      ->excludes(viscosity);
  on_call(*command, arguments, values, run_body);
}

}  // namespace samara::apps
