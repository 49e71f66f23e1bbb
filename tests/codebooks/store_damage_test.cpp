#include "damaged_codebook.h"
#include "samara/io/hdf5_writer.h"

// Files that are cut, changed, or lack a part.

#ifdef __SANITIZE_ADDRESS__
// HDF5 1.10 loses memory when it meets damaged metadata.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}
#endif

using namespace damaged_codebook;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

TEST_CASE("a file that was only touched is still the same codebook") {
  CHECK(error_after([](Patient&) {}) == "no exception");
  // And the ways of this test to change a file do not damage it by themselves.
  CHECK(error_after([](Patient& file) {
          file.set_dataset("/pieces/0/groups/0/weights", {2, kRank}, numbers(2 * kRank));
          file.set_dataset("/pieces/0/axes/v(0)", {kInitialNodes}, {-0.3, -0.1, 0.05, 0.6});
          file.set_text("/", "format_version", "0.1");
          file.set_integer("/pieces/0/axes/t", "index", 0);
          file.set_numbers("/pieces/0/axes/C_D", "borders", {0.5, 1.0});
        }) == "no exception");
}

TEST_CASE("what is not a file, or not HDF5, is no codebook") {
  const TemporaryDirectory directory;
  CHECK_THAT(load_error(directory / "none.h5"), Contains("none.h5: the file does not exist"));
  CHECK_THAT(load_error(directory.path()), Contains("is not a regular file"));
  put_content(directory / "text.h5", "t[s],x[m]\n0,1\n");
  CHECK_THAT(load_error(directory / "text.h5"),
             Contains("text.h5: is not an HDF5 file but a text, expected a codebook"));
}

TEST_CASE("an HDF5 file of something else is no codebook") {
  const TemporaryDirectory directory;
  samara::io::Hdf5Writer writer(directory / "other.h5");
  writer.write_vector("/x", Eigen::Vector3d(1, 2, 3));
  writer.commit();
  CHECK_THAT(load_error(directory / "other.h5"),
             Contains("other.h5: /: attribute format is not \"samara-codebook\": this is not a codebook"));
  CHECK_THAT(
      error_after([](Patient& file) { file.set_text("/", "format", "samara-checkpoint"); }),
      Contains("attribute format is \"samara-checkpoint\", not \"samara-codebook\": this is not a codebook"));
  CHECK_THAT(error_after([](Patient& file) { file.set_integer("/", "format", 3); }), Contains("format"));
}

TEST_CASE("a certificate that contradicts itself, or has no numbers, is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto with = [](const std::string& object, const std::string& name, double value) {
    return error_after([&](Patient& file) { file.set_number(object, name, value); });
  };
  CHECK_THAT(with("/certificate", "tolerance", nan), StartsWith("/certificate: tolerance is nan"));
  CHECK_THAT(with("/certificate", "tolerance", infinity), StartsWith("/certificate: tolerance is inf"));
  CHECK_THAT(with("/certificate", "max_error", nan), StartsWith("/certificate: max_error is nan"));
  CHECK_THAT(with("/certificate", "residual", infinity), StartsWith("/certificate: residual is inf"));
  CHECK_THAT(with("/certificate/x", "p95", nan), StartsWith("/certificate/x: p95 is nan"));
  CHECK_THAT(with("/certificate", "max_error", 0.5),
             StartsWith("/certificate: met is 1, but max_error 0.5 is more than the tolerance"));
  CHECK_THAT(error_after([](Patient& file) { file.set_integer("/certificate", "met", 7); }),
             StartsWith("/certificate: met is 7, expected 0 or 1"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/certificate", "seed", "x"); }),
             StartsWith("/certificate: seed is \"x\""));
  CHECK_THAT(error_after([](Patient& file) { file.set_integer("/certificate", "points", 0); }),
             StartsWith("/certificate: points is 0, expected at least 1 where met is 1"));
  CHECK_THAT(error_after([](Patient& file) { file.set_integer("/certificate", "failed_points", 2000); }),
             StartsWith("/certificate: failed_points is 2000, expected at most 1999 of 2000 points"));
  CHECK_THAT(error_after([](Patient& file) {
               file.set_integer("/certificate", "met", 0);
               file.set_integer("/certificate", "failed_points", 2001);
             }),
             StartsWith("/certificate: failed_points is 2001, expected at most 2000"));
  CHECK_THAT(error_after([](Patient& file) {
               file.set_numbers("/certificate/x", "worst", {1.0, 2.0});
             }),
             StartsWith("/certificate/x: worst has 2 numbers, expected "));
  CHECK_THAT(error_after([](Patient& file) { file.rename("/certificate/x", "/certificate/y"); }),
             StartsWith("/certificate: is of the outputs") && Contains("those of the codebook are"));
  CHECK_THAT(error_after([](Patient& file) { file.remove("/certificate/x"); }),
             StartsWith("/certificate: is of the outputs"));
  // What was missed may be missed by infinity.
  CHECK(error_after([&](Patient& file) {
          file.set_integer("/certificate", "met", 0);
          file.set_number("/certificate", "max_error", infinity);
        }) == "no exception");
}

