#include "samara/codebooks/file/flat_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "samara/codebooks/book/attitude_length.h"
#include "samara/io/atomic_file.h"

namespace samara::codebooks {

namespace {

static_assert(std::endian::native == std::endian::little, "flat files hold little-endian numbers");

constexpr std::uint64_t kFlatVersion = 1;
constexpr std::uint64_t kFlatByteOrder = 0x01020304;
constexpr std::size_t kFlatPad = 8;  ///< words: arrays begin on borders of vectors, rows fill them
constexpr std::size_t kFlatHeader = 40;
constexpr std::size_t kChecksumPlace = 3;

std::uint64_t word_of(double number) {
  return std::bit_cast<std::uint64_t>(number);
}

std::size_t flat_padded(std::size_t count) {
  return (count + kFlatPad - 1) / kFlatPad * kFlatPad;
}

/// Words of the file as they grow, and its texts, each once.
class FlatWords {
 public:
  FlatWords() : words_(kFlatHeader, 0) {}

  std::uint64_t& header(std::size_t place) { return words_[place]; }

  /// Appends an array; returns where it begins.
  std::uint64_t put(std::span<const std::uint64_t> words) {
    words_.resize(flat_padded(words_.size()), 0);
    words_.insert(words_.end(), words.begin(), words.end());
    return words_.size() - words.size();
  }
  std::uint64_t put(std::span<const double> numbers) {
    std::vector<std::uint64_t> words(numbers.size());
    std::ranges::transform(numbers, words.begin(), word_of);
    return put(words);
  }

  std::uint64_t text(const std::string& text) {
    const auto [entry, is_new] = places_.try_emplace(text, texts_.size());
    if (is_new) texts_.append(text.c_str(), text.size() + 1);
    return entry->second;
  }

  /// With texts and checksum.
  std::string finished() {
    texts_.resize((texts_.size() + 8) / 8 * 8, '\0');
    std::vector<std::uint64_t> letters(texts_.size() / 8);
    std::memcpy(letters.data(), texts_.data(), texts_.size());
    header(9) = put(letters);
    header(10) = letters.size();
    header(2) = words_.size();
    std::uint64_t sum = 0xcbf29ce484222325;
    for (std::size_t i = kChecksumPlace + 1; i < words_.size(); ++i)
      sum = std::rotl(sum ^ words_[i], 29) * 0x100000001b3;
    header(kChecksumPlace) = sum;
    return {reinterpret_cast<const char*>(words_.data()), 8 * words_.size()};
  }

