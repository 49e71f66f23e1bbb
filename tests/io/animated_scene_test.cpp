#include "samara/io/animated_scene.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <string>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/io/text_file.h"
#include "temporary_directory.h"

using samara::ArgumentError;
using samara::io::AnimatedScene;

namespace {

AnimatedScene scene() {
  AnimatedScene s;
  s.name = "a \"scene\"";
  s.vertices = Eigen::Matrix3Xd::Identity(3, 3);
  s.triangles = Eigen::Vector3i(0, 1, 2);
  for (const char* name : {"first", "second"}) {
    s.bodies.push_back(
        {name, Eigen::Vector2d(1.0, 2.0), Eigen::Matrix3Xd::Zero(3, 2), Eigen::Matrix4Xd::Zero(4, 2)});
    s.bodies.back().rotations.row(0).setOnes();
  }
  return s;
}

std::uint32_t word_at(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

}  // namespace

TEST_CASE("an animation has a node for each body, one mesh, and chunks as long as it says") {
  const std::string file = samara::io::format_glb(scene());
  CHECK(file.substr(0, 4) == "glTF");
  CHECK(word_at(file, 4) == 2);
  CHECK(word_at(file, 8) == file.size());
  const std::size_t json = word_at(file, 12);
  CHECK(file.substr(16, 4) == "JSON");
  CHECK(word_at(file, 20 + json) + 28 + json == file.size());
  const std::string text = file.substr(20, json);
  CHECK(count(text, "\"mesh\":0") == 2);
  CHECK(count(text, "\"path\":\"rotation\"") == 2);
  CHECK(count(text, "\"primitives\"") == 1);
  CHECK(count(text, R"("a \"scene\"")") == 2);  // of the scene, and of its animation
  CHECK(count(samara::io::format_usda(scene()), "inherits = </_shape>") == 2);
  CHECK(count(samara::io::format_usda(scene()), "float3[] extent = [(0, 0, 0), (1, 1, 1)]") == 1);
}

TEST_CASE("players draw both sides of a mesh, which may be open") {
  CHECK(count(samara::io::format_glb(scene()), "\"doubleSided\":true") == 1);
  CHECK(count(samara::io::format_usda(scene()), "uniform bool doubleSided = true\n") == 1);
}

TEST_CASE("rotations take the shorter way, and keys that single floats cannot tell apart become one") {
  AnimatedScene s = scene();
  s.bodies.resize(1);
  s.bodies[0].times = Eigen::Vector3d(5.0, 6.0, std::nextafter(6.0, 7.0));
  s.bodies[0].positions = Eigen::Matrix3Xd::Zero(3, 3);
  s.bodies[0].rotations = Eigen::Matrix4Xd::Zero(4, 3);
  s.bodies[0].rotations.row(0) << 1.0, -1.0, 1.0;
  const std::string file = samara::io::format_glb(s);
  // Corners 36, triangle 12, times 8, positions 24, rotations 32 bytes: two keys.
  const std::size_t begin = 28 + word_at(file, 12);
  REQUIRE(file.size() == begin + 112);
  for (const std::size_t key : {0, 1}) {
    float w = 0.0F;
    std::memcpy(&w, file.data() + begin + 80 + 16 * key + 12, 4);
    CHECK(w == 1.0F);
  }
}

TEST_CASE("what is no scene is refused") {
  const auto refused = [](const std::function<void(AnimatedScene&)>& change) {
    AnimatedScene s = scene();
    change(s);
    CHECK_THROWS_AS(samara::io::format_glb(s), ArgumentError);
    CHECK_THROWS_AS(samara::io::format_usda(s), ArgumentError);
  };
  refused([](AnimatedScene& s) { s.bodies.clear(); });
  refused([](AnimatedScene& s) { s.triangles(0) = 3; });
  refused([](AnimatedScene& s) { s.vertices(1, 1) = std::numeric_limits<double>::quiet_NaN(); });
  refused([](AnimatedScene& s) { s.bodies[0].times[1] = 1.0; });
  refused([](AnimatedScene& s) { s.bodies[1].rotations(0, 1) = 0.9; });
  refused([](AnimatedScene& s) { s.bodies[1].positions.resize(3, 1); });
  refused([](AnimatedScene& s) { s.bodies[1].positions(0, 0) = 1e300; });
}

TEST_CASE("a scene is written as the ending of the file's name says, and not under another") {
  const TemporaryDirectory directory;
  for (const char* ending : {".glb", ".usda", ".GLB", ".Usda"}) {
    const auto file = directory / (std::string("scene") + ending);
    REQUIRE(samara::io::is_scene_name(file));
    CHECK_NOTHROW(samara::io::check_scene_name(file));
    samara::io::write_scene(file, scene());
    const bool is_glb = samara::ending_of(file) == ".glb";
    const std::string expected = is_glb ? samara::io::format_glb(scene()) : samara::io::format_usda(scene());
    CHECK(samara::io::read_text_file(file) == expected);
  }
  const auto table = directory / "scene.csv";
  CHECK_FALSE(samara::io::is_scene_name(table));
  CHECK_NOTHROW(samara::io::check_scene_name(table));
  for (const char* other : {"scene.gltf", "scene.fbx", "scene.usd", "scene.USDZ"}) {
    CHECK_FALSE(samara::io::is_scene_name(other));
    CHECK_THROWS_WITH(samara::io::check_scene_name(other),
                      "\"" + std::string(other) + "\" was given, expected a name that ends in .glb or .usda");
  }
  CHECK_THROWS_AS(samara::io::write_scene(table, scene()), ArgumentError);
}
