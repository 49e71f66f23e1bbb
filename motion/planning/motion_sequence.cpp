#include "samara/motion/planning/motion_sequence.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/io/text_file.h"
#include "samara/io/toml_document.h"
#include "samara/motion/database/database_file.h"

namespace samara::motion {

namespace {

using io::TomlTable;

/// A chain over words: kinds, or patterns.
struct NamedChain {
  std::vector<std::string> symbols;
  MarkovChain chain;
  bool is_of_places = false;  ///< as MotionSequence::is_of_places
  int ends_in = -1;           ///< symbol after which nothing else comes; -1: there is none
  std::optional<PatternThresholds> thresholds = {};  ///< by which captures were named, if they say so
};

constexpr std::int64_t kMostSegments = 100'000;
constexpr std::int64_t kMostWindows = 10'000'000;  // of films that a chain is fitted to

/// The falls of a database with one pattern, as sequences of kinds.
std::vector<std::vector<int>> kinds_of_pattern(const MotionDatabase& database, Pattern pattern) {
  std::vector<std::vector<int>> sequences;
  Eigen::Index run = -1;
  for (const MotionSegment& segment : database.segments) {
    if (database.runs[static_cast<std::size_t>(segment.run)].pattern != pattern) continue;
    if (segment.is_steady || segment.run != run) sequences.emplace_back();
    run = segment.run;
    if (!segment.is_steady) sequences.back().push_back(static_cast<int>(segment.kind));
  }
  std::erase_if(sequences, [](const std::vector<int>& sequence) { return sequence.empty(); });
  return sequences;
}

std::optional<PatternThresholds> thresholds_of_captures(const nlohmann::json& answer) {
  if (!answer.contains("thresholds")) return {};
  PatternThresholds thresholds;
  for (const auto& [name, value] : answer["thresholds"].items())
    set_threshold(thresholds, name, value.get<double>());
  return thresholds;
}

NamedChain chain_of_windows(const nlohmann::json& answer, const std::string& file) {
  std::vector<std::vector<std::pair<std::string, std::size_t>>> words;  // each with its steps
  bool is_of_places = true;
  double steps = 0.0;
  for (const nlohmann::json& capture : answer.at("captures")) {
    words.emplace_back();
    is_of_places = is_of_places && !capture.value("attitude", true);
    for (const nlohmann::json& window : capture.at("windows")) {
      const auto pattern = window.at("pattern").get<std::string>();
      if (pattern == "unresolved") continue;
      // Equal neighbours are merged there, and steps here.
      const double count = window.value("windows", 1.0);
      if (!(count >= 1.0) || count != std::floor(count))
        throw InputError(
            file,
            fmt::format("a window of its captures counts for {}, expected whole numbers from 1 on", count));
      steps += count;
      if (steps > static_cast<double>(kMostWindows))
        throw InputError(
            file, fmt::format("windows of its captures count for {} or more in all, expected at most {}",
                              steps, kMostWindows));
      words.back().emplace_back(pattern, static_cast<std::size_t>(count));
    }
  }
  std::vector<std::string> symbols;
  for (const std::string& pattern : pattern_names()) {
    const bool was_seen = std::ranges::any_of(words, [&](const auto& one) {
      return std::ranges::any_of(one, [&](const auto& word) { return word.first == pattern; });
    });
    if (was_seen) symbols.push_back(pattern);
  }
  if (symbols.empty())
    throw InputError(file, "no window of its captures has a pattern, expected one or more");
  std::vector<std::vector<int>> sequences;
  for (const auto& one : words) {
    sequences.emplace_back();
    for (const auto& [word, count] : one) {
      const auto found = std::ranges::find(symbols, word);
      if (found == symbols.end())
        throw InputError(file, fmt::format("\"{}\" is no pattern, expected one of {}", word, join(symbols)));
      sequences.back().insert(sequences.back().end(), count, static_cast<int>(found - symbols.begin()));
    }
  }
  const int size = static_cast<int>(symbols.size());
  return {std::move(symbols), MarkovChain::fitted(sequences, size, 1), is_of_places, -1,
          thresholds_of_captures(answer)};
}

NamedChain chain_of_counts(const nlohmann::json& object, const std::string& file) {
  const auto symbols = object.at("symbols").get<std::vector<std::string>>();
  const auto rows = object.at("counts").get<std::vector<std::vector<double>>>();
  const auto size = static_cast<Eigen::Index>(symbols.size());
  Eigen::MatrixXd counts(static_cast<Eigen::Index>(rows.size()), size);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].size() != symbols.size())
      throw InputError(file, fmt::format("row {} of counts has {} numbers, expected {}", i, rows[i].size(),
                                         symbols.size()));
    for (std::size_t j = 0; j < rows[i].size(); ++j)
      counts(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
  }
  try {
    return {symbols, MarkovChain::of_counts(counts)};
  } catch (const ArgumentError& error) {
    throw InputError(file, error.what());
  }
}

