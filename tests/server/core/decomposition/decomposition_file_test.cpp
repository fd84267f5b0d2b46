// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/decomposition_file.hpp"

#include "support/meshes.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <iterator>

namespace handover {
namespace {

using ::testing::HasSubstr;

class PartsFile : public ::testing::Test {
 protected:
  std::string bytes() const {
    std::ifstream stream(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  void write(const std::string& text) const { folder_.write("a.parts", text); }

  std::string fault(std::uint64_t hash = 5) const {
    const auto read = readPartsFile(file_, hash);
    if (read) return "read";
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidInput);
    return read.error().detail;
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "a.parts";
  std::vector<TriangleMesh> parts_{test::boxMesh({0, 0, 0}, {1, 2, 3}), test::sphereMesh(0.1, 8)};
};

TEST_F(PartsFile, ReadsWhatWasWritten) {
  ASSERT_TRUE(writePartsFile(parts_, 5, file_));
  const auto read = readPartsFile(file_, 5);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*read)[i].vertices, parts_[i].vertices);
    EXPECT_EQ((*read)[i].triangles, parts_[i].triangles);
  }
}

TEST_F(PartsFile, IsNotFoundWhereNoneIs) {
  EXPECT_EQ(readPartsFile(file_, 5).error().code, ErrorCode::kNotFound);
}

TEST_F(PartsFile, BelongsToOneMesh) {
  ASSERT_TRUE(writePartsFile(parts_, 5, file_));
  EXPECT_THAT(fault(6), HasSubstr("a.parts: made for another mesh"));
}

TEST_F(PartsFile, NoticesEveryChangedByte) {
  ASSERT_TRUE(writePartsFile(parts_, 5, file_));
  const std::string good = bytes();
  for (std::size_t i = 0; i < good.size(); i += 7) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    write(bad);
    EXPECT_NE(fault(), "read") << "byte " << i;
  }
}

TEST_F(PartsFile, NoticesEveryLength) {
  ASSERT_TRUE(writePartsFile(parts_, 5, file_));
  const std::string good = bytes();
  for (std::size_t length = 0; length < good.size(); length += 5) {
    write(good.substr(0, length));
    EXPECT_NE(fault(), "read") << length << " bytes";
  }
  write(good + "x");
  EXPECT_NE(fault(), "read");
}

TEST_F(PartsFile, SaysWhenTheFolderCannotBeWritten) {
  folder_.write("blocked", "");
  const auto written = writePartsFile(parts_, 5, folder_ / "blocked" / "a.parts");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
}

TEST(PartsHash, IsOfVerticesAndTriangles) {
  TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 2, 3});
  const std::uint64_t hash = partsHash(mesh);
  EXPECT_EQ(partsHash(mesh), hash);
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  EXPECT_NE(partsHash(mesh), hash);
  mesh = test::boxMesh({0, 0, 0}, {1, 2, 3.0000001});
  EXPECT_NE(partsHash(mesh), hash);
}

}  // namespace
}  // namespace handover