TEST_CASE("a file whose parts say different things is refused") {
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/", "model", "other"); }),
             StartsWith("/: model is \"other\", but /model has the name \"vertical_fall\""));
  CHECK_THAT(error_after([](Patient& file) {
               for (const char* piece : {"0", "1", "2", "3"})
                 file.set_text(std::string("/pieces/") + piece + "/axes/v(0)", "units", "kg");
             }),
             StartsWith("/pieces/0/axes/v(0): units are \"kg\", those of the model \"m/s\""));
  CHECK_THAT(error_after([](Patient& file) { file.copy("/pieces/0", "/pieces/4"); }),
             StartsWith("/pieces/4: has the same box as /pieces/0"));
}

TEST_CASE("a file cut at any length is refused") {
  const TemporaryDirectory directory;
  save(certified(), directory / "book.h5");
  const std::string whole = content(directory / "book.h5");
  for (const double part : {0.0, 0.0005, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.9999}) {
    put_content(directory / "cut.h5",
                whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
    INFO(part);
    CHECK_THAT(load_error(directory / "cut.h5"),
               Contains("cut.h5: ") && (Contains("truncated") || Contains("not an HDF5 file")));
  }
}

TEST_CASE("a byte changed anywhere gives an input error or the same codebook, never a crash") {
  const TemporaryDirectory directory;
  const Codebook book = certified();
  save(book, directory / "book.h5");
  const std::string whole = content(directory / "book.h5");
  int refused = 0;
  for (std::size_t at = 0; at < whole.size(); at += 211) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    put_content(directory / "bad.h5", damaged);
    INFO("byte " << at << " of " << whole.size());
    const std::string error = load_error(directory / "bad.h5");
    CHECK_THAT(error, StartsWith("no exception") || Contains("bad.h5: "));
    if (error == "no exception") {
      check_same_codebook(load(directory / "bad.h5"), book);
    } else {
      ++refused;
    }
  }
  CHECK(refused > 50);
}

TEST_CASE("older minor versions of the format are read, newer and other major ones refused") {
  const auto version = [](const std::string& text) {
    return error_after([&](Patient& file) { file.set_text("/", "format_version", text); });
  };
  CHECK(version("0.7") == "no exception");
  CHECK(version("0.6") == "no exception");
  CHECK(version("0.5") == "no exception");
  CHECK(version("0.4") == "no exception");
  CHECK(version("0.3") == "no exception");
  CHECK(version("0.2") == "no exception");
  CHECK(version("0.1") == "no exception");
  CHECK(version("0.0") == "no exception");
  for (const std::string other : {"0.8", "0.10", "1.0", "1.1", "10.0", "-1.0", "0.-1", "0", "0.", ".1",
                                  "0.1 ", "0.1x", "0.1.0", "0,1", "x", "", "0.99999999999999999999"}) {
    CHECK(version(other) == "/: format_version is \"" + other + "\", this program reads 0.0 to 0.7");
  }
  CHECK_THAT(error_after([](Patient& file) { file.remove_attribute("/", "format_version"); }),
             Contains("format_version"));
}

