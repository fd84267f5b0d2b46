// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/map_file.hpp"

#include "file_bytes.hpp"
#include "support/arm_models.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>

namespace handover::test {
namespace {

using reachability::FileHeader;

using testing::HasSubstr;

class MapFile : public testing::Test {
 protected:
  MapFile() {
    const RobotModel model = planarArm();
    const ReachabilityParams params{.voxel = 0.1, .samples = 2000, .seed = 1};
    const RobotVector q = RobotVector::Zero(2);
    hash_ = ReachabilityMap::hash(model, ArmId(0), q, params);
    const auto built = ReachabilityMap::build(model, q, params, {}, {file_}, {}, Deadline());
    if (!built) throw std::runtime_error(built.error().detail);
    good_ = readBytes(file_);
  }

  /// What opening these bytes says: "" when they are taken.
  std::string complaint(const std::vector<char>& bytes) {
    writeBytes(file_, bytes);
    const auto map = ReachabilityMap::open(file_, hash_);
    if (map) return "";
    EXPECT_EQ(map.error().code, ErrorCode::kInvalidInput);
    EXPECT_THAT(map.error().detail, HasSubstr(file_.string()));
    return map.error().detail;
  }

  FileHeader header() const {
    FileHeader header;
    std::memcpy(&header, good_.data(), sizeof(header));
    return header;
  }

  /// The good file with another header, and with its checksum made to fit.
  std::vector<char> with(const FileHeader& changed) const {
    std::vector<char> bytes = good_;
    std::memcpy(bytes.data(), &changed, sizeof(changed));
    return seal(bytes);
  }

