// SPDX-License-Identifier: Apache-2.0
#include "view/mesh_file.hpp"

#include <handover/client/plan_file.hpp>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace handover::view {
namespace {

void collect(const aiScene& scene, const aiNode& node, const aiMatrix4x4& X_above,
             std::vector<Eigen::Vector3d>& corners) {
  const aiMatrix4x4 X = X_above * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      if (mesh.mFaces[f].mNumIndices != 3) continue;  // points and lines bound nothing
      for (unsigned k = 0; k < 3; ++k) {
        const aiVector3D p = X * mesh.mVertices[mesh.mFaces[f].mIndices[k]];
        corners.emplace_back(p.x, p.y, p.z);
      }
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) collect(scene, *node.mChildren[c], X, corners);
}

}  // namespace

std::vector<Eigen::Vector3d> meshTriangles(const std::filesystem::path& file) {
  Assimp::Importer importer;
  // A robot's frames are those of the file: no turning to y-up.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw client::PlanFileError(file.string(), importer.GetErrorString());
  }
  std::vector<Eigen::Vector3d> corners;
  collect(*scene, *scene->mRootNode, aiMatrix4x4(), corners);
  if (corners.empty()) throw client::PlanFileError(file.string(), "no triangle in it");
  return corners;
}

}  // namespace handover::view
