#include "samara/models/bodies/mesh_file.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <string>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/bodies/mesh_shapes.h"
#include "tests/io/temporary_directory.h"

using namespace samara::models;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

std::string obj_text(const TriangleMesh& mesh) {
  std::string text = "# a body\n";
  for (const auto& p : mesh.vertices.colwise())
    text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", p[0], p[1], p[2]);
  for (const auto& t : mesh.triangles.colwise())
    text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

std::string stl_text(const TriangleMesh& mesh) {
  std::string text = "solid body\n";
  for (const auto& t : mesh.triangles.colwise()) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) {
      const auto p = mesh.vertices.col(t[k]);
      text += fmt::format("vertex {:.6e} {:.6e} {:.6e}\n", p[0], p[1], p[2]);
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid body\n";
}

std::string stl_binary(const TriangleMesh& mesh) {
  std::string bytes(80, ' ');
  const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(mesh.triangles.cols()));
  for (const auto& t : mesh.triangles.colwise()) {
    for (int k = 0; k < 3; ++k) put(0.0f);
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) put(static_cast<float>(mesh.vertices(i, t[k])));
    }
    put(std::uint16_t{0});
  }
  return bytes;
}

std::string ply_text(const TriangleMesh& mesh) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.cols(), mesh.triangles.cols());
  for (const auto& p : mesh.vertices.colwise())
    text += fmt::format("{:.9g} {:.9g} {:.9g}\n", p[0], p[1], p[2]);
  for (const auto& t : mesh.triangles.colwise()) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  return text;
}

class Files {
 public:
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(directory_ / name, std::ios::binary) << content;
    return (directory_ / name).string();
  }

 private:
  TemporaryDirectory directory_;
};

}  // namespace

TEST_CASE("a body comes back the same from OBJ, STL in text and binary, and PLY, scaled to metres") {
  const Files files;
  const TriangleMesh mesh = ellipsoid_mesh({30.0, 20.0, 2.0}, 5);
  for (const std::string& path :
       {files.write("a.obj", obj_text(mesh)), files.write("b.stl", stl_text(mesh)),
        files.write("c.STL", stl_binary(mesh)), files.write("d.ply", ply_text(mesh))}) {
    INFO(path);
    const TriangleMesh read = read_mesh(path, 1e-3);
    CHECK(read.vertices.cols() == mesh.vertices.cols());
    CHECK(read.triangles.cols() == mesh.triangles.cols());
    // Files carry seven digits.
    CHECK_THAT(enclosed_volume(read), WithinRel(1e-9 * enclosed_volume(mesh), 1e-5));
    CHECK_THAT(read.vertices.row(0).maxCoeff(), WithinRel(0.03, 1e-6));
  }
}

TEST_CASE("corners that differ by a rounding are one corner") {
  const Files files;
  const TriangleMesh mesh = ellipsoid_mesh({3.0, 2.0, 1.0}, 3);
  // Every triangle lists its corners with a wobble of 1e-7.
  TriangleMesh wobbling;
  wobbling.vertices.resize(3, 3 * mesh.triangles.cols());
  wobbling.triangles.resize(3, mesh.triangles.cols());
  for (Eigen::Index i = 0; i < 3 * mesh.triangles.cols(); ++i) {
    const double wobble = 1e-7 * static_cast<double>(i % 5 - 2);
    wobbling.vertices.col(i) = mesh.vertices.col(mesh.triangles(i % 3, i / 3)).array() + wobble;
    wobbling.triangles(i % 3, i / 3) = static_cast<int>(i);
  }
  const std::string path = files.write("wobbling.obj", obj_text(wobbling));
  CHECK(read_mesh(path, 1.0).vertices.cols() == mesh.vertices.cols());
  MeshFileOptions exact;
  exact.merge_tolerance = 0.0;
  CHECK_THROWS_WITH(read_mesh(path, 1.0, exact), Contains("not closed"));
  exact.merge_tolerance = 1e-20;
  CHECK_THROWS_WITH(read_mesh(path, 1.0, exact), Contains("merge_tolerance is 1e-20"));
}

TEST_CASE("mesh files that hold no closed surface are refused with file and place") {
  const Files files;
  TriangleMesh mesh = ellipsoid_mesh({3.0, 2.0, 1.0}, 3);
  TriangleMesh open = mesh;
  open.triangles.conservativeResize(3, mesh.triangles.cols() - 1);
  CHECK_THROWS_WITH(read_mesh(files.write("open.stl", stl_text(open)), 1.0),
                    Contains("open.stl") && Contains("not closed") && Contains("the edge between corners"));

  mesh.triangles.row(1).swap(mesh.triangles.row(2));
  const std::string inverted = files.write("inverted.ply", ply_text(mesh));
  CHECK_THROWS_WITH(read_mesh(inverted, 1.0), Contains("inside out"));
  MeshFileOptions options;
  options.turn_outward = true;
  CHECK(enclosed_volume(read_mesh(inverted, 1.0, options)) > 0.0);
}

