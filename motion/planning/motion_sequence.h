#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "samara/motion/chains/markov_chain.h"
#include "samara/motion/database/motion_database.h"
#include "samara/motion/events/event_finder.h"
#include "samara/motion/patterns/pattern_rules.h"

/// Which kinds of segments, or which patterns, a fall is asked to have, one after the other: given, or drawn from a
/// chain.
namespace samara::io {
class TomlTable;
}

namespace samara::motion {

/// A chain by this name is no file.
inline constexpr const char* kChainOfSource = "dissertation";

/// What a segment is asked to be: of a kind, or part of a stretch of a pattern.
struct AskedSegment {
  std::optional<EventKind> kind = {};
  std::optional<Pattern> pattern = {};

  friend bool operator==(const AskedSegment&, const AskedSegment&) = default;
};

struct MotionSequence {
  /// From the first event of the fall on: what comes before it is a release, and no segment.
  std::vector<AskedSegment> segments;
  std::optional<MarkovChain> chain;  ///< of kinds, where nothing is asked but that they be likely
  /// Of kinds, in the falls of a database that have this pattern.
  std::map<Pattern, MarkovChain> of_pattern;
  /// What it costs if all segments are of other kinds than were asked, or, of chains, a nat of the mean of -log
  /// P(kind | kinds before) [semi-lengths squared]. A million puts kinds before all else.
  double weight = 20.0;
  std::optional<std::uint64_t> seed;  ///< that it was drawn with
  std::string origin;                 ///< "given", or what it was drawn from
  /// Whether its patterns are those of captures of which places alone were seen: then a fall is judged by its places.
  bool is_of_places = false;
  /// Of the rule by which stretches are named: those of the captures, or else of the database.
  PatternThresholds thresholds;

  bool is_drawn() const { return seed.has_value(); }
  /// Whether segments are asked for by pattern; else by kind.
  bool is_of_patterns() const { return !segments.empty() && segments.front().pattern.has_value(); }

  /// Of a steady segment where a chain prices kinds, and of what is not reached of stretches of patterns.
  static constexpr double kUnseenPrice = 3.0;

  /// What segment number n costs, before the weight: 1 for another kind than the one that is asked, -log P of chains; 0
  /// where nothing is asked.
  /// @param past kinds of the segments before, the latest last  @param kind none: of a steady segment
  double price(std::size_t n, std::span<const int> past, std::optional<EventKind> kind) const;
};

/// The table [sequence] of MOTION.toml:
///
///     kinds = ["3 swing+", "turn-"]          # each once, or so many times
///     patterns = ["6 zigzag", "4 autorotation"]
///     chain = "film.json"                    # drawn from it, with length and seed
///     length = 12
///     seed = 3
///     events = 2                             # segments that a drawn pattern lasts
///     weight = 20
///
/// `chain` is what `samara patterns --json` says of captures (patterns of their windows, one step a window),
/// a database of motions (kinds), {"schema": "samara-chain/1", "symbols": [..], "counts": [[..]]}, rows from,
/// columns to, or "dissertation": the chain of patterns (5.25) by the counts it comes from (source_chain()),
/// which stays in zigzag. Without it the plan's database is taken. Without a length nothing is drawn: kinds
/// cost -log P under the chain of kinds.
/// @param folder from which files are named  @param database of the plan, or none
/// @throws InputError, with file and line: more than one of kinds, patterns and chain; words that are no kinds or
/// patterns; patterns of which the database has no fall, or no database; a chain that cannot be read.
MotionSequence read_sequence(const io::TomlTable& table, const std::filesystem::path& folder,
                             const MotionDatabase* database);

}  // namespace samara::motion