/// The chain of the dissertation, (5.25).
NamedChain source_chain_of_patterns() {
  const SourceChain source = source_chain();
  return {source.patterns, MarkovChain::of_counts(source.counts), false,
          static_cast<int>(source.patterns.size()) - 1};
}

NamedChain read_chain(const std::filesystem::path& path) {
  if (ending_of(path) != ".json") {
    const KindChain kinds = kind_chain(load_database(path));
    return {event_kind_names(), kinds.chain};
  }
  const std::string file = path.string();
  const auto object = nlohmann::json::parse(io::read_text_file(path), nullptr, false);
  const std::string schema =
      object.is_object() && object.contains("schema") && object["schema"].is_string() ? object["schema"] : "";
  try {
    if (schema == "samara-patterns/1") return chain_of_windows(object, file);
    if (schema == "samara-chain/1") return chain_of_counts(object, file);
  } catch (const nlohmann::json::exception&) {
    throw InputError(file, fmt::format("is damaged: it does not hold what {} has", schema));
  } catch (const ArgumentError& error) {
    throw InputError(file, error.what());
  }
  throw InputError(file,
                   "is no chain, expected the answer of samara patterns --json on captures, or the schema "
                   "samara-chain/1");
}

class SequenceReader {
 public:
  SequenceReader(const TomlTable& table, const std::filesystem::path& folder, const MotionDatabase* database)
      : table_(table), folder_(folder), database_(database) {}

  MotionSequence read() {
    table_.expect_keys({"kinds", "patterns", "chain", "length", "seed", "events", "weight"});
    const bool has_kinds = table_.has("kinds"), has_patterns = table_.has("patterns");
    const bool is_given = has_kinds || has_patterns;
    if (has_kinds && has_patterns)
      throw table_.error("patterns", "stands beside kinds, expected one of the two");
    for (const char* key : {"chain", "length", "seed"}) {
      if (is_given && table_.has(key))
        throw table_.error(key, "is of sequences that are drawn, expected none beside kinds or patterns");
    }
    sequence_.weight = table_.optional_number("weight").value_or(sequence_.weight);
    if (!(sequence_.weight > 0.0) || sequence_.weight > 1e9)
      throw table_.error("weight",
                         fmt::format("is {}, expected more than 0 and at most 1e9", sequence_.weight));
    sequence_.origin = "given";
    if (has_kinds) read_words("kinds");
    if (has_patterns) read_words("patterns");
    if (!is_given) read_chain_of_plan();
    if (table_.has("events") && !draws_patterns_)
      throw table_.error("events", "is how long drawn patterns last, expected none here");
    add_pattern_chains(has_patterns);
    return sequence_;
  }

 private:
  AskedSegment asked(const std::string& key, const std::string& word, bool is_kind) const {
    AskedSegment segment;
    const std::vector<std::string>& names = is_kind ? event_kind_names() : pattern_names();
    const auto found = std::ranges::find(names, word);
    if (found == names.end() || word == "unresolved")
      throw table_.error(key, fmt::format("\"{}\" is no {}, expected one of {}", word,
                                          is_kind ? "kind of segments" : "pattern", join(names)));
    if (is_kind) {
      segment.kind = static_cast<EventKind>(found - names.begin());
    } else {
      segment.pattern = static_cast<Pattern>(found - names.begin());
    }
    return segment;
  }

  void read_words(const std::string& key) {
    for (const std::string& text : table_.strings(key)) {
      std::int64_t count = 1;
      std::string word = text;
      const std::size_t space = text.find(' ');
      if (space != std::string::npos) {
        const auto [end, error] = std::from_chars(text.data(), text.data() + space, count);
        word = text.substr(space + 1);
        if (error != std::errc() || end != text.data() + space || count < 1)
          throw table_.error(key, fmt::format("\"{}\" was read, expected a name, or a count of 1 or more "
                                              "before it: \"3 {}\"",
                                              text, word));
      }
      if (count + std::ssize(sequence_.segments) > kMostSegments)
        throw table_.error(key, fmt::format("asks for more than {} segments", kMostSegments));
      sequence_.segments.insert(sequence_.segments.end(), static_cast<std::size_t>(count),
                                asked(key, word, key == "kinds"));
    }
    if (sequence_.segments.empty()) throw table_.error(key, "is empty, expected one or more");
  }

