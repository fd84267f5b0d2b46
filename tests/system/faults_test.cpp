// SPDX-License-Identifier: Apache-2.0
// The daemon's program over files that are wrong: exit codes and what it prints.
#include "process.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

namespace handover::test {
namespace {

using testing::HasSubstr;

Finished check(const std::vector<std::string>& files, const std::string& locale = "C") {
  std::vector<std::string> command{HANDOVER_BINARY_DIR "/bin/handoverd", "check", "--root",
                                   HANDOVER_SOURCE_DIR};
  command.insert(command.end(), files.begin(), files.end());
  return run(command, {"LC_ALL=" + locale});
}

std::string shipped(const std::string& file) { return HANDOVER_SOURCE_DIR "/" + file; }

TEST(Check, TakesWhatIsShippedWhateverTheLocale) {
  for (const char* locale : {"C", "de_DE.UTF-8", "tr_TR.UTF-8", "nonsense"}) {
    const Finished checked =
        check({shipped("config/cells/butler.yaml"), shipped("config/handoverd.yaml"),
               shipped("robots/hubo/hubo.yaml"), shipped("robots/hubo/hubo.urdf"),
               shipped("robots/hubo/hubo.srdf"), shipped("robots/objects/cup/cup.obj")},
              locale);
    EXPECT_EQ(checked.status, 0) << locale << checked.out << checked.err;
    EXPECT_EQ(checked.out, "");
  }
}

TEST(Check, ListsEveryFaultOfEveryFile) {
  const TemporaryFolder folder;
  const auto settings = folder.write("s.yaml", "version: 1\ndomain: 1,5\nthreads: '2'\n").string();
  const auto urdf = folder.write("r.urdf", "<robot name='r'>\n<link name='a'/>\n<link/></robot>");
  const Finished checked = check({settings, shipped("config/handoverd.yaml"), urdf.string()});
  EXPECT_EQ(checked.status, 3);
  EXPECT_EQ(checked.out,
            settings + ":2: domain: must be a whole number from 0 to 232, not '1,5'\n" + settings +
                ":3: threads: must be a whole number from 1 to 64, not the text '2'\n" +
                urdf.string() + ":3: <link> has no name\n");
}

TEST(Check, SaysWhatIsNoFileOfOurs) {
  const TemporaryFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto text = folder.write("note.txt", "hello: you\n").string();
  const Finished checked = check({pipe, "/dev/zero", folder.path().string(), text, "none"});
  EXPECT_EQ(checked.status, 3);
  EXPECT_EQ(checked.out, pipe + ": is a pipe, not a plain file\n" +
                             "/dev/zero: is a device, not a plain file\n" + folder.path().string() +
                             ": is a folder, not a file\n" + text +
                             ": is no cell, robot or daemon settings\n" + "none: no such file\n");
}

/// A wavy sheet of some hundred thousand triangles: half a second to read.
std::string largeMesh() {
  constexpr int kEdge = 480;
  std::string text;
  for (int i = 0; i < kEdge * kEdge; ++i) {
    text += "v " + std::to_string(i / kEdge) + " " + std::to_string(i % kEdge) + " " +
            std::to_string(i * 7 % 10) + "\n";
  }
  for (int i = 1; i < kEdge * (kEdge - 1); ++i) {
    const auto corner = [i](int ahead) { return " " + std::to_string(i + ahead); };
    text += "f" + corner(0) + corner(1) + corner(kEdge) + "\n";
    text += "f" + corner(1) + corner(kEdge + 1) + corner(kEdge) + "\n";
  }
  return text;
}

TEST(Check, OutlivesAFileThatCrashesItsReader) {
  const TemporaryFolder folder;
  const std::string large = folder.write("large.obj", largeMesh()).string();
  Process checking({HANDOVER_BINARY_DIR "/bin/handoverd", "check", "--root", HANDOVER_SOURCE_DIR,
                    large, shipped("robots/objects/cup/cup.obj")},
                   {"XDG_CACHE_HOME=" + (folder / "cache").string()});
  // As the file would, in the process that reads it.
  ASSERT_TRUE(checking.signalChild(SIGSEGV));
  EXPECT_EQ(checking.wait(60s), 3);
  EXPECT_THAT(checking.out(), HasSubstr(large + ": cannot be read as a mesh: crashed: "));
  EXPECT_THAT(checking.err(), HasSubstr("cup.obj: "));  // the next file is read
}

}  // namespace
}  // namespace handover::test
