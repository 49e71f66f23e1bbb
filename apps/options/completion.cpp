#include "options/completion.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"

namespace samara::apps {

namespace {

std::string spaced(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

std::vector<std::string> names_of(const std::vector<CommandWords>& tree) {
  std::vector<std::string> names;
  for (const CommandWords& command : tree) names.push_back(command.name);
  return names;
}

/// Commands whose first input may be the name of a model.
bool takes_model(const CommandWords& command) {
  if (command.inputs.empty()) return false;
  const std::string& name = command.inputs.front().names.front();
  return name == "MODEL" || name == "NAME" || name == "SOURCE";
}

bool takes_names(const OptionWords& option) {
  return option.names.back() == "--set";
}

/// Options whose values may be names of models, besides files.
bool takes_models(const OptionWords& option) {
  return option.names.back() == "--model";
}

/// A text between single quotes, for any of the shells.
std::string single_quoted(std::string text) {
  std::ranges::replace(text, '\'', '`');
  return "'" + text + "'";
}

/// Those of its options that take a value, as the pattern of a `case`; with that value one of a list, or without a
/// list.
std::vector<std::string> names_taking_values(const CommandWords& command) {
  std::vector<std::string> names;
  for (const OptionWords& option : command.options) {
    if (option.value.empty() || !option.choices.empty() || takes_names(option) || takes_models(option))
      continue;
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

/// The branches of `case "$command/$previous"` that bash and zsh have in common. `samara_words` takes the words to
/// offer.
std::string value_branches(const std::vector<CommandWords>& tree) {
  std::string text;
  for (const CommandWords& command : tree) {
    for (const OptionWords& option : command.options) {
      if (option.choices.empty()) continue;
      text += fmt::format("    {}/{}) _samara_words \"{}\"; return ;;\n", command.name, option.names.back(),
                          spaced(option.choices));
    }
    if (std::ranges::any_of(command.options, takes_names))
      text += fmt::format("    {}/--set) _samara_names; return ;;\n", command.name);
    if (std::ranges::any_of(command.options, takes_models))
      text += fmt::format("    {}/--model) _samara_files_or_models; return ;;\n", command.name);
    std::vector<std::string> patterns;
    for (const std::string& name : names_taking_values(command))
      patterns.push_back(fmt::format("{}/{}", command.name, name));
    if (!patterns.empty())
      text += fmt::format("    {}) _samara_files; return ;;\n", fmt::join(patterns, " | "));
  }
  return text;
}

std::string option_branches(const std::vector<CommandWords>& tree) {
  std::string text;
  for (const CommandWords& command : tree) {
    std::vector<std::string> names;
    for (const OptionWords& option : command.options)
      names.insert(names.end(), option.names.begin(), option.names.end());
    text += fmt::format("    {}) options=\"{}\"{} ;;\n", command.name, spaced(names),
                        takes_model(command) ? "; models=\"$_samara_models\"" : "");
  }
  return text;
}

// @models@ and the like are put in.
constexpr const char* kBash = R"SH(# Completion of samara for bash: source <(samara completion bash)
_samara_models="@models@"
_samara_words() { COMPREPLY=($(compgen -W "$1" -- "$current")); }
_samara_files() { mapfile -t COMPREPLY < <(compgen -f -- "$current"); compopt -o filenames 2>/dev/null; }
_samara_files_or_models() { _samara_files; COMPREPLY+=($(compgen -W "$_samara_models" -- "$current")); }
_samara_names() {
  local names="" word
  for word in "${COMP_WORDS[@]:2:COMP_CWORD-2}"; do  # the first that is a model, a plan or a codebook
    if [[ $word != -* && -z $names ]]; then names=$("${COMP_WORDS[0]}" completion --names "$word" 2>/dev/null); fi
  done
  COMPREPLY=($(compgen -S = -W "$names" -- "$current"))
  compopt -o nospace 2>/dev/null
}
_samara() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} options="" models=""
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then _samara_words "@commands@ --help --version --model-library"; return; fi
  case "$command/$previous" in
@values@  esac
  case "$command" in
    help) _samara_words "@commands@ --json --man"; return ;;
    completion) _samara_words "bash zsh fish"; return ;;
@options@  esac
  if [[ $current == -* ]]; then _samara_words "$options"; return; fi
  _samara_files
  if [[ -n $models && $COMP_CWORD -eq 2 ]]; then COMPREPLY+=($(compgen -W "$models" -- "$current")); fi
}
complete -F _samara samara
)SH";