TEST_CASE("a part that is missing is named") {
  for (const std::string path :
       {"/pieces", "/pieces/0/axes", "/pieces/0/axes/C_D", "/pieces/0/groups", "/pieces/0/groups/1",
        "/pieces/1/groups/0/outputs", "/pieces/1/groups/0/units", "/pieces/1/groups/0/weights",
        "/pieces/3/groups/1/factors/t", "/pieces/2/groups/0/factors", "/model", "/model/fixed", "/build",
        "/provenance"}) {
    INFO(path);
    const std::string error = error_after([&](Patient& file) { file.remove(path); });
    CHECK(error != "no exception");
    // A factor matrix whose axis is gone stays unread, but then pieces differ; a group that is gone leaves a
    // piece with other outputs.
    if (path == "/pieces/0/axes/C_D" || path == "/pieces/0/groups/1") {
      CHECK_THAT(error, Contains("/pieces/0/axes") || Contains("/: pieces of a codebook"));
    } else {
      CHECK_THAT(error, Contains(path));
    }
  }
  CHECK_THAT(error_after([](Patient& file) { file.remove("/pieces/1"); }),
             Contains("/pieces: member 1 of 3 is missing"));
  CHECK_THAT(error_after([](Patient& file) {
               file.remove("/pieces");
               file.create_group("/pieces");
             }),
             Contains("/pieces: is empty"));
  // A codebook may be without certificate.
  CHECK(error_after([](Patient& file) { file.remove("/certificate"); }) == "no exception");
}

TEST_CASE("an attribute that is missing is named with its object") {
  struct Attribute {
    std::string object, name;
  };
  for (const auto& [object, name] : std::vector<Attribute>{{"/", "title"},
                                                           {"/pieces/0/axes/t", "index"},
                                                           {"/pieces/0/axes/t", "units"},
                                                           {"/pieces/0/axes/t", "role"},
                                                           {"/pieces/0/axes/t", "basis"},
                                                           {"/pieces/0/axes/t", "transform"},
                                                           {"/pieces/0/axes/t", "degree"},
                                                           {"/pieces/0/axes/t", "borders"},
                                                           {"/pieces/0/groups/0", "kind"},
                                                           {"/model", "equations"},
                                                           {"/model/fixed/g", "units"},
                                                           {"/build", "status"},
                                                           {"/build", "evaluations"},
                                                           {"/provenance", "plan"},
                                                           {"/certificate", "met"},
                                                           {"/certificate", "seed"},
                                                           {"/certificate/x", "range"},
                                                           {"/certificate/x", "worst"}}) {
    INFO(object << " " << name);
    const std::string error = error_after([&](Patient& file) { file.remove_attribute(object, name); });
    CHECK_THAT(error, Contains(object) && Contains(name) && Contains("missing"));
  }
}