  static std::vector<char> seal(std::vector<char> bytes) {
    const std::uint64_t sum = XXH3_64bits(bytes.data() + 24, bytes.size() - 24);
    std::memcpy(bytes.data() + 16, &sum, sizeof(sum));
    return bytes;
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "map";
  std::uint64_t hash_ = 0;
  std::vector<char> good_;
};

TEST_F(MapFile, IsTakenAsItWasWritten) {
  EXPECT_EQ(complaint(good_), "");
  EXPECT_EQ(complaint(with(header())), "");
}

TEST_F(MapFile, IsNotFoundWhereThereIsNone) {
  const auto none = ReachabilityMap::open(folder_ / "none", hash_);
  ASSERT_FALSE(none.has_value());
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
}

TEST_F(MapFile, MustBeAPlainFile) {
  const auto directory = ReachabilityMap::open(folder_.path(), hash_);
  ASSERT_FALSE(directory.has_value());
  EXPECT_EQ(directory.error().code, ErrorCode::kInvalidInput);
  const std::filesystem::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto fifo = ReachabilityMap::open(pipe, hash_);
  ASSERT_FALSE(fifo.has_value());
  EXPECT_EQ(fifo.error().code, ErrorCode::kInvalidInput);
}

TEST_F(MapFile, IsRefusedWhenCutAnywhere) {
  for (std::size_t size = 0; size < good_.size(); size += size < 200 ? 1 : 97) {
    EXPECT_NE(complaint({good_.begin(), good_.begin() + static_cast<std::ptrdiff_t>(size)}), "")
        << size;
  }
}

TEST_F(MapFile, IsRefusedWhenLonger) {
  std::vector<char> bytes = good_;
  bytes.push_back(0);
  EXPECT_THAT(complaint(bytes), HasSubstr("header says"));
}

TEST_F(MapFile, IsRefusedWithAnyByteChanged) {
  for (std::size_t at = 0; at < good_.size(); at += at < 200 ? 1 : 53) {
    std::vector<char> bytes = good_;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    EXPECT_NE(complaint(bytes), "") << at;
  }
}

TEST_F(MapFile, NamesWhatIsWrong) {
  const auto changed = [&](auto change) {
    FileHeader h = header();
    change(h);
    return complaint(with(h));
  };
  EXPECT_THAT(changed([](FileHeader& h) { h.magic[0] = 'X'; }), HasSubstr("magic"));
  EXPECT_THAT(changed([](FileHeader& h) { h.version = 3; }), HasSubstr("version 3"));
  EXPECT_THAT(changed([](FileHeader& h) { h.version = 1; }), HasSubstr("version 1"));
  EXPECT_THAT(changed([](FileHeader& h) { ++h.hash; }), HasSubstr("hash"));
  EXPECT_THAT(changed([](FileHeader& h) { ++h.header_size; }), HasSubstr("sizes"));
  EXPECT_THAT(changed([](FileHeader& h) { h.voxel_bytes = 0; }), HasSubstr("sizes"));
  EXPECT_THAT(changed([](FileHeader& h) { h.voxel = 0; }), HasSubstr("voxel size"));
  EXPECT_THAT(changed([](FileHeader& h) { h.voxel = std::nan(""); }), HasSubstr("voxel size"));
  EXPECT_THAT(changed([](FileHeader& h) { h.dofs = 9; }), HasSubstr("joints"));
  EXPECT_THAT(changed([](FileHeader& h) { h.dofs = 0; }), HasSubstr("joints"));
  EXPECT_THAT(changed([](FileHeader& h) { h.size[1] = -1; }), HasSubstr("grid out of range"));
  EXPECT_THAT(changed([](FileHeader& h) { h.first[2] = 0x7fffffff; }),
              HasSubstr("grid out of range"));
  EXPECT_THAT(changed([](FileHeader& h) {
                h.size = {0x7fffffff, 0x7fffffff, 0x7fffffff};
              }),
              HasSubstr("grid"));
  EXPECT_THAT(changed([](FileHeader& h) {
                h.first = {0, 0, 0};
                h.size = {1 << 20, 1 << 20, 1 << 20};
              }),
              HasSubstr("grid too large"));
  EXPECT_THAT(changed([](FileHeader& h) { ++h.size[0]; }), HasSubstr("file's size"));
  EXPECT_THAT(changed([](FileHeader& h) { h.size = {0, 0, 0}; }), HasSubstr("file's size"));
  EXPECT_THAT(changed([](FileHeader& h) { ++h.filled; }), HasSubstr("file's size"));
  EXPECT_THAT(changed([](FileHeader& h) { h.filled = ~0ull; }), HasSubstr("file's size"));
  std::vector<char> wrong_sum = good_;
  ++wrong_sum[16];
  EXPECT_THAT(complaint(wrong_sum), HasSubstr("checksum"));
}

TEST_F(MapFile, IsRefusedWithIndicesOrVoxelsThatDoNotFit) {
  const FileHeader h = header();
  const std::size_t cells = static_cast<std::size_t>(h.size[0]) *
                            static_cast<std::size_t>(h.size[1]) *
                            static_cast<std::size_t>(h.size[2]);
  const auto layout = reachability::layoutOf(cells, h.filled);
  const auto index = [&](std::vector<char> bytes, std::int32_t from, std::int32_t to) {
    for (std::size_t cell = 0; cell < cells; ++cell) {
      std::int32_t value = 0;
      char* at = bytes.data() + layout.index_begin + cell * sizeof(value);
      std::memcpy(&value, at, sizeof(value));
      if (value != from) continue;
      std::memcpy(at, &to, sizeof(to));
      break;
    }
    return seal(bytes);
  };
  const auto last = static_cast<std::int32_t>(h.filled) - 1;
  EXPECT_THAT(complaint(index(good_, 0, 1 << 30)), HasSubstr("index"));
  EXPECT_THAT(complaint(index(good_, 0, -2)), HasSubstr("index"));
  EXPECT_THAT(complaint(index(good_, last, last + 1)), HasSubstr("index"));
  EXPECT_THAT(complaint(index(good_, last, -1)), HasSubstr("without a cell"));

  const auto voxel = [&](auto change) {
    std::vector<char> bytes = good_;
    ReachabilityVoxel value;
    std::memcpy(&value, bytes.data() + layout.voxels_begin, sizeof(value));
    change(value);
    std::memcpy(bytes.data() + layout.voxels_begin, &value, sizeof(value));
    return seal(bytes);
  };
  EXPECT_THAT(complaint(voxel([](auto& v) { v.manipulability = std::nanf(""); })),
              HasSubstr("voxel 0"));
  EXPECT_THAT(complaint(voxel([](auto& v) { v.manipulability = -1; })), HasSubstr("voxel 0"));
  EXPECT_THAT(complaint(voxel([](auto& v) { v.samples = 0; })), HasSubstr("voxel 0"));
  EXPECT_THAT(complaint(voxel([](auto& v) { v.q_seed[1] = INFINITY; })), HasSubstr("voxel 0"));
}

TEST_F(MapFile, ReplacesTheOldOneAndLeavesNothingBeside) {
  const RobotModel model = planarArm();
  const auto old = ReachabilityMap::open(file_, hash_);
  ASSERT_TRUE(old.has_value());
  const std::size_t voxels = (*old)->filledVoxels();
  ASSERT_TRUE(ReachabilityMap::build(model, RobotVector::Zero(2), {.voxel = 0.02, .samples = 5000},
                                     {}, {file_}, {}, Deadline())
                  .has_value());
  EXPECT_EQ((*old)->filledVoxels(), voxels);  // as it was read
  EXPECT_FALSE(ReachabilityMap::open(file_, hash_).has_value());
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    ++files;
  EXPECT_EQ(files, 1u);
}

TEST_F(MapFile, DoesNotMatterOnceItIsRead) {
  const auto map = ReachabilityMap::open(file_, hash_);
  ASSERT_TRUE(map.has_value());
  const auto entries = [&] {
    std::vector<double> all;
    for (double x = -0.55; x < 0.6; x += 0.1) {
      for (double y = -0.55; y < 0.6; y += 0.1) all.push_back((**map)({x, y, 0.05}));
    }
    return all;
  };
  const std::vector<double> before = entries();
  EXPECT_GT(*std::max_element(before.begin(), before.end()), 0);
  std::filesystem::resize_file(file_, 0);  // the same file, as a copy over it would do
  EXPECT_EQ(entries(), before);
  writeBytes(file_, std::vector<char>(good_.size(), 0x7f));
  EXPECT_EQ(entries(), before);
  EXPECT_FALSE(ReachabilityMap::open(file_, hash_).has_value());
}

TEST_F(MapFile, MakesItsFolderAndIsInMemoryWhereItCannot) {
  const RobotModel model = planarArm();
  const auto build = [&](const std::filesystem::path& file) {
    return ReachabilityMap::build(model, RobotVector::Zero(2), {.samples = 100}, {}, {file}, {},
                                  Deadline());
  };
  const auto kept = build(folder_ / "new/deep/map");
  ASSERT_TRUE(kept.has_value());
  EXPECT_EQ(kept->at(0).not_kept, "");
  const auto blocked = build(file_ / "below_a_file");
  ASSERT_TRUE(blocked.has_value());
  EXPECT_THAT(blocked->at(0).not_kept, HasSubstr("Not a directory"));
  EXPECT_EQ(blocked->at(0).map->filledVoxels(), kept->at(0).map->filledVoxels());
}

}  // namespace
}  // namespace handover::test