  void read_chain_of_plan() {
    const auto file = table_.optional_string("chain");
    if (!file && database_ == nullptr)
      throw table_.error(
          "chain", "is missing, with kinds, patterns, and a database of the plan: expected one of them");
    const NamedChain named = !file ? NamedChain{event_kind_names(), kind_chain(*database_).chain}
                             : *file == kChainOfSource ? source_chain_of_patterns()
                                                       : read_chain(folder_ / *file);
    const bool is_kind = std::ranges::all_of(
        named.symbols, [](const std::string& symbol) { return contains(event_kind_names(), symbol); });
    sequence_.origin = file ? *file : "the database";
    const auto length = table_.optional_integer("length");
    if (!length) {
      if (named.symbols != event_kind_names())
        throw table_.error(
            "length",
            fmt::format("is missing: without it a chain of the kinds {} was expected, not one of {}",
                        join(event_kind_names()), join(named.symbols)));
      if (table_.has("seed")) throw table_.error("seed", "is of sequences with a length");
      sequence_.chain = named.chain;
      return;
    }
    if (*length < 1 || *length > kMostSegments)
      throw table_.error("length", fmt::format("is {}, expected 1 to {}", *length, kMostSegments));
    const std::int64_t seed = table_.optional_integer("seed").value_or(1);
    if (seed < 0) throw table_.error("seed", fmt::format("is {}, expected 0 or more", seed));
    sequence_.seed = static_cast<std::uint64_t>(seed);
    draw(named, is_kind, static_cast<std::size_t>(*length));
  }

  void draw(const NamedChain& named, bool is_kind, std::size_t length) {
    draws_patterns_ = !is_kind;
    sequence_.is_of_places = named.is_of_places;
    of_captures_ = named.thresholds;
    const std::int64_t events = is_kind ? 1 : table_.optional_integer("events").value_or(2);
    if (events < 1 || events > 1000)
      throw table_.error("events", fmt::format("is {}, expected 1 to 1000", events));
    const std::int64_t all = events * static_cast<std::int64_t>(length);
    if (all > kMostSegments)
      throw table_.error(
          "length", fmt::format("asks for {} segments, {} of each pattern, expected at most {}", all, events,
                                kMostSegments));
    constexpr std::uint64_t kOfSequences = std::uint64_t{1} << 62;  // a stream that no search draws from
    Stream stream(*sequence_.seed, kOfSequences);
    bool has_ended = false;
    for (const int drawn : named.chain.draw_sequence(length, stream)) {
      has_ended = has_ended || drawn == named.ends_in;
      const int symbol = has_ended ? named.ends_in : drawn;
      const std::string& word = named.symbols[static_cast<std::size_t>(symbol)];
      sequence_.segments.insert(sequence_.segments.end(), static_cast<std::size_t>(events),
                                asked("chain", word, is_kind));
    }
  }

  /// @param must_be_known given patterns must be had; drawn ones may turn out not to be
  void add_pattern_chains(bool must_be_known) {
    if (!sequence_.is_of_patterns()) return;
    if (database_ == nullptr)
      throw table_.error(must_be_known ? "patterns" : "chain",
                         "asks for patterns, which are what the falls of a database have: expected "
                         "database = \"..\" in the plan");
    sequence_.thresholds = of_captures_ ? *of_captures_ : database_->thresholds();
    for (const AskedSegment& segment : sequence_.segments) {
      if (sequence_.of_pattern.contains(*segment.pattern)) continue;
      if (std::ranges::count(database_->runs, *segment.pattern, &MotionRun::pattern) > 0) {
        sequence_.of_pattern.emplace(*segment.pattern,
                                     MarkovChain::fitted(kinds_of_pattern(*database_, *segment.pattern),
                                                         static_cast<int>(kEventKinds), 2));
      } else if (must_be_known) {
        throw table_.error("patterns", fmt::format("{} is 0 of {} falls of the database, expected a pattern "
                                                   "that it has",
                                                   to_string(*segment.pattern), database_->runs.size()));
      }
    }
  }

  const TomlTable& table_;
  const std::filesystem::path& folder_;
  const MotionDatabase* database_;
  MotionSequence sequence_;
  std::optional<PatternThresholds> of_captures_;
  bool draws_patterns_ = false;
};

}  // namespace

double MotionSequence::price(std::size_t n, std::span<const int> past, std::optional<EventKind> kind) const {
  const MarkovChain* of = chain ? &*chain : nullptr;
  if (n < segments.size()) {
    const AskedSegment& asked = segments[n];
    if (asked.kind) return kind == asked.kind ? 0.0 : 1.0;
    if (asked.pattern == Pattern::steady) return kind ? 1.0 : 0.0;
    const auto found = of_pattern.find(*asked.pattern);
    of = found != of_pattern.end() ? &found->second : nullptr;
  }
  if (of == nullptr) return 0.0;
  return kind ? -std::log(of->probability(past, static_cast<int>(*kind))) : kUnseenPrice;
}

MotionSequence read_sequence(const TomlTable& table, const std::filesystem::path& folder,
                             const MotionDatabase* database) {
  return SequenceReader(table, folder, database).read();
}

}  // namespace samara::motion
