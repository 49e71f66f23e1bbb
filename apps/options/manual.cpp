#include "options/manual.h"

#include <cctype>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "options/command_pages.h"
#include "samara/base/version.h"

namespace samara::apps {

namespace {

/// As man takes text literally.
std::string for_man(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\\') {
      safe += "\\e";
    } else if (c == '-') {
      safe += "\\-";
    } else if (c == '\'' || c == '.') {
      safe += "\\&";
      safe += c;
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string heading(const std::string& name) {
  std::string upper;
  for (const char c : name) upper += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return fmt::format(".TH {} 1 \"\" \"samara {}\" \"Samara\"\n", upper, version());
}

std::string entry(const OptionWords& option) {
  std::string names;
  for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + for_man(name);
  std::string value = option.value.empty() || option.names.front() == option.value ? "" : " " + option.value;
  if (option.several) value += " ...";
  std::string text = for_man(option.text);
  if (!option.choices.empty()) text += for_man(fmt::format("; one of {}", fmt::join(option.choices, ", ")));
  if (!option.default_value.empty()) text += for_man(fmt::format("; default: {}", option.default_value));
  return fmt::format(".TP\n.B {}{}\n{}\n", names, value, text);
}

std::string examples(std::string_view command) {
  const CommandPage* page = page_of(command);
  if (page == nullptr) return "";
  return fmt::format(".SH EXAMPLES\n.nf\n{}\n{}\n.fi\n.SH SEE ALSO\n{}\n",
                     for_man(std::string(page->examples[0])), for_man(std::string(page->examples[1])),
                     for_man(std::string(page->page)));
}

constexpr const char* kExitCodes =
    ".SH EXIT STATUS\n0 done, 1 internal failure, 2 wrong call, 3 bad input file, 4 tolerance or convergence "
    "missed, 5 query "
    "outside the box, 130 interrupted.\n";

nlohmann::ordered_json json_of(const OptionWords& option) {
  return {{"names", option.names},           {"value", option.value},     {"choices", option.choices},
          {"several", option.several},       {"repeats", option.repeats}, {"required", option.required},
          {"default", option.default_value}, {"text", option.text}};
}

}  // namespace

std::string manual_page(const CommandWords* command, const std::vector<CommandWords>& tree) {
  if (command == nullptr) {
    std::string text = heading("samara") +
                       ".SH NAME\nsamara \\- parametric solution codebooks of bodies moving in a fluid\n"
                       ".SH SYNOPSIS\n.B samara\nCOMMAND [OPTIONS]\n.SH COMMANDS\n";
    for (const CommandWords& one : tree)
      text += fmt::format(".TP\n.BR samara\\-{} (1)\n{}\n", for_man(one.name), for_man(one.summary));
    return text + kExitCodes + examples("");
  }
  std::string text = heading("samara-" + command->name);
  text += fmt::format(".SH NAME\nsamara\\-{} \\- {}\n.SH SYNOPSIS\n.B samara {}\n[OPTIONS]",
                      for_man(command->name), for_man(command->summary), for_man(command->name));
  for (const OptionWords& input : command->inputs) {
    const std::string name = input.names.front() + (input.several ? "..." : "");
    text += input.required ? " " + name : " [" + name + "]";
  }
  text += "\n.SH INPUTS\n";
  for (const OptionWords& input : command->inputs) text += entry(input);
  text += ".SH OPTIONS\n";
  for (const OptionWords& option : command->options) text += entry(option);
  return text + kExitCodes + examples(command->name);
}

std::string tree_json(const std::vector<CommandWords>& tree) {
  nlohmann::ordered_json object = {{"schema", "samara-help/1"},
                                   {"commands", nlohmann::ordered_json::array()}};
  for (const CommandWords& command : tree) {
    nlohmann::ordered_json one = {{"name", command.name},
                                  {"summary", command.summary},
                                  {"inputs", nlohmann::ordered_json::array()},
                                  {"options", nlohmann::ordered_json::array()},
                                  {"examples", nlohmann::ordered_json::array()}};
    for (const OptionWords& input : command.inputs) one["inputs"].push_back(json_of(input));
    for (const OptionWords& option : command.options) one["options"].push_back(json_of(option));
    if (const CommandPage* page = page_of(command.name)) {
      for (const std::string_view example : page->examples) one["examples"].push_back(example);
      one["page"] = page->page;
    }
    object["commands"].push_back(one);
  }
  return object.dump() + "\n";
}

}  // namespace samara::apps
