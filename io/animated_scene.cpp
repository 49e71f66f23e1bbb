#include "samara/io/animated_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/io/atomic_file.h"

namespace samara::io {

namespace {

using Json = nlohmann::ordered_json;

/// A format by the ending of its files.
struct SceneFormat {
  std::string_view ending;
  std::string (*format)(const AnimatedScene&);
};

constexpr std::array<SceneFormat, 2> kSceneFormats = {{{".glb", format_glb}, {".usda", format_usda}}};

const SceneFormat* format_of(const std::filesystem::path& path) {
  const auto* const found = std::ranges::find(kSceneFormats, ending_of(path), &SceneFormat::ending);
  return found == kSceneFormats.end() ? nullptr : found;
}

[[noreturn]] void refuse_name(const std::filesystem::path& path) {
  throw ArgumentError(
      fmt::format("\"{}\" was given, expected a name that ends in .glb or .usda", path.string()));
}

bool fits_floats(const Eigen::Ref<const Eigen::MatrixXd>& numbers) {
  return numbers.array().isFinite().all() &&
         (numbers.array().abs() <= static_cast<double>(std::numeric_limits<float>::max())).all();
}

void check_body(const AnimatedBody& body) {
  const Eigen::Index count = body.times.size();
  if (count < 2 || body.positions.cols() != count || body.rotations.cols() != count) {
    throw ArgumentError(
        fmt::format("body \"{}\" has {} times, {} positions and {} rotations: as many of each, and at least "
                    "2, were expected",
                    body.name, count, body.positions.cols(), body.rotations.cols()));
  }
  if (!fits_floats(body.times) || !fits_floats(body.positions) || !fits_floats(body.rotations))
    throw ArgumentError(fmt::format("body \"{}\" has a number that is not finite", body.name));
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i > 0 && !(body.times[i] > body.times[i - 1]))
      throw ArgumentError(fmt::format("body \"{}\": time {} follows {}, increasing ones were expected",
                                      body.name, body.times[i], body.times[i - 1]));
    if (std::abs(body.rotations.col(i).norm() - 1.0) > 1e-6)
      throw ArgumentError(fmt::format("body \"{}\": the quaternion at time {} has the length {}, expected 1",
                                      body.name, body.times[i], body.rotations.col(i).norm()));
  }
}

void check_scene(const AnimatedScene& scene) {
  if (scene.bodies.empty() || scene.triangles.cols() == 0 || scene.vertices.cols() == 0)
    throw ArgumentError("a scene without a body or without a mesh was given, expected at least one of each");
  if (!fits_floats(scene.vertices)) throw ArgumentError("a corner of the mesh is not finite");
  if (scene.triangles.minCoeff() < 0 || scene.triangles.maxCoeff() >= scene.vertices.cols())
    throw ArgumentError(
        fmt::format("a triangle of the mesh has a corner that is none of its {}", scene.vertices.cols()));
  for (const AnimatedBody& body : scene.bodies) check_body(body);
}

/// The same turns, each next one on the nearer side.
Eigen::Matrix4Xd with_near_signs(Eigen::Matrix4Xd rotations) {
  for (Eigen::Index i = 1; i < rotations.cols(); ++i)
    if (rotations.col(i).dot(rotations.col(i - 1)) < 0.0) rotations.col(i) *= -1.0;
  return rotations;
}

/// The one buffer of a file, with its views and accessors.
class GltfBuffer {
 public:
  /// @param numbers a column per element  @returns the number of the accessor
  template <class Scalar>
  int add(const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& numbers, bool with_ends,
          int target = 0) {
    static_assert(sizeof(Scalar) == 4);
    Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", 4 * numbers.size()}};
    if (target != 0) view["target"] = target;
    for (const Scalar number : numbers.reshaped()) append(std::bit_cast<std::uint32_t>(number));
    constexpr int kUnsignedInt = 5125;
    constexpr int kFloat = 5126;
    const Eigen::Index rows = numbers.rows();
    Json accessor = {{"bufferView", views_.size()},
                     {"componentType", std::is_same_v<Scalar, float> ? kFloat : kUnsignedInt},
                     {"count", numbers.cols()},
                     {"type", rows == 1   ? "SCALAR"
                              : rows == 3 ? "VEC3"
                                          : "VEC4"}};
    if (with_ends) {
      for (Eigen::Index k = 0; k < rows; ++k) {
        accessor["min"].push_back(numbers.row(k).minCoeff());
        accessor["max"].push_back(numbers.row(k).maxCoeff());
      }
    }
    views_.push_back(std::move(view));
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }

  const std::string& bytes() const { return bytes_; }

