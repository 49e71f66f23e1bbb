#include "samara/io/matrix_market.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/io/text_file.h"

namespace samara::io {

namespace {

constexpr std::string_view kBlanks = " \t\r";

/// The words of a line.
std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(kBlanks);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

/// An entry and where it stands.
struct Entry {
  int row = 0, column = 0;  ///< from 0
  double value = 0.0;
  int line = 0;
};

class MatrixMarketText {
 public:
  MatrixMarketText(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

  Eigen::SparseMatrix<double> read() {
    read_header();
    read_sizes();
    read_entries();
    return assemble();
  }

 private:
  /// The next line; false at the end of the text.
  bool next_line() {
    if (place_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', place_), text_.size());
    line_ = text_.substr(place_, end - place_);
    place_ = end + 1;
    ++number_;
    return true;
  }

  /// The words of the next line that is neither empty nor a comment; none at the end of the text.
  std::vector<std::string_view> next_words() {
    while (next_line()) {
      if (line_.starts_with('%')) continue;
      std::vector<std::string_view> words = words_of(line_);
      if (!words.empty()) return words;
    }
    return {};
  }

  InputError error(const std::string& sentence) const { return InputError(name_, number_, sentence); }

  void read_header() {
    next_line();
    std::vector<std::string> words;
    for (const std::string_view word : words_of(line_)) words.push_back(lower_case(word));
    if (words.size() != 5 || words[0] != "%%matrixmarket" || words[1] != "matrix") {
      throw error("begins with " + in_quotes(line_) +
                  ", expected \"%%MatrixMarket matrix coordinate FIELD SYMMETRY\"");
    }
    require_word("format", words[2], {"coordinate"});
    require_word("field", words[3], {"real", "integer"});
    require_word("symmetry", words[4], {"general", "symmetric"});
    integer_ = words[3] == "integer";
    symmetric_ = words[4] == "symmetric";
  }

  void require_word(const char* what, const std::string& word, const std::vector<std::string>& known) const {
    if (std::find(known.begin(), known.end(), word) != known.end()) return;
    std::string expected = known.front();
    for (std::size_t i = 1; i < known.size(); ++i) expected += " or " + known[i];
    throw error(std::string("the ") + what + " of the matrix is " + in_quotes(word) + ", expected " +
                expected);
  }

  std::int64_t integer(std::string_view word) const {
    std::int64_t value = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code != std::errc() || end != word.data() + word.size())
      throw error(in_quotes(word) + " stands where a whole number is expected");
    return value;
  }

  void read_sizes() {
    const std::vector<std::string_view> words = next_words();
    if (words.empty()) throw error("ends before its sizes");
    if (words.size() != 3) throw error(in_quotes(line_) + " is not ROWS COLUMNS ENTRIES");
    const std::int64_t rows = integer(words[0]), columns = integer(words[1]);
    announced_ = integer(words[2]);
    constexpr std::int64_t kMost = std::numeric_limits<int>::max();
    if (rows < 0 || columns < 0 || announced_ < 0 || rows > kMost || columns > kMost ||
        announced_ > kMost / 2)
      throw error(in_quotes(line_) + " are sizes of no matrix that can be held");
    rows_ = static_cast<int>(rows);
    columns_ = static_cast<int>(columns);
    if (symmetric_ && rows_ != columns_) {
      throw error("the matrix is symmetric with " + std::to_string(rows_) + " rows and " +
                  std::to_string(columns_) + " columns, expected a square one");
    }
  }

  int index(std::string_view word, const char* what, int size) const {
    const std::int64_t value = integer(word);
    if (value >= 1 && value <= size) return static_cast<int>(value - 1);
    throw error(std::string(what) + " is " + std::to_string(value) + ", expected 1 to " +
                std::to_string(size));
  }

  double value(std::string_view word) const {
    if (integer_) return static_cast<double>(integer(word));
    const NumberPrefix number = read_number(word);
    if (number.problem == NumberProblem::not_finite || number.problem == NumberProblem::out_of_range)
      throw error("the value " + in_quotes(word) + " is not a finite number");
    if (number.problem != NumberProblem::none || number.length != word.size())
      throw error(in_quotes(word) + " stands where a number is expected");
    return number.value;
  }

  void read_entries() {
    for (std::vector<std::string_view> words = next_words(); !words.empty(); words = next_words()) {
      if (words.size() != 3) throw error(in_quotes(line_) + " is not ROW COLUMN VALUE");
      if (static_cast<std::int64_t>(entries_.size()) == announced_)
        throw error("is one entry more than the " + std::to_string(announced_) + " announced");
      const int row = index(words[0], "the row", rows_);
      const int column = index(words[1], "the column", columns_);
      entries_.push_back({row, column, value(words[2]), number_});
    }
    if (static_cast<std::int64_t>(entries_.size()) < announced_) {
      throw error("ends after " + std::to_string(entries_.size()) + " of " + std::to_string(announced_) +
                  " entries");
    }
  }

  Eigen::SparseMatrix<double> assemble() {
    if (symmetric_) {
      const std::size_t count = entries_.size();
      for (std::size_t i = 0; i < count; ++i) {
        const Entry entry = entries_[i];
        if (entry.row != entry.column) entries_.push_back({entry.column, entry.row, entry.value, entry.line});
      }
    }
    const auto place = [](const Entry& e) { return std::pair(e.column, e.row); };
    std::stable_sort(entries_.begin(), entries_.end(),
                     [&](const Entry& a, const Entry& b) { return place(a) < place(b); });
    std::vector<Eigen::Triplet<double>> triplets;
    triplets.reserve(entries_.size());
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (i > 0 && place(entries_[i]) == place(entries_[i - 1])) {
        const auto [first, second] = std::minmax(entries_[i - 1].line, entries_[i].line);
        throw InputError(name_, second,
                         "the entry stands a second time; the first time on line " + std::to_string(first));
      }
      triplets.emplace_back(entries_[i].row, entries_[i].column, entries_[i].value);
    }
    Eigen::SparseMatrix<double> matrix(rows_, columns_);
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    matrix.makeCompressed();
    return matrix;
  }

  std::string_view text_;
  std::string name_;
  std::size_t place_ = 0;
  std::string_view line_;
  int number_ = 0;  ///< of the line
  bool integer_ = false, symmetric_ = false;
  int rows_ = 0, columns_ = 0;
  std::int64_t announced_ = 0;
  std::vector<Entry> entries_;
};

}  // namespace

Eigen::SparseMatrix<double> parse_matrix_market(const std::string& text, const std::string& name) {
  return MatrixMarketText(text, name).read();
}

Eigen::SparseMatrix<double> read_matrix_market(const std::filesystem::path& path) {
  return parse_matrix_market(read_text_file(path), path.string());
}

}  // namespace samara::io
