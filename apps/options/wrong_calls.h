#pragma once

#include <string>

/// What is wrong with a call, in the words of all other errors: what, its value, what was expected.
namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace samara::apps {

/// The sentence for what the option parser has refused.
std::string sentence_of(const CLI::ParseError& error, const CLI::App& app);

}  // namespace samara::apps
