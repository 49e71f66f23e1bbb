#include "options/help_text.h"

#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/command_pages.h"
#include "options/option_tree.h"
#include "terminal/text_layout.h"

namespace samara::apps {

namespace {

/// "--at TEXT ...", "--frames INT=101", "BOOK TEXT REQUIRED"
std::string left_column(const OptionWords& words) {
  std::string text = fmt::format("{}", fmt::join(words.names, ","));
  if (words.value.empty()) return text;
  text += " " + words.value;
  if (!words.choices.empty()) text += fmt::format(":{{{}}}", fmt::join(words.choices, ","));
  if (!words.default_value.empty()) text += "=" + words.default_value;
  if (words.several) text += " ...";
  if (words.required) text += " REQUIRED";
  return text;
}

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool /*is_positional*/) const override {
    const OptionWords words = words_of(*option);
    std::string text = words.text;
    if (words.repeats && !words.several && text.find("repeated") == std::string::npos)
      text += "; may be repeated";
    return two_columns(left_column(words), text);
  }
  std::string make_subcommand(const CLI::App* command) const override {
    if (command->get_group().empty()) return "";
    return two_columns(command->get_name(), command->get_description());
  }
  std::string make_description(const CLI::App* app) const override {
    return wrapped_lines(app->get_description()) + "\n";
  }
  std::string make_footer(const CLI::App* app) const override {
    const std::string footer = footer_of(app->get_parent() == nullptr ? "" : app->get_name());
    return footer.empty() ? footer : wrapped_lines(footer) + "\n";
  }

 private:
  static std::string two_columns(const std::string& left, const std::string& right) {
    constexpr std::size_t kColumn = 28;
    std::string text = "  " + left;
    if (text.size() + 2 > kColumn) {
      text += "\n" + std::string(kColumn, ' ');
    } else {
      text.resize(kColumn, ' ');
    }
    return text + wrapped(right, kColumn, screen_width(), kColumn) + "\n";
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() {
  return std::make_shared<HelpFormatter>();
}

}  // namespace samara::apps