  void describe(Json& file) const {
    file["accessors"] = accessors_;
    file["bufferViews"] = views_;
    file["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
  }

 private:
  void append(std::uint32_t word) {
    for (int k = 0; k < 4; ++k) bytes_ += static_cast<char>((word >> (8 * k)) & 255U);
  }

  std::string bytes_;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
};

/// From z up to y up.
Eigen::Matrix3Xd y_up(const Eigen::Matrix3Xd& vectors) {
  Eigen::Matrix3Xd result(3, vectors.cols());
  result << vectors.row(0), vectors.row(2), -vectors.row(1);
  return result;
}

/// Places of the keys that single floats tell apart.
std::vector<Eigen::Index> distinct_keys(const Eigen::VectorXf& times) {
  std::vector<Eigen::Index> keys = {0};
  for (Eigen::Index i = 1; i < times.size(); ++i)
    if (times[i] > times[keys.back()]) keys.push_back(i);
  return keys;
}

/// The channels of a body, added to an animation.
void animate(const AnimatedBody& body, int node, GltfBuffer& buffer, Json& animation) {
  const Eigen::VectorXf times = (body.times.array() - body.times[0]).cast<float>();
  const std::vector<Eigen::Index> keys = distinct_keys(times);
  const Eigen::Matrix3Xd positions = y_up(body.positions);
  const Eigen::Matrix4Xd signed_rotations = with_near_signs(body.rotations);
  Eigen::Matrix4Xd rotations(4, signed_rotations.cols());  // x, y, z, w
  rotations << y_up(signed_rotations.bottomRows<3>()), signed_rotations.row(0);
  const int input = buffer.add<float>(times(keys).transpose().eval(), true);
  const auto add = [&](const char* path, int output) {
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    animation["samplers"].push_back({{"input", input}, {"interpolation", "LINEAR"}, {"output", output}});
  };
  add("translation", buffer.add<float>(positions(Eigen::all, keys).cast<float>().eval(), false));
  add("rotation", buffer.add<float>(rotations(Eigen::all, keys).cast<float>().eval(), false));
}

Json extras_of(const AnimatedScene& scene) {
  Json extras = Json::object();
  for (const auto& [key, text] : scene.notes) extras[key] = text;
  extras["parameters"] = scene.parameters;
  return extras;
}

void append_chunk(std::string& file, const char* kind, std::string content, char filler) {
  const auto append = [&](std::size_t word) {
    for (int k = 0; k < 4; ++k) file += static_cast<char>((word >> (8 * k)) & 255U);
  };
  while (content.size() % 4 != 0) content += filler;
  append(content.size());
  file.append(kind, 4);
  file += content;
}

/// Of a text in a .usda file.
std::string usda_text(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (c == '\n') {
      result += "\\n";
    } else {
      result += c;
    }
  }
  return result + '"';
}

}  // namespace

std::string format_glb(const AnimatedScene& scene) {
  check_scene(scene);
  constexpr int kVertices = 34962;
  constexpr int kIndices = 34963;
  GltfBuffer buffer;
  const int corners = buffer.add<float>(y_up(scene.vertices).cast<float>().eval(), true, kVertices);
  const Eigen::MatrixXi triangles = scene.triangles.reshaped(1, scene.triangles.size());
  const int indices = buffer.add<std::uint32_t>(triangles.cast<std::uint32_t>().eval(), false, kIndices);
  Json file = {
      {"asset", {{"version", "2.0"}, {"generator", "samara"}}},
      {"scene", 0},
      {"scenes",
       Json::array({{{"name", scene.name}, {"nodes", Json::array()}, {"extras", extras_of(scene)}}})},
      {"nodes", Json::array()}};
  file["meshes"] = Json::array(
      {{{"primitives",
         Json::array({{{"attributes", {{"POSITION", corners}}}, {"indices", indices}, {"material", 0}}})}}});
  file["materials"] = Json::array(
      {{{"pbrMetallicRoughness",
         {{"baseColorFactor", {0.55, 0.33, 0.16, 1.0}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.8}}},
        {"doubleSided", true}}});
  Json animation = {{"name", scene.name}, {"channels", Json::array()}, {"samplers", Json::array()}};
  for (const AnimatedBody& body : scene.bodies) {
    const int node = static_cast<int>(file["nodes"].size());
    file["nodes"].push_back({{"name", body.name}, {"mesh", 0}, {"extras", {{"start", body.times[0]}}}});
    file["scenes"][0]["nodes"].push_back(node);
    animate(body, node, buffer, animation);
  }
  file["animations"] = Json::array({std::move(animation)});
  buffer.describe(file);
  std::string chunks;
  append_chunk(chunks, "JSON", file.dump(-1, ' ', false, Json::error_handler_t::replace), ' ');
  append_chunk(chunks, std::string_view("BIN\0", 4).data(), buffer.bytes(), '\0');
  constexpr std::size_t kHeader = 12;
  const std::size_t length = kHeader + chunks.size();
  if (length > std::numeric_limits<std::uint32_t>::max())
    throw ArgumentError(fmt::format("the animation has {:.1f} GB, more than a .glb file can hold",
                                    1e-9 * static_cast<double>(length)));
  std::string result = "glTF";
  for (const std::size_t word : {std::size_t{2}, length})
    for (int k = 0; k < 4; ++k) result += static_cast<char>((word >> (8 * k)) & 255U);
  return result + chunks;
}