constexpr const char* kZsh = R"SH(#compdef samara
# Completion of samara for zsh: samara completion zsh > a folder of $fpath, as _samara
_samara_models="@models@"
_samara_words() { compadd -- ${=1} }
_samara_files() { _files }
_samara_files_or_models() { _samara_words "$_samara_models"; _files }
_samara_names() {
  local names="" word
  for word in ${words[3,CURRENT-1]}; do
    if [[ $word != -* && -z $names ]]; then names=$(${words[1]} completion --names $word 2>/dev/null); fi
  done
  compadd -S = -- ${(f)names}
}
_samara() {
  local current=${words[CURRENT]} previous=${words[CURRENT-1]} command=${words[2]} options="" models=""
  if ((CURRENT == 2)); then _samara_words "@commands@ --help --version --model-library"; return; fi
  case "$command/$previous" in
@values@  esac
  case "$command" in
    help) _samara_words "@commands@ --json --man"; return ;;
    completion) _samara_words "bash zsh fish"; return ;;
@options@  esac
  if [[ $current == -* ]]; then _samara_words "$options"; return; fi
  if [[ -n $models && $CURRENT -eq 3 ]]; then _samara_words "$models"; fi
  _files
}
if [[ $funcstack[1] == _samara ]]; then _samara "$@"; else compdef _samara samara; fi
)SH";

std::string with(std::string script, const std::string& mark, const std::string& text) {
  for (std::size_t at = script.find(mark); at != std::string::npos; at = script.find(mark, at + text.size()))
    script.replace(at, mark.size(), text);
  return script;
}

std::string fish_script(const std::vector<CommandWords>& tree, const std::vector<std::string>& models) {
  std::string text =
      "# Completion of samara for fish: samara completion fish > ~/.config/fish/completions/samara.fish\n";
  text += "function __samara_names\n  set -l words (commandline -opc)\n";
  text += "  for word in $words[3..]\n    set -l names (samara completion --names $word 2>/dev/null)\n";
  text +=
      "    if test -n \"$names\"\n      string replace -r '$' '=' $names\n      return\n    end\n  "
      "end\nend\n";
  const std::vector<std::string> commands = names_of(tree);
  for (const CommandWords& command : tree) {
    text += fmt::format("complete -c samara -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                        single_quoted(command.summary));
    const std::string seen =
        fmt::format("complete -c samara -n '__fish_seen_subcommand_from {}'", command.name);
    if (takes_model(command)) text += fmt::format("{} -a '{}'\n", seen, spaced(models));
    if (command.name == "help") text += fmt::format("{} -f -a '{}'\n", seen, spaced(commands));
    if (command.name == "completion") text += fmt::format("{} -f -a 'bash zsh fish'\n", seen);
    for (const OptionWords& option : command.options) {
      text += seen;
      for (const std::string& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!option.value.empty()) text += " -r";
      if (!option.choices.empty()) text += fmt::format(" -f -a '{}'", spaced(option.choices));
      if (takes_models(option)) text += fmt::format(" -a '{}'", spaced(models));
      if (takes_names(option)) text += " -f -a '(__samara_names)'";
      text += fmt::format(" -d {}\n", single_quoted(option.text));
    }
  }
  return text;
}

}  // namespace

std::string completion_script(const std::string& shell, const std::vector<CommandWords>& tree,
                              const std::vector<std::string>& models) {
  if (shell == "fish") return fish_script(tree, models);
  if (shell != "bash" && shell != "zsh")
    throw ArgumentError(
        fmt::format("there is no completion for \"{}\"; bash, zsh or fish was expected", shell));
  const std::vector<std::string> commands = names_of(tree);
  std::string script = shell == "bash" ? kBash : kZsh;
  script = with(std::move(script), "@models@", spaced(models));
  script = with(std::move(script), "@commands@", spaced(commands));
  script = with(std::move(script), "@values@", value_branches(tree));
  return with(std::move(script), "@options@", option_branches(tree));
}

}  // namespace samara::apps
