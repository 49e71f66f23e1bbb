#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "samara/codebooks/book/certificate.h"
#include "samara/codebooks/book/codebook.h"

/// Answers on stdout, shared by several commands.
namespace samara::apps {

using Json = nlohmann::ordered_json;

/// @throws ArgumentError if stdout is closed or full.
void print(const std::string& text);
/// One of several parts of an answer. @throws as print()
void print_part(std::string_view text);
/// One object on one line; bytes that are no UTF-8, as names of files may have, become U+FFFD.
std::string json_line(const Json& object);
void print(const Json& object);
/// Before the work is done: whether an answer can be written to the file.
/// @throws ArgumentError if not, or if it is one of the inputs.
void check_output(const std::string& path, const std::vector<std::string>& inputs);
/// The same of a codebook or another file in HDF5, which no stream takes.
/// @throws ArgumentError for a name with the ending of another format, too: `fall.csv` must not hold a codebook
void check_file_output(const std::string& path, const std::vector<std::string>& inputs);
/// The same of a table, JSON or another text.
/// @param ending of its format: .csv, .json, .toml, or .txt for text to read
/// @throws ArgumentError for a name with the ending of another format, too: `fit.toml` must not hold JSON
void check_text_output(const std::string& path, const std::vector<std::string>& inputs,
                       std::string_view ending);
/// The same where a motion may be written, too (.glb, .usda).
void check_text_or_scene_output(const std::string& path, const std::vector<std::string>& inputs,
                                std::string_view ending);
/// Options that name files to write, with the names; those without one are not asked for.
/// @throws ArgumentError where two name the same file, also through links.
void check_outputs_differ(const std::vector<std::pair<std::string, std::string>>& written);
/// Of a file that is of one kind whatever its name is: `fall.png` must not hold a picture in SVG.
/// Capitals do not matter, and an ending is letters, and digits after them: that of `run_0.2` is none.
/// @param option that names the file, such as "--report"
/// @throws ArgumentError for a name with another ending; names without one, as those of streams, are taken
void check_ending(const std::string& option, const std::string& path, const std::string& ending);
/// Of an output that is there, before its kind is looked at. @throws ArgumentError if it cannot be read
void require_readable(const std::string& path);
/// Of a file that is written by a name that may be another's: a sentence for where it is there and is none of its kind.
/// @param kind such as "plan" @param mark what every file of the kind holds in its first 64 kB
/// @throws ArgumentError if the file is there, regular, and without the mark
void check_replaced(const std::string& path, const std::string& kind, const std::string& mark);
/// The same of a file in HDF5.
/// @param format its attribute of this name
/// @throws ArgumentError if the file is there, regular, and of another format
void check_replaced_hdf5(const std::string& path, const std::string& kind, const std::string& format);
/// To a file, or to stdout if the path is empty.
void write_answer(const std::string& path, const std::string& text);
/// The same of text for readers, in lines that fit: of files in the usual ones, whatever the terminal.
void write_readable(const std::string& path, const std::string& text);
/// Of a command whose result is a file: with --json, which file and how large, as one object (schema samara-file/1).
void tell_of_file(const std::string& path, bool json);

/// Of a column of an answer: what is no number (a model may derive the root of a negative one) becomes NaN, which is an
/// empty cell of a table and null in JSON, and a warning says of what and how often.
/// @return whether all were numbers
bool keep_numbers(const std::string& name, Eigen::Ref<Eigen::VectorXd, 0, Eigen::InnerStride<>> values);

Json to_json(const codebooks::Certificate& certificate, const codebooks::Codebook& book);
/// The certificate as a readable table.
std::string to_table(const codebooks::Certificate& certificate, const codebooks::Codebook& book);

/// A count to three digits, in full as far as that is read at a glance: 24900, 2740000, 1.31e+12.
std::string count_text(double count);

/// What the build of a codebook took, in the units of its builder.
std::string effort(const codebooks::Codebook& book);

/// Why the certificate of a codebook is not met; it has one.
std::string miss_of(const codebooks::Codebook& book);
/// On stderr, if the codebook has no certificate or does not meet it.
void warn_of_missed_tolerance(const codebooks::Codebook& book, const std::string& path);

}  // namespace samara::apps
