#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace samara::apps {

/// "-x", "--at=3"; neither "-", a stream, nor "-5".
bool is_option(std::string_view word);

/// The command of that name; null where there is none.
const CLI::App* command_of(const CLI::App& app, const std::string& name);

/// Whether several values may follow the option in a row, as in `--at 0.1 0.2`. All others take one and may be
/// repeated.
bool takes_run(const std::string& option);

/// What was typed, with every value of such a row after its option again: then each option takes exactly one
/// word, and none that is left over becomes something else. A row ends with the first word that cannot be one of
/// its values: a number after --at, a name after --outputs, NAME=VALUE after --turbulence; files follow
/// --left-out only where the inputs of the command stand before it, or a "--" ends the row. What is the name of a
/// file that exists is no number and no name.
/// @param words after the name of the program
std::vector<std::string> with_rows_taken_apart(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace samara::apps
