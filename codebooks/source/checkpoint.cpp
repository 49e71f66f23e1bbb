#include "samara/codebooks/source/checkpoint.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/version.h"
#include "samara/codebooks/source/list_edits.h"

namespace samara::codebooks {

namespace {

constexpr std::string_view kFormat = "samara-checkpoint";
constexpr int kVersion = 8;

/// Checkpoints go on to the last bit, which only the program that wrote them does.
std::string format_record() {
  return fmt::format("{}\n{}\nsamara {}", kFormat, kVersion, version());
}

/// Kinds of records, by their first letter.
constexpr char kPlan = 'p', kMarch = 'm', kSteps = 's', kCalls = 'c';

class RecordWriter {
 public:
  explicit RecordWriter(char kind) : bytes_(1, kind) {}

  void add(std::uint64_t number) { bytes_.append(reinterpret_cast<const char*>(&number), sizeof number); }
  void add(double number) { bytes_.append(reinterpret_cast<const char*>(&number), sizeof number); }
  void add(std::span<const double> numbers) {
    add(std::uint64_t{numbers.size()});
    bytes_.append(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes());
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class RecordReader {
 public:
  explicit RecordReader(std::string_view bytes) : rest_(bytes.substr(1)) {}

  bool is_at_end() const { return rest_.empty(); }
  std::uint64_t whole() { return take<std::uint64_t>(); }
  double number() { return take<double>(); }
  std::vector<double> numbers() {
    const std::uint64_t count = whole();
    if (count > rest_.size() / sizeof(double)) throw ArgumentError("a record ends too early");
    std::vector<double> list(count);
    if (count > 0) std::memcpy(list.data(), rest_.data(), count * sizeof(double));
    rest_.remove_prefix(count * sizeof(double));
    return list;
  }

 private:
  template <class Number>
  Number take() {
    if (rest_.size() < sizeof(Number)) throw ArgumentError("a record ends too early");
    Number number;
    std::memcpy(&number, rest_.data(), sizeof number);
    rest_.remove_prefix(sizeof number);
    return number;
  }
  std::string_view rest_;
};

std::string state_record(char kind, const std::vector<double>& before, const std::vector<double>& now) {
  RecordWriter writer(kind);
  for (const ListEdit& edit : edits_between(before, now)) {
    writer.add(std::uint64_t{edit.from});
    writer.add(std::uint64_t{edit.count});
    writer.add(edit.then);
  }
  return writer.bytes();
}

std::vector<ListEdit> edits_of(std::string_view record) {
  RecordReader reader(record);
  std::vector<ListEdit> edits;
  while (!reader.is_at_end()) {
    ListEdit edit;
    edit.from = reader.whole();
    edit.count = reader.whole();
    edit.then = reader.numbers();
    edits.push_back(std::move(edit));
  }
  return edits;
}

/// What is new of a sheet, of which so many points and values were told.
void add_sheet(RecordWriter& writer, std::size_t place, const CallSheet& sheet, std::size_t points,
               std::size_t values) {
  writer.add(std::uint64_t{place});
  writer.add(sheet.times);
  writer.add(sheet.seconds);
  writer.add(std::span(sheet.points).subspan(points));
  writer.add(std::span(sheet.values).subspan(values));
}

void take_sheets(std::string_view record, std::vector<CallSheet>& calls) {
  RecordReader reader(record);
  while (!reader.is_at_end()) {
    const std::uint64_t place = reader.whole();
    if (place > calls.size()) throw ArgumentError("a record is of calls that were not told");
    if (place == calls.size()) calls.emplace_back();
    CallSheet& sheet = calls[place];
    sheet.times = reader.numbers();
    sheet.seconds = reader.number();
    for (std::vector<double>* list : {&sheet.points, &sheet.values}) {
      const std::vector<double> more = reader.numbers();
      list->insert(list->end(), more.begin(), more.end());
    }
  }
}

/// The first lines that differ.
std::string first_difference(std::string_view its, std::string_view ours) {
  const auto next_line = [](std::string_view& text) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    return line;
  };
  std::string_view of_its, of_ours;
  while (of_its == of_ours && !(its.empty() && ours.empty())) {
    of_its = next_line(its);
    of_ours = next_line(ours);
  }
  if (of_its == of_ours) return "they differ in line breaks at the end";
  return fmt::format("\"{}\" stands there where this one has \"{}\"", of_its, of_ours);
}

/// Whether the list begins with the other.
bool goes_on(const std::vector<double>& list, const std::vector<double>& before) {
  return list.size() >= before.size() &&
         std::memcmp(list.data(), before.data(), before.size() * sizeof(double)) == 0;
}

bool goes_on(const std::vector<CallSheet>& calls, const std::vector<CallSheet>& before) {
  return calls.size() >= before.size() &&
         std::ranges::equal(
             before, std::span(calls).first(before.size()), [](const CallSheet& a, const CallSheet& b) {
               return a.times == b.times && goes_on(b.points, a.points) && goes_on(b.values, a.values);
             });
}

}  // namespace

bool is_checkpoint(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

InputError bad_checkpoint(const std::filesystem::path& path, const std::string& reason) {
  return InputError(path.string(), fmt::format("{}; --fresh begins anew, and removes it", reason));
}

void check_checkpoint_path(const std::filesystem::path& path, const CheckpointKind& kind) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw InputError(path.string(),
                     fmt::format("is a folder, expected a file for the checkpoint of {}", kind.of));
  if (!std::filesystem::exists(path, ignored)) return;
  // Of a pipe nothing could be read again, and to open one may wait for ever.
  if (!std::filesystem::is_regular_file(path, ignored))
    throw InputError(path.string(),
                     fmt::format("is no regular file, expected one for the checkpoint of {}", kind.of));
  if (!std::filesystem::is_empty(path, ignored) && !kind.is_one(path))
    throw InputError(
        path.string(),
        fmt::format("this is no checkpoint of {}, and would be lost: move it, or choose another name",
                    kind.of));
}

void remove_checkpoint(const std::filesystem::path& path, const CheckpointKind& kind) {
  check_checkpoint_path(path, kind);
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
}

Checkpoint::Checkpoint(std::filesystem::path path, std::string plan)
    : path_(std::move(path)), plan_(std::move(plan)) {
  check_checkpoint_path(path_);
}

std::vector<double> Checkpoint::march() const {
  std::optional<Journal> journal;
  return read(journal).march;
}

std::vector<double> Checkpoint::steps() const {
  std::optional<Journal> journal;
  return read(journal).steps;
}

std::vector<CallSheet> Checkpoint::calls() const {
  std::optional<Journal> journal;
  return read(journal).calls;
}

Checkpoint::Contents Checkpoint::read(std::optional<Journal>& journal) const {
  std::vector<std::string> records;
  try {
    journal.emplace(path_, &records);
  } catch (const InputError&) {
    throw bad_checkpoint(path_, "this is no checkpoint");
  }
  if (records.empty() || !records[0].starts_with(kFormat))
    throw bad_checkpoint(path_, "this is no checkpoint");
  if (records[0] != format_record()) {
    throw bad_checkpoint(
        path_, fmt::format("the checkpoint was not written by samara {}, format {}", version(), kVersion));
  }
  if (records.size() < 2 || records[1].empty() || records[1].front() != kPlan)
    throw bad_checkpoint(path_, "the checkpoint is damaged: it does not say of which plan it is");
  if (const std::string_view its = std::string_view(records[1]).substr(1); its != plan_) {
    throw bad_checkpoint(
        path_, fmt::format("the checkpoint belongs to another plan, or was begun with other options: {}",
                           first_difference(its, plan_)));
  }
  EditedList march, steps;
  Contents contents;
  try {
    for (const std::string& record : std::span(records).subspan(2)) {
      if (record[0] == kMarch) march.apply(edits_of(record));
      if (record[0] == kSteps) steps.apply(edits_of(record));
      if (record[0] == kCalls) take_sheets(record, contents.calls);
    }
  } catch (const ArgumentError& error) {
    throw bad_checkpoint(path_, error.what());
  }
  contents.march = march.numbers();
  contents.steps = steps.numbers();
  return contents;
}

/// Reads the file anew where another has written there, or nobody has yet. @returns the calls that were found then
std::vector<CallSheet> Checkpoint::follow_file() {
  if (journal_ && journal_->is_as_left()) return {};
  Contents found;
  journal_.reset();
  if (is_checkpoint(path_)) {
    try {
      found = read(journal_);
    } catch (const InputError&) {
      journal_.reset();
    }
  }
  march_ = std::move(found.march);
  steps_ = std::move(found.steps);
  hold(found.calls);
  return std::move(found.calls);
}

void Checkpoint::hold(const std::vector<CallSheet>& calls) {
  held_.clear();
  for (const CallSheet& sheet : calls) held_.push_back({sheet.points.size(), sheet.values.size()});
}

void Checkpoint::save_state(std::vector<double>& held, const std::vector<double>& state) {
  std::vector<CallSheet> calls = follow_file();
  const std::string record =
      journal_ ? state_record(&held == &march_ ? kMarch : kSteps, held, state) : std::string();
  if (journal_ && has_room_for(record)) {
    append(record);
    held = state;
    return;
  }
  if (journal_) calls = this->calls();
  held = state;
  write_anew(calls);
}

void Checkpoint::save_calls(const std::vector<CallSheet>& calls) {
  if (!goes_on(calls, follow_file())) journal_.reset();
  RecordWriter writer(kCalls);
  if (journal_) {
    held_.resize(std::max(held_.size(), calls.size()));
    for (std::size_t place = 0; place < calls.size(); ++place)
      add_sheet(writer, place, calls[place], held_[place].points, held_[place].values);
    if (!has_room_for(writer.bytes())) journal_.reset();
  }
  if (!journal_) return write_anew(calls);
  append(writer.bytes());
  hold(calls);
}

/// Whether the file stays at some times of what it holds.
bool Checkpoint::has_room_for(const std::string& record) const {
  constexpr std::uint64_t kSlack = std::uint64_t{1} << 16;
  constexpr std::uint64_t kMostTimes = 4;
  std::uint64_t numbers = march_.size() + steps_.size();
  for (const HeldSheet& sheet : held_) numbers += sheet.points + sheet.values;
  return journal_->size() + record.size() <= kSlack + kMostTimes * (plan_.size() + sizeof(double) * numbers);
}

void Checkpoint::append(const std::string& record) {
  try {
    journal_->append(record);
  } catch (const ArgumentError&) {
    journal_.reset();  // what it holds is read again, when there may be room
    throw;
  }
}

void Checkpoint::write_anew(const std::vector<CallSheet>& calls) {
  std::vector<std::string> records = {format_record(), kPlan + plan_};
  if (!march_.empty()) records.push_back(state_record(kMarch, {}, march_));
  if (!steps_.empty()) records.push_back(state_record(kSteps, {}, steps_));
  if (!calls.empty()) {
    RecordWriter writer(kCalls);
    for (std::size_t place = 0; place < calls.size(); ++place) add_sheet(writer, place, calls[place], 0, 0);
    records.push_back(writer.bytes());
  }
  journal_.reset();
  journal_.emplace(path_, records);
  hold(calls);
}

}  // namespace samara::codebooks
