// SPDX-License-Identifier: Apache-2.0
#include "cells/decomposition_cache.hpp"

#include "core/decomposition/decomposition_file.hpp"
#include "support/meshes.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

namespace fs = std::filesystem;

class PartsCacheTest : public ::testing::Test {
 protected:
  std::size_t parts(bool force = false) const {
    const auto made = DecompositionCache(folder_.path(), force)(mesh_);
    return made ? made->size() : 0;
  }

  fs::path file() const {
    for (const auto& entry : fs::directory_iterator(folder_ / "parts")) return entry.path();
    return {};
  }

  test::TemporaryFolder folder_;
  TriangleMesh mesh_ = test::angleMesh();  // two parts
  /// What no angle is divided into: seen again, it was read.
  std::vector<TriangleMesh> other_{3, test::boxMesh({0, 0, 0}, {1, 1, 1})};
};

TEST_F(PartsCacheTest, MakesOnce) {
  EXPECT_EQ(parts(), 2u);
  ASSERT_TRUE(writePartsFile(other_, partsHash(mesh_), file()));
  EXPECT_EQ(parts(), 3u);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "parts"), fs::directory_iterator()), 1);
}

TEST_F(PartsCacheTest, MakesAgainWhenForced) {
  EXPECT_EQ(parts(), 2u);
  ASSERT_TRUE(writePartsFile(other_, partsHash(mesh_), file()));
  EXPECT_EQ(parts(true), 2u);
  EXPECT_EQ(parts(), 2u);
}

TEST_F(PartsCacheTest, MakesADamagedFileAgain) {
  EXPECT_EQ(parts(), 2u);
  fs::resize_file(file(), fs::file_size(file()) - 1);
  EXPECT_EQ(parts(), 2u);
  EXPECT_TRUE(readPartsFile(file(), partsHash(mesh_)));
}

TEST_F(PartsCacheTest, MakesAFileOfAnotherMeshAgain) {
  EXPECT_EQ(parts(), 2u);
  ASSERT_TRUE(writePartsFile(other_, partsHash(mesh_) + 1, file()));
  EXPECT_EQ(parts(), 2u);
}

TEST_F(PartsCacheTest, GoesOnWithoutAFolderToWriteTo) {
  folder_.write("parts", "a file");
  EXPECT_EQ(parts(), 2u);
}

TEST_F(PartsCacheTest, LooksForFaultsBeforeItDivides) {
  std::vector<std::string> told;
  const DecompositionCache cache(folder_.path(), false,
                                 [&](const std::string& what, double) { told.push_back(what); });
  const TriangleMesh other = test::cupMesh();
  std::vector<std::size_t> parts;
  const auto load = [&](bool clean) {
    return [&, clean] {
      parts.clear();
      for (const TriangleMesh& mesh : {mesh_, other, mesh_}) parts.push_back(cache(mesh)->size());
      return clean;
    };
  };
  cache.loadInRounds(load(false));
  EXPECT_EQ(parts, (std::vector<std::size_t>{1, 1, 1}));  // boxes
  EXPECT_FALSE(fs::exists(folder_ / "parts"));
  EXPECT_TRUE(told.empty());

  cache.loadInRounds(load(true));
  EXPECT_EQ(parts[0], 2u);
  EXPECT_GT(parts[1], 2u);
  EXPECT_EQ(told, (std::vector<std::string>{"dividing meshes: 1 of 2", "dividing meshes: 2 of 2",
                                            "dividing meshes: 2 of 2"}));
}

TEST_F(PartsCacheTest, LoadsOnceWhereAllPartsAreKept) {
  parts();
  const DecompositionCache cache(folder_.path(), false);
  int rounds = 0;
  cache.loadInRounds([&] {
    ++rounds;
    EXPECT_EQ(cache(mesh_)->size(), 2u);
    return true;
  });
  EXPECT_EQ(rounds, 1);
}

TEST_F(PartsCacheTest, RefusesAtOnceWhatIsTooLarge) {
  const DecompositionCache cache(folder_.path(), false);
  mesh_ = test::moved(test::cupMesh(), Pose::Identity(), 100);
  bool refused = false;
  cache.loadInRounds([&] {
    const auto parts = cache(mesh_);
    refused = !parts && parts.error().detail.find("is too large") != std::string::npos;
    return false;
  });
  EXPECT_TRUE(refused);
}

TEST_F(PartsCacheTest, MakesEachOnceWhenForced) {
  const DecompositionCache cache(folder_.path(), true);
  ASSERT_TRUE(cache(mesh_));
  ASSERT_TRUE(writePartsFile(other_, partsHash(mesh_), file()));
  EXPECT_EQ(cache(mesh_)->size(), 3u);
}

TEST_F(PartsCacheTest, KeepsNothingWithoutAFolder) {
  const DecompositionCache cache(std::filesystem::path(), false);
  EXPECT_EQ(cache(mesh_)->size(), 2u);
}

TEST_F(PartsCacheTest, KnowsWhatItMadeOnly) {
  for (const fs::path& folder : {fs::path(), folder_.path()}) {
    const DecompositionCache cache(folder, false);
    EXPECT_FALSE(cache.known(mesh_));
    ASSERT_TRUE(cache(mesh_));
    const auto known = cache.known(mesh_);
    ASSERT_TRUE(known);
    EXPECT_EQ((*known)->size(), 2u);
  }
}

TEST_F(PartsCacheTest, KnowsRefusals) {
  const DecompositionCache cache(folder_.path(), false);
  mesh_ = test::moved(test::cupMesh(), Pose::Identity(), 100);
  const auto known = cache.known(mesh_);
  ASSERT_TRUE(known);
  EXPECT_FALSE(*known);
}

TEST_F(PartsCacheTest, StopsAtItsDeadline) {
  const DecompositionCache cache(folder_.path(), false);
  const Deadline passed(Deadline::Clock::now());
  const auto parts = cache.parts(mesh_, passed);
  ASSERT_FALSE(parts);
  EXPECT_EQ(parts.error().code, ErrorCode::kDeadline);
  EXPECT_FALSE(cache.known(mesh_));
  EXPECT_EQ(cache(mesh_)->size(), 2u);
}

TEST_F(PartsCacheTest, PassesOnWhatCannotBeDivided) {
  mesh_.triangles.clear();
  EXPECT_EQ(parts(), 0u);
  EXPECT_FALSE(fs::exists(folder_ / "parts"));
}

}  // namespace
}  // namespace handover