 private:
  std::vector<std::uint64_t> words_;
  std::map<std::string, std::uint64_t> places_;
  std::string texts_;
};

std::span<const double> numbers_of(const Eigen::VectorXd& numbers) {
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

/// A matrix row by row, rows filled up to whole vectors.
std::vector<double> padded_rows(const Eigen::MatrixXd& matrix) {
  const auto lead = static_cast<Eigen::Index>(flat_padded(static_cast<std::size_t>(matrix.cols())));
  std::vector<double> rows(static_cast<std::size_t>(matrix.rows() * lead), 0.0);
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      rows[static_cast<std::size_t>(i * lead + j)] = matrix(i, j);
  return rows;
}

/// Per node j, the product over all others k of 1 / (2 (node_j - node_k)).
std::vector<double> inverse_products(const Eigen::VectorXd& nodes) {
  std::vector<double> products;
  for (Eigen::Index j = 0; j < nodes.size(); ++j) {
    double product = 1.0;
    for (Eigen::Index k = 0; k < nodes.size(); ++k)
      if (k != j) product /= 2.0 * (nodes[j] - nodes[k]);
    products.push_back(product);
  }
  return products;
}

/// Sixteen words of an axis.
void put_axis(FlatWords& file, const pgd::Axis& axis, std::vector<std::uint64_t>& table) {
  std::array<std::uint64_t, 16> record = {};
  const auto touched = static_cast<std::size_t>(axis.stencil_size());
  record[0] = axis.has_elements() ? 0 : axis.is_list() ? 2 : 1;
  record[1] = static_cast<std::uint64_t>(axis.transform());
  record[2] = touched;
  record[3] = static_cast<std::uint64_t>(axis.size());
  record[4] = static_cast<std::uint64_t>(axis.elements());
  record[5] = flat_padded(touched);
  record[6] = word_of(axis.lower());
  record[7] = word_of(axis.upper());
  record[8] = file.put(numbers_of(axis.has_elements() ? axis.borders() : axis.nodes()));
  if (axis.has_elements()) {
    std::vector<double> distances;
    for (Eigen::Index e = 0; e + 1 < axis.borders().size(); ++e)
      distances.push_back(
          pgd::transformed_distance(axis.transform(), axis.borders()[e], axis.borders()[e + 1]));
    record[9] = file.put(distances);
    record[10] = file.put(numbers_of(axis.element_basis().nodes()));
    record[11] = file.put(inverse_products(axis.element_basis().nodes()));
    record[12] = file.put(padded_rows(axis.element_basis().differentiation()));
  } else if (!axis.is_list()) {
    record[12] = file.put(padded_rows(Eigen::MatrixXd(axis.derivative())));
  }
  table.insert(table.end(), record.begin(), record.end());
}

/// Matrices left x right of the nodes of an axis, each column by column and filled up to whole vectors.
std::array<std::uint64_t, 4> put_core(FlatWords& file, Eigen::Index left, Eigen::Index right,
                                      Eigen::Index nodes, const auto& slice) {
  const std::size_t stride = flat_padded(static_cast<std::size_t>(left * right));
  std::vector<double> data(stride * static_cast<std::size_t>(nodes), 0.0);
  for (Eigen::Index i = 0; i < nodes; ++i)
    Eigen::Map<Eigen::MatrixXd>(data.data() + stride * static_cast<std::size_t>(i), left, right) = slice(i);
  return {static_cast<std::uint64_t>(left), static_cast<std::uint64_t>(right), stride, file.put(data)};
}

/// Whether a point is cheaper with outputs and first core apart than with both as one.
bool keeps_rows_apart(const pgd::TrainField& field) {
  const pgd::TrainCore& first = field.train().cores[1];
  const double touched = field.axes().front().stencil_size(), rows = field.output_count();
  return rows * first.left + first.left * touched * first.right < rows * touched * first.right;
}

/// Eight words of a group, and four for each of its cores.
void put_group(FlatWords& file, const FieldGroup& group, std::vector<std::uint64_t>& table) {
  const pgd::TrainField* const train = group.train();
  const bool has_front = train == nullptr || keeps_rows_apart(*train);
  const Eigen::MatrixXd rows =
      train == nullptr ? group.sum()->weights() : Eigen::MatrixXd(train->train().cores[0].left_unfolding());
  std::array<std::uint64_t, 8> record = {};
  record[0] = train != nullptr ? 1 : 0;
  record[1] = static_cast<std::uint64_t>(rows.rows());
  record[2] = has_front ? 1 : 0;
  if (has_front) {
    record[3] = static_cast<std::uint64_t>(rows.cols());
    record[4] = flat_padded(static_cast<std::size_t>(rows.rows()));
    record[5] = file.put(padded_rows(rows.transpose()));
  }
  table.insert(table.end(), record.begin(), record.end());
  for (std::size_t k = 0; k < group.axes().size(); ++k) {
    std::array<std::uint64_t, 4> core;
    if (train == nullptr) {
      const Eigen::MatrixXd& factor = group.sum()->factors()[k];
      core = put_core(file, factor.cols(), 1, factor.rows(),
                      [&](Eigen::Index i) -> Eigen::VectorXd { return factor.row(i).transpose(); });
    } else {
      const pgd::TrainCore& own = train->train().cores[k + 1];
      const bool is_merged = k == 0 && !has_front;
      core = put_core(file, is_merged ? rows.rows() : own.left, own.right, own.size, [&](Eigen::Index i) {
        const Eigen::MatrixXd slice = own.slice(static_cast<int>(i));
        return is_merged ? Eigen::MatrixXd(rows * slice) : slice;
      });
    }
    table.insert(table.end(), core.begin(), core.end());
  }
}

void put_pieces(FlatWords& file, const Codebook& book) {
  std::vector<std::uint64_t> pieces;
  std::vector<double> boxes;
  std::uint64_t groups = 0;
  for (const Piece& piece : book.pieces()) {
    std::vector<std::uint64_t> axis_table, group_table;
    for (const pgd::Axis& axis : piece.groups().front().axes()) put_axis(file, axis, axis_table);
    for (const FieldGroup& group : piece.groups()) put_group(file, group, group_table);
    pieces.push_back(file.put(axis_table));
    pieces.push_back(file.put(group_table));
    pieces.push_back(piece.groups().size());
    groups += piece.groups().size();
    for (std::size_t k = 0; k < piece.lower().size(); ++k) {
      boxes.push_back(piece.lower()[k]);
      boxes.push_back(piece.upper()[k]);
    }
  }
  file.header(7) = groups;
  file.header(14) = file.put(pieces);
  file.header(15) = file.put(boxes);
}

/// Which pieces a place on the first coordinate may belong to: those that meet what lies between one border of pieces,
/// without it, and the next.
void put_finder(FlatWords& file, const Codebook& book) {
  std::vector<double> borders;
  for (const Piece& piece : book.pieces()) {
    borders.push_back(piece.lower().front());
    borders.push_back(piece.upper().front());
  }
  std::ranges::sort(borders);
  borders.erase(std::unique(borders.begin(), borders.end()), borders.end());
  std::vector<std::uint64_t> starts = {0}, candidates;
  for (const double border : borders) {
    for (std::size_t p = 0; p < book.pieces().size(); ++p) {
      if (book.pieces()[p].lower().front() <= border && border <= book.pieces()[p].upper().front())
        candidates.push_back(p);
    }
    starts.push_back(candidates.size());
  }
  file.header(16) = borders.size();
  file.header(17) = file.put(borders);
  file.header(18) = file.put(starts);
  file.header(19) = file.put(candidates);
}

void put_tables(FlatWords& file, const Codebook& book) {
  std::vector<std::uint64_t> coordinates, outputs, fixed;
  for (const Coordinate& c : book.coordinates())
    coordinates.insert(coordinates.end(),
                       {file.text(c.name), file.text(c.unit), word_of(c.lower), word_of(c.upper)});
  for (std::size_t o = 0; o < book.outputs().size(); ++o) {
    const pgd::OutputLabel& output = book.outputs()[o];
    double relative = std::numeric_limits<double>::quiet_NaN(), si = relative;
    if (book.certificate() && o < book.certificate()->outputs.size()) {
      relative = book.certificate()->outputs[o].max;
      si = book.certificate()->outputs[o].max_si;
    }
    outputs.insert(outputs.end(),
                   {file.text(output.name), file.text(output.unit), word_of(relative), word_of(si)});
  }
  for (const auto& [name, value] : book.model().fixed) {
    const auto unit = book.model().fixed_units.find(name);
    fixed.insert(fixed.end(),
                 {file.text(name), file.text(unit == book.model().fixed_units.end() ? "1" : unit->second),
                  word_of(value)});
  }
  file.header(8) = book.model().fixed.size();
  file.header(11) = file.put(coordinates);
  file.header(12) = file.put(outputs);
  file.header(13) = file.put(fixed);
  file.header(26) = file.text(book.model().name);
  file.header(27) = file.text(book.title());
}

void put_attitude(FlatWords& file, const Codebook& book) {
  std::vector<int> outputs(book.outputs().size());
  std::iota(outputs.begin(), outputs.end(), 0);
  const auto attitude = AttitudeLength::of(book, outputs);
  file.header(20) = attitude ? 1 : 0;
  if (!attitude) return;
  for (std::size_t k = 0; k < 4; ++k) file.header(21 + k) = static_cast<std::uint64_t>(attitude->places()[k]);
  file.header(25) = word_of(attitude->length());
}

}  // namespace

std::string format_flat(const Codebook& book) {
  if (const FrontMap* front = book.front()) {
    throw ArgumentError(
        fmt::format("\"{}\" is counted from a front in this codebook, which a flat file cannot say",
                    book.coordinates()[static_cast<std::size_t>(front->coordinate())].name));
  }
  FlatWords file;
  const std::string magic("SAMFLAT\0", 8);
  std::memcpy(&file.header(0), magic.data(), magic.size());
  file.header(1) = kFlatVersion << 32 | kFlatByteOrder;
  file.header(4) = static_cast<std::uint64_t>(book.coordinate_count());
  file.header(5) = static_cast<std::uint64_t>(book.output_count());
  file.header(6) = book.pieces().size();
  put_pieces(file, book);
  put_finder(file, book);
  put_tables(file, book);
  put_attitude(file, book);
  if (const auto& certificate = book.certificate()) {
    file.header(28) = 1;
    file.header(29) = certificate->met ? 1 : 0;
    file.header(30) = word_of(certificate->tolerance);
    file.header(31) = word_of(certificate->max_error);
    file.header(32) = word_of(static_cast<double>(certificate->points));
  }
  return file.finished();
}

void save_flat(const Codebook& book, const std::filesystem::path& path) {
  io::write_text_atomically(path, format_flat(book));
}

}  // namespace samara::codebooks