TEST_CASE("a mesh that is none is refused in a sentence that says what is wrong") {
  struct Damage {
    std::string path;
    std::vector<hsize_t> size;
    std::vector<double> values;
    std::string sentence;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string cells = "/mesh/cells", points = "/mesh/points", mass = "/pieces/0/mass/node/values";
  const std::vector<double> square = {0, 0, 1, 0, 0, 1, 1, 1};
  for (const Damage& damage : std::vector<Damage>{
           {cells, {2, 3}, {0, 1, 2, 3, 2, -1}, "/mesh/cells: holds -1, expected numbers of nodes"},
           {cells, {2, 3}, {0, 1, 2, 3, 2, 4}, "/mesh: cell 1 of a mesh has the corner 4, expected a node"},
           {cells, {2, 3}, {0, 1, 2, 3, 2, 1e300}, "/mesh/cells: holds 1e+300, expected numbers of nodes"},
           {cells, {2, 3}, {0, 1, 0.5, 3, 2, 1}, "/mesh/cells: holds 0.5, expected numbers of nodes"},
           {cells, {2, 3}, {0, 1, nan, 3, 2, 1}, "dataset /mesh/cells: expected finite numbers"},
           {cells, {2, 3}, {0, 1, 1, 3, 2, 1}, "/mesh: cell 0 of a mesh has no volume"},
           {cells, {2, 2}, {0, 1, 3, 2}, "/mesh: the cells of a mesh are 2 x 2, expected 3 corners x cells"},
           {cells, {0, 3}, {}, "/mesh"},
           {points, {4, 2}, {0, 0, 1, 0, 0, 1, 1, nan}, "dataset /mesh/points: expected finite"},
           {points,
            {4, 2},
            {-1e308, 0, 1e308, 0, 0, 1, 1, 1},
            "/mesh: a point of a mesh is not finite, or too far"},
           {points, {4, 2}, {0, 0, 1, 0, 2, 0, 1, 1}, "/mesh: cell 0 of a mesh has no volume"},
           {points,
            {3, 2},
            {0, 0, 1, 0, 0, 1},
            "/mesh: cell 1 of a mesh has the corner 3, expected a node from 0 to 2"},
           {points,
            {5, 2},
            {0, 0, 1, 0, 0, 1, 1, 1, 2, 2},
            "/: a mesh of 5 nodes was given for the axis \"node\""},
           {points, {2, 4}, square, "/mesh: the points of a mesh are 4 x 2, expected 2 directions x nodes"},
           {points, {0, 2}, {}, "/mesh"},
           {mass, {9}, numbers(9, -1.0), "/pieces/0/axes/node: "},
           {mass, {9}, numbers(9, 1.0), "/pieces/0/axes/node: "},
           {mass, {9}, numbers(9, nan), "dataset /pieces/0/mass/node/values: expected finite"},
           {mass, {8}, numbers(8, 0.1), "dataset /pieces/0/mass/node/rows: expected 8 rows"}}) {
    INFO(damage.path << " of " << damage.values.size() << ": " << damage.sentence);
    CHECK_THAT(error_after([&](Patient& file) { file.set_dataset(damage.path, damage.size, damage.values); },
                           golden_mesh()),
               StartsWith(damage.sentence));
  }
  CHECK_THAT(
      error_after([](Patient& file) { file.set_text("/mesh", "units", "furlongs per moon"); }, golden_mesh()),
      StartsWith("/mesh: ") && Contains("furlongs"));
  CHECK_THAT(error_after([](Patient& file) { file.remove("/mesh/cells"); }, golden_mesh()),
             Contains("/mesh/cells"));
}

TEST_CASE("a front that contradicts its piece, or is none, is refused where it stands") {
  const auto numbers = [](int count, double value) {
    return std::vector<double>(static_cast<std::size_t>(count), value);
  };
  const std::string front = "/pieces/0/front", place = front + "/place";
  const auto with_place = [&](const std::vector<double>& values) {
    return error_after([&](Patient& file) { file.set_dataset(place, {values.size()}, values); },
                       golden_front());
  };
  CHECK_THAT(with_place(numbers(6, 0.2)), StartsWith(front) && Contains("leaves its interval"));
  CHECK_THAT(with_place(numbers(5, 0.1)), StartsWith(front) && Contains("by 5 coefficients; 6"));
  CHECK_THAT(with_place(numbers(6, std::nan(""))), StartsWith("dataset " + place));
  CHECK_THAT(error_after([&](Patient& file) { file.set_text(front, "coordinate", "t"); }, golden_front()),
             StartsWith(front) && Contains("axis \"t\""));
  CHECK_THAT(error_after([&](Patient& file) { file.set_text(front, "coordinate", "D"); }, golden_front()),
             StartsWith(front) && Contains("\"D\""));
  CHECK_THAT(error_after([&](Patient& file) { file.set_text(front, "coordinate", "k"); }, golden_front()),
             StartsWith(front));
  CHECK_THAT(error_after([&](Patient& file) { file.remove(place); }, golden_front()), Contains(place));
}