TEST_CASE("an open surface is taken where no volume is asked of it, and a broken one is not") {
  const Files files;
  const MeshFileOptions shown{.closed = false};
  const std::string leaf = files.write("leaf.obj", "v -3.5 0 0\nv 0 2 0\nv 3.5 0 0\nv 0 -2 0\nf 1 2 3 4\n");
  const TriangleMesh mesh = read_mesh(leaf, 1e-2, shown);
  CHECK(mesh.vertices.cols() == 4);
  CHECK(mesh.triangles.cols() == 2);
  CHECK_THAT(mesh.vertices.row(0).maxCoeff(), WithinRel(0.035, 1e-6));
  CHECK_THROWS_WITH(read_mesh(leaf, 1e-2), Contains("leaf.obj") && Contains("not closed"));
  CHECK_THROWS_AS(read_mesh(files.write("points.obj", "v 0 0 0\nv 1 0 0\n"), 1.0, shown), samara::InputError);
  CHECK_THROWS_AS(read_mesh(files.write("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), 1.0, shown),
                  samara::InputError);
  CHECK_THROWS_WITH(read_mesh(files.write("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"), 1.0, shown),
                    Contains("none of its triangles has an area"));
}

TEST_CASE("files whose indices or counts lead out of them are refused before anything trusts them") {
  const Files files;
  const auto error_of = [&](const std::string& name, const std::string& text) {
    const std::string path = files.write(name, text);
    try {
      read_mesh(path, 1.0);
    } catch (const samara::InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  std::string text = ply_text(icosahedral_ellipsoid_mesh({1.0, 1.0, 1.0}, 1));
  CHECK(error_of("good.ply", text) == "no error");
  std::string claim = text;
  claim.replace(claim.find("element face 20"), 15, "element face 90000000");
  CHECK_THAT(error_of("claim.ply", claim), Contains("claims 90000000 face elements"));
  std::string beyond = text;
  beyond.replace(beyond.rfind("\n3 ") + 3, 1, "99");
  CHECK_THAT(error_of("beyond.ply", beyond), Contains("names corner 99"));
  std::string empty = text;
  empty[empty.rfind("\n3 ") + 1] = '0';
  CHECK_THAT(error_of("empty.ply", empty), Contains("face 19 has no corners"));
  std::string endless = text;
  endless.replace(endless.find("end_header"), 10, "end_head");
  CHECK_THAT(error_of("endless.ply", endless), Contains("no end, the line \"end_header\""));
  CHECK_THAT(error_of("short.ply", text.substr(0, text.rfind("\n3 "))),
             Contains("face 19 of 20 is cut short"));
  std::string word = text;
  word[word.find("end_header\n") + 11] = 'x';
  CHECK_THAT(error_of("word.ply", word), Contains("vertex 0 of 12"));
  // Other ways to write a number.
  const std::size_t first = text.find("end_header\n") + 11;
  for (const char* number : {"+0.25", "1e-400", "+1e-320", "-1e-400"}) {
    std::string other = text;
    other.replace(first, other.find(' ', first) - first, number);
    CAPTURE(number);
    CHECK_THAT(error_of("number.ply", other), !Contains("cut short or no row of numbers"));
  }
  for (const char* number : {"+-1", "++1", "1e400", "+", "nan", "inf"}) {
    std::string other = text;
    other.replace(first, other.find(' ', first) - first, number);
    CAPTURE(number);
    CHECK_THAT(error_of("number.ply", other), Contains("vertex 0 of 12"));
  }
  // A binary file cut within its last face: what stands there instead is no index.
  std::string binary =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
      "float z\n"
      "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) { binary.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const float x : {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f}) put(x);
  for (const auto& t : {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{0, 3, 2}, std::array{1, 2, 3}}) {
    put(std::uint8_t{3});
    for (const std::int32_t corner : t) put(corner);
  }
  CHECK(error_of("whole.ply", binary) == "no error");
  for (const std::size_t cut : {5U, 20U, 60U}) {
    CHECK(error_of("cut.ply", binary.substr(0, binary.size() - cut)) != "no error");
  }
}

TEST_CASE("missing, empty, foreign and broken mesh files are refused with their name") {
  const Files files;
  CHECK_THROWS_WITH(read_mesh("/nowhere/leaf.stl", 1.0), Contains("leaf.stl") && Contains("no such file"));
  CHECK_THROWS_WITH(read_mesh(files.write("leaf.gltf", "{}"), 1.0), Contains("\".gltf\" is not one of"));
  for (const char* name : {"empty.obj", "empty.stl", "empty.ply"}) {
    CHECK_THROWS_AS(read_mesh(files.write(name, ""), 1.0), samara::InputError);
  }
  CHECK_THROWS_AS(read_mesh(files.write("points.obj", "v 0 0 0\nv 1 0 0\n"), 1.0), samara::InputError);
  CHECK_THROWS_AS(read_mesh(files.write("words.stl", "this is no mesh"), 1.0), samara::InputError);
  std::string nan = obj_text(ellipsoid_mesh({1, 1, 1}, 2));
  nan.replace(nan.find("v "), nan.find('\n', nan.find("v ")) - nan.find("v "), "v nan 0 0");
  CHECK_THROWS_AS(read_mesh(files.write("nan.obj", nan), 1.0), samara::InputError);
  CHECK_THROWS_WITH(read_mesh("leaf.stl", 0.0), Contains("metres_per_unit is 0"));
}

TEST_CASE("points of a mesh file that no triangle uses are left out") {
  const Files files;
  TriangleMesh mesh = box_mesh({1.0, 1.0, 1.0}, 1, 1);
  mesh.vertices.conservativeResize(3, mesh.vertices.cols() + 1);
  mesh.vertices.rightCols<1>() << 50.0, 0.0, 0.0;
  for (const std::string& path :
       {files.write("a.obj", obj_text(mesh)), files.write("d.ply", ply_text(mesh))}) {
    CHECK(read_mesh(path, 1.0).vertices.cols() == mesh.vertices.cols() - 1);
  }
}
