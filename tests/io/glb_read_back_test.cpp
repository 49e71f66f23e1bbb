// Animations through the eyes of a reader that others wrote: assimp.
#include <cmath>
#include <string>

#include <assimp/Importer.hpp>
#include <assimp/scene.h>
#include <catch2/catch.hpp>

#include "samara/io/animated_scene.h"

namespace {

/// Two bodies that turn and move at uneven times, the second from 2 s on.
samara::io::AnimatedScene turning_pair() {
  samara::io::AnimatedScene s;
  s.name = "pair";
  s.vertices.resize(3, 4);
  s.vertices << 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3;
  s.triangles.resize(3, 4);
  s.triangles << 0, 0, 0, 1, 2, 1, 3, 2, 1, 3, 2, 3;
  s.notes = {{"model", "a model"}, {"seed", "7"}};
  s.parameters = {{"C_D", 1.25}};
  for (const double start : {0.5, 2.0}) {
    samara::io::AnimatedBody body{.name = start < 1.0 ? "early" : "late",
                                  .times = Eigen::VectorXd(5),
                                  .positions = Eigen::Matrix3Xd(3, 5),
                                  .rotations = Eigen::Matrix4Xd(4, 5)};
    for (Eigen::Index i = 0; i < 5; ++i) {
      const double t = start + 0.1 * static_cast<double>(i * i);
      body.times[i] = t;
      body.positions.col(i) << std::sin(t), std::cos(3.0 * t), -t * t;
      body.rotations.col(i) =
          Eigen::Vector4d(std::cos(t), 0.36 * std::sin(t), 0.48 * std::sin(t), 0.8 * std::sin(t));
    }
    s.bodies.push_back(body);
  }
  return s;
}

}  // namespace

TEST_CASE("another library reads the nodes, mesh, keys and poses of an animation as they were given") {
  const samara::io::AnimatedScene given = turning_pair();
  const std::string file = samara::io::format_glb(given);
  Assimp::Importer importer;
  const aiScene* read = importer.ReadFileFromMemory(file.data(), file.size(), 0, "glb");
  INFO(importer.GetErrorString());
  REQUIRE(read != nullptr);
  REQUIRE(read->mNumMeshes == 1);
  // Corners may come once for each triangle; x stays, z is up in y.
  const aiMesh& mesh = *read->mMeshes[0];
  REQUIRE(mesh.mNumFaces == 4);
  for (unsigned f = 0; f < 4; ++f) {
    for (unsigned k = 0; k < 3; ++k) {
      const aiVector3D& corner = mesh.mVertices[mesh.mFaces[f].mIndices[k]];
      const Eigen::Vector3d v = given.vertices.col(given.triangles(k, f));
      CHECK((Eigen::Vector3d(corner.x, corner.y, corner.z) - Eigen::Vector3d(v.x(), v.z(), -v.y())).norm() <
            1e-6);
    }
  }
  REQUIRE(read->mNumAnimations == 1);
  const aiAnimation& animation = *read->mAnimations[0];
  REQUIRE(animation.mNumChannels == 2);
  for (const samara::io::AnimatedBody& body : given.bodies) {
    const aiNode* node = read->mRootNode->FindNode(body.name.c_str());
    REQUIRE(node != nullptr);
    CHECK(node->mNumMeshes == 1);
    double start = 0.0;
    REQUIRE(node->mMetaData != nullptr);
    CHECK(node->mMetaData->Get("start", start));
    CHECK(start == body.times[0]);
    const aiNodeAnim* channel = nullptr;
    for (unsigned c = 0; c < 2; ++c) {
      if (body.name == animation.mChannels[c]->mNodeName.C_Str()) channel = animation.mChannels[c];
    }
    REQUIRE(channel != nullptr);
    REQUIRE(channel->mNumPositionKeys == 5);
    REQUIRE(channel->mNumRotationKeys == 5);
    for (unsigned i = 0; i < 5; ++i) {
      const double t = body.times[i] - body.times[0];
      CHECK(channel->mPositionKeys[i].mTime / animation.mTicksPerSecond == Approx(t).margin(1e-6));
      CHECK(channel->mRotationKeys[i].mTime / animation.mTicksPerSecond == Approx(t).margin(1e-6));
      const aiVector3D& p = channel->mPositionKeys[i].mValue;
      const Eigen::Vector3d at = body.positions.col(i);
      CHECK((Eigen::Vector3d(p.x, p.y, p.z) - Eigen::Vector3d(at.x(), at.z(), -at.y())).norm() < 1e-5);
      const aiQuaternion& q = channel->mRotationKeys[i].mValue;
      const Eigen::Vector4d turn = body.rotations.col(i);
      const Eigen::Vector4d expected(turn[0], turn[1], turn[3], -turn[2]);
      CHECK(std::abs(Eigen::Vector4d(q.w, q.x, q.y, q.z).dot(expected)) == Approx(1.0).margin(1e-6));
    }
  }
}