std::string format_usda(const AnimatedScene& scene) {
  check_scene(scene);
  constexpr double kCodesPerSecond = 24.0;
  double end = 0.0;
  for (const AnimatedBody& body : scene.bodies)
    end = std::max(end, kCodesPerSecond * (body.times[body.times.size() - 1] - body.times[0]));
  std::string text = "#usda 1.0\n(\n    defaultPrim = \"scene\"\n    upAxis = \"Z\"\n    metersPerUnit = 1\n";
  text += fmt::format("    timeCodesPerSecond = {}\n    startTimeCode = 0\n    endTimeCode = {}\n",
                      kCodesPerSecond, end);
  text += "    customLayerData = {\n";
  text += fmt::format("        string name = {}\n", usda_text(scene.name));
  for (const auto& [key, value] : scene.notes)
    text += fmt::format("        string {} = {}\n", usda_text(key), usda_text(value));
  text += "        dictionary parameters = {\n";
  for (const auto& [key, value] : scene.parameters)
    text += fmt::format("            double {} = {}\n", usda_text(key), value);
  text +=
      "        }\n    }\n)\n\nclass Mesh \"_shape\"\n{\n    uniform token subdivisionScheme = \"none\"\n"
      "    uniform bool doubleSided = true\n";
  std::string points, corners;
  for (const auto& v : scene.vertices.colwise())
    points += fmt::format("{}({}, {}, {})", points.empty() ? "" : ", ", v.x(), v.y(), v.z());
  for (const int corner : scene.triangles.reshaped())
    corners += fmt::format("{}{}", corners.empty() ? "" : ", ", corner);
  text += fmt::format("    point3f[] points = [{}]\n    int[] faceVertexIndices = [{}]\n", points, corners);
  const Eigen::Vector3d low = scene.vertices.rowwise().minCoeff(), high = scene.vertices.rowwise().maxCoeff();
  text += fmt::format("    float3[] extent = [({}, {}, {}), ({}, {}, {})]\n", low.x(), low.y(), low.z(),
                      high.x(), high.y(), high.z());
  std::string counts = "3";
  for (Eigen::Index k = 1; k < scene.triangles.cols(); ++k) counts += ", 3";
  text += fmt::format("    int[] faceVertexCounts = [{}]\n}}\n\ndef Xform \"scene\"\n{{\n", counts);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const AnimatedBody& body = scene.bodies[b];
    const Eigen::Matrix4Xd rotations = with_near_signs(body.rotations);
    text += fmt::format(
        "    def Mesh \"body_{}\" (\n        inherits = </_shape>\n        displayName = {}\n        "
        "customData = "
        "{{\n            double start = {}\n        }}\n    )\n    {{\n",
        b, usda_text(body.name), body.times[0]);
    std::string places, turns;
    for (Eigen::Index i = 0; i < body.times.size(); ++i) {
      const double code = kCodesPerSecond * (body.times[i] - body.times[0]);
      places += fmt::format("            {}: ({}, {}, {}),\n", code, body.positions(0, i),
                            body.positions(1, i), body.positions(2, i));
      turns += fmt::format("            {}: ({}, {}, {}, {}),\n", code, rotations(0, i), rotations(1, i),
                           rotations(2, i), rotations(3, i));
    }
    text += fmt::format("        double3 xformOp:translate.timeSamples = {{\n{}        }}\n", places);
    text += fmt::format("        quatd xformOp:orient.timeSamples = {{\n{}        }}\n", turns);
    text += "        uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]\n    }\n";
  }
  return text + "}\n";
}

bool is_scene_name(const std::filesystem::path& path) {
  return format_of(path) != nullptr;
}

void check_scene_name(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 4> kOthers = {".gltf", ".fbx", ".usd", ".usdz"};
  if (std::ranges::count(kOthers, ending_of(path)) > 0) refuse_name(path);
}

void write_scene(const std::filesystem::path& path, const AnimatedScene& scene) {
  const SceneFormat* format = format_of(path);
  if (format == nullptr) refuse_name(path);
  write_text_atomically(path, format->format(scene));
}

}  // namespace samara::io
