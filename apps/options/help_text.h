#pragma once

#include <memory>

namespace CLI {
class App;
class FormatterBase;
}  // namespace CLI

namespace samara::apps {

/// The help of every command: its options in two columns, in lines that fit the screen; two examples; the page to read.
std::shared_ptr<CLI::FormatterBase> help_formatter();

}  // namespace samara::apps
