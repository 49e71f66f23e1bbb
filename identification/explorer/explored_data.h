#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "samara/identification/explorer/explorer_page.h"

/// What the page of the explorer carries, as web/explorer/evaluate.js reads it; internal to this room.
namespace samara::identification {

/// Numbers of all books, one after the other. JSON names them by where they begin and how many they are.
class NumberStore {
 public:
  nlohmann::ordered_json put(const double* values, Eigen::Index count);
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> values_;
};

/// Places of the wanted outputs in a book, in its order; who wants one number of a quaternion gets all four.
/// @param wanted empty: all
std::vector<int> outputs_to_show(const codebooks::Codebook& book, const std::vector<std::string>& wanted);

/// What the factors of some outputs of a book take. Reads no more than it has to. [bytes]
double factor_bytes(const codebooks::Codebook& book, const std::vector<int>& outputs);

/// Coordinates, pieces, certificate, pose and body of a book.
nlohmann::ordered_json explored_book(const ExploredBook& explored, const std::vector<int>& outputs,
                                     const std::optional<models::TriangleMesh>& body, NumberStore& numbers);

}  // namespace samara::identification
