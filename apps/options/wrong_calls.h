#pragma once

#include <string>
#include <vector>

/// What is wrong with a call, in the words of all other errors: what, its value, what was expected.
namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace samara::apps {

/// Looks at what stands before a command, and at its name: the option parser would only say that some command
/// is needed.
/// @throws ArgumentError for an option that does not belong there, and for a word that is no command
void check_command(const CLI::App& app, const std::vector<std::string>& words);

/// The sentence for what the option parser has refused.
std::string sentence_of(const CLI::ParseError& error, const CLI::App& app);

}  // namespace samara::apps
