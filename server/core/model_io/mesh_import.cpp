// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/mesh_import.hpp"

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace handover {
namespace {

/// A file's text for assimp to read.
class TextStream : public Assimp::IOStream {
 public:
  explicit TextStream(const std::string& text) : text_(text) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    const std::size_t whole = size == 0 ? 0 : std::min(count, (text_.size() - at_) / size);
    std::memcpy(to, text_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }

  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }

  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t from = origin == aiOrigin_SET   ? 0
                             : origin == aiOrigin_CUR ? at_
                                                      : text_.size();
    if (offset > text_.size() - from) return aiReturn_FAILURE;
    at_ = from + offset;
    return aiReturn_SUCCESS;
  }

  std::size_t Tell() const override { return at_; }

  std::size_t FileSize() const override { return text_.size(); }

  void Flush() override {}

 private:
  const std::string& text_;
  std::size_t at_ = 0;
};

/// The one file that was asked for: materials and textures that it names are not wanted, and may be
/// pipes.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string name, const std::string& text) : name_(std::move(name)), text_(text) {}

  bool Exists(const char* name) const override { return name == name_; }

  char getOsSeparator() const override { return '/'; }

  Assimp::IOStream* Open(const char* name, const char*) override {
    return Exists(name) ? new TextStream(text_) : nullptr;
  }

  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::string name_;
  const std::string& text_;
};

Eigen::Matrix4d matrixOf(const aiMatrix4x4& m) {
  Eigen::Matrix4d out;
  out << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3,
      m.d4;
  return out;
}

MeshPiece pieceOf(const aiMesh& mesh) {
  MeshPiece piece;
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& v = mesh.mVertices[i];
    piece.vertices.push_back({v.x, v.y, v.z});
  }
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;  // points and lines
    piece.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
  }
  return piece;
}

void addNodes(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& above,
              std::vector<MeshNode>& out) {
  const Eigen::Matrix4d transform = above * matrixOf(node.mTransformation);
  if (node.mNumMeshes > 0) {
    if (*std::max_element(node.mMeshes, node.mMeshes + node.mNumMeshes) >= scene.mNumMeshes) {
      throw std::runtime_error("is damaged");
    }
    const aiString& of_mesh = scene.mMeshes[node.mMeshes[0]]->mName;
    out.push_back({of_mesh.length > 0 ? of_mesh.C_Str() : node.mName.C_Str(),
                   transform,
                   {node.mMeshes, node.mMeshes + node.mNumMeshes}});
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    addNodes(scene, *node.mChildren[i], transform, out);
  }
}

/// In the child.
ImportedMesh import(const std::string& name, const std::string& text) {
  Assimp::Importer importer;
  importer.SetIOHandler(new OneFile(name, text));  // the importer's from here on
  // URDF takes a Collada file's axes as written; assimp would turn them to y up. The unit is
  // honoured by assimp itself, in the root node's transform.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(name, aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw std::runtime_error(importer.GetErrorString());
  }
  ImportedMesh mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    mesh.pieces.push_back(pieceOf(*scene->mMeshes[i]));
  addNodes(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), mesh.nodes);
  return mesh;
}

// From child to parent, both the same program: numbers as they lie in memory.

void pack(std::uint64_t number, std::string& to) {
  to.append(reinterpret_cast<const char*>(&number), sizeof(number));
}

template <typename Items>
void packAll(const Items& items, std::string& to) {
  pack(items.size(), to);
  to.append(reinterpret_cast<const char*>(items.data()),
            items.size() * sizeof(typename Items::value_type));
}

std::string packed(const ImportedMesh& mesh) {
  std::string bytes;
  pack(mesh.pieces.size(), bytes);
  for (const MeshPiece& piece : mesh.pieces) {
    packAll(piece.vertices, bytes);
    packAll(piece.triangles, bytes);
  }
  pack(mesh.nodes.size(), bytes);
  for (const MeshNode& node : mesh.nodes) {
    packAll(node.name, bytes);
    bytes.append(reinterpret_cast<const char*>(node.transform.data()), sizeof(node.transform));
    packAll(node.pieces, bytes);
  }
  return bytes;
}

/// Trusts nothing: the child may have been damaged before it wrote. @throws std::runtime_error.
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : rest_(bytes) {}

  ImportedMesh mesh() {
    ImportedMesh mesh;
    for (std::uint64_t left = number(); left > 0; --left) mesh.pieces.push_back(piece());
    for (std::uint64_t left = number(); left > 0; --left) {
      mesh.nodes.push_back(node(mesh.pieces.size()));
    }
    return mesh;
  }

 private:
  static void expect(bool holds) {
    if (!holds) throw std::runtime_error("is damaged");
  }

  void take(void* to, std::size_t size) {
    expect(size <= rest_.size());
    if (size > 0) std::memcpy(to, rest_.data(), size);
    rest_.remove_prefix(size);
  }

  std::uint64_t number() {
    std::uint64_t number = 0;
    take(&number, sizeof(number));
    return number;
  }

  template <typename Items>
  Items all() {
    constexpr std::size_t kEach = sizeof(typename Items::value_type);
    const std::uint64_t count = number();
    expect(count <= rest_.size() / kEach);
    Items items;
    items.resize(count);
    take(items.data(), count * kEach);
    return items;
  }

  MeshPiece piece() {
    MeshPiece piece;
    piece.vertices = all<decltype(piece.vertices)>();
    piece.triangles = all<decltype(piece.triangles)>();
    for (const auto& triangle : piece.triangles) {
      for (const std::uint32_t index : triangle) expect(index < piece.vertices.size());
    }
    return piece;
  }

  MeshNode node(std::size_t pieces) {
    MeshNode node;
    node.name = all<std::string>();
    take(node.transform.data(), sizeof(node.transform));
    node.pieces = all<std::vector<std::uint32_t>>();
    expect(!node.pieces.empty());
    for (const std::uint32_t index : node.pieces) expect(index < pieces);
    return node;
  }

  std::string_view rest_;
};

}  // namespace

// What the child is given: the file's name, a zero, its text.
MeshImporter::MeshImporter()
    : import_([](const std::string& given) {
        const std::size_t name_end = given.find('\0');
        return packed(import(given.substr(0, name_end), given.substr(name_end + 1)));
      }) {}

Result<ImportedMesh> MeshImporter::read(const std::filesystem::path& file,
                                        const std::string& text) {
  const auto bytes = import_(file.string() + '\0' + text);
  if (!bytes) return bytes.error();
  try {
    return Unpacker(*bytes).mesh();
  } catch (const std::runtime_error& error) {
    return Error{ErrorCode::kInvalidInput, error.what()};
  }
}

}  // namespace handover
