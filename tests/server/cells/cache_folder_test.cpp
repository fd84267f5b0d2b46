// SPDX-License-Identifier: Apache-2.0
#include "cells/cache_folder.hpp"

#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

namespace fs = std::filesystem;

class CacheFolderTest : public testing::Test {
 protected:
  /// A file of 1000 bytes that was used so many hours ago.
  fs::path aged(const std::string& name, int hours) const {
    const fs::path file = folder.write(name, std::string(1000, 'x'));
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(hours));
    return file;
  }

  const test::TemporaryFolder folder;
};

TEST_F(CacheFolderTest, TakesAwayWhatWasUnusedTheLongest) {
  const CacheFolder cache(folder.path(), 3500);
  const fs::path oldest = aged("maps/a.map", 4), older = aged("grasps/b.json", 3),
                 old = aged("parts/c.parts", 2), again = aged("maps/d.map", 5);
  cache.used(again);
  const fs::path made = aged("grasps/new.json", 9);  // of another clock; it is the newest
  cache.written(made);
  EXPECT_FALSE(fs::exists(oldest));
  EXPECT_FALSE(fs::exists(older));
  for (const fs::path& kept : {old, again, made}) EXPECT_TRUE(fs::exists(kept)) << kept;
  EXPECT_EQ(cache.writtenBytes(), 1000u);
}

TEST_F(CacheFolderTest, WithinItsBoundKeepsAll) {
  const CacheFolder cache(folder.path(), 2000);
  const fs::path old = aged("maps/a.map", 1000), made = aged("maps/b.map", 0);
  cache.written(made);
  EXPECT_TRUE(fs::exists(old));
}

TEST_F(CacheFolderTest, KeepsTheNewestThoughItIsMoreThanAll) {
  const CacheFolder cache(folder.path(), 10);
  const fs::path made = aged("maps/b.map", 0);
  cache.written(made);
  EXPECT_TRUE(fs::exists(made));
  cache.written(folder / "none");
  EXPECT_EQ(cache.writtenBytes(), 1000u);
}

}  // namespace
}  // namespace handover
