#pragma once

#include <cstddef>
#include <span>
#include <vector>

/// What is new in a long list of numbers that has changed in few places.
namespace samara::codebooks {

/// A part of a new list: numbers copied from the old one, and new ones after them. A list is made anew by its edits,
/// one after the other.
struct ListEdit {
  std::size_t from = 0, count = 0;  ///< in the old list
  std::vector<double> then;         ///< numbers that follow
};

/// Parts of 64 numbers and more that stand in the old list, wherever that is, are copied; numbers are the same if
/// their bits are. Takes a time proportional to both lists.
std::vector<ListEdit> edits_between(std::span<const double> before, std::span<const double> now);

/// A list after one set of edits after the other. Until it is asked for it is a list of parts, so that many edits of
/// a long list do not copy it as often.
class EditedList {
 public:
  std::size_t size() const { return size_; }
  /// @throws ArgumentError for a part that is not in the list
  void apply(std::vector<ListEdit> edits);
  std::vector<double> numbers() const;

 private:
  struct Part {
    const double* first = nullptr;
    std::size_t count = 0;
  };
  void add(std::vector<Part>& parts, Part part) const;
  void add_copy(std::vector<Part>& parts, const ListEdit& edit) const;

  std::vector<std::vector<double>> kept_;  ///< what parts lie in; it is their heaps that stay in place
  std::vector<Part> parts_;
  std::vector<std::size_t> begins_;  ///< per part, of its numbers in the list
  std::size_t size_ = 0;
};

}  // namespace samara::codebooks
