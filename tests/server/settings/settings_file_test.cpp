// SPDX-License-Identifier: Apache-2.0
#include "settings/settings_file.hpp"

#include "core/model_io/file_fault.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using ::testing::ElementsAre;

DaemonSettings read(const std::string& text) {
  const test::TemporaryFolder folder;
  return readDaemonSettings(folder.write("handoverd.yaml", text));
}

std::vector<std::string> faultsOf(const std::string& text) {
  std::vector<std::string> shown;
  try {
    read(text);
  } catch (const FileError& error) {
    for (const FileFault& fault : error.faults()) {
      shown.push_back(std::to_string(fault.line) + ": " + fault.message);
    }
  }
  return shown;
}

TEST(DaemonSettings, KeepTheirDefaultsWhereTheFileIsSilent) {
  EXPECT_EQ(read("version: 1\n"), DaemonSettings());
  EXPECT_EQ(read("version: 1\ncache: \"\"\n"), DaemonSettings());
  EXPECT_EQ(read("version: 1\ncache:\n"), DaemonSettings());
}

TEST(DaemonSettings, AreReadFromTheFile) {
  const DaemonSettings settings = read(
      "version: 1\ncells: [butler, my/cell.yaml]\ndomain: 5\nthreads: 2\ntransport: lan\ncache: "
      "here\n"
      "log_level: warn\n");
  EXPECT_THAT(settings.cells, ElementsAre("butler", "my/cell.yaml"));
  EXPECT_EQ(settings.domain, 5);
  EXPECT_EQ(settings.threads, 2);
  EXPECT_EQ(settings.transport, "lan");
  EXPECT_EQ(settings.cache, "here");
  EXPECT_EQ(settings.log_level, "warn");
}

TEST(DaemonSettings, LimitsAreReadFromTheFile) {
  const DaemonSettings settings = read(
      "version: 1\nlimits: {queue: 9, client_queue: 3, client_cpu_s: 2.5, client_cache_mib: 7, "
      "deadline_s: 60}\ncache_mib: 5\n");
  EXPECT_EQ(settings.cache_mib, 5);
  EXPECT_EQ(settings.limits, (DaemonLimits{9, 3, 2.5, 7, 60}));
}

TEST(DaemonSettings, SayHowCellsAreShared) {
  EXPECT_FALSE(read("version: 1\ncells: {names: [a]}\n").share_cells);
  const DaemonSettings shared = read("version: 1\ncells: {names: [a, b], sharing: shared}\n");
  EXPECT_THAT(shared.cells, ElementsAre("a", "b"));
  EXPECT_TRUE(shared.share_cells);
  EXPECT_THAT(faultsOf("version: 1\ncells: {sharing: never}\n"), testing::SizeIs(1));
}

TEST(DaemonSettings, FaultsAreReportedWithTheirLines) {
  EXPECT_THAT(faultsOf("version: 1\nlimits: {queue: 0, client_queues: 3}\n"),
              ElementsAre("2: limits.queue: must be a whole number from 1 to 1000000, not '0'",
                          "2: limits.client_queues: unknown key; the nearest known one is "
                          "'client_queue'"));
  EXPECT_THAT(faultsOf("cells: []\n"), ElementsAre("1: has no 'version'"));
  EXPECT_THAT(faultsOf("version: 1\ncell: [a]\n"),
              ElementsAre("2: cell: unknown key; the nearest known one is 'cells'"));
  EXPECT_THAT(faultsOf("version: 1\ncells: butler\n"),
              ElementsAre("2: cells: must be a list, not 'butler'"));
  EXPECT_THAT(faultsOf("version: 1\ndomain: 233\n"),
              ElementsAre("2: domain: must be a whole number from 0 to 232, not '233'"));
  EXPECT_THAT(faultsOf("version: 1\nthreads: 0\n"),
              ElementsAre("2: threads: must be a whole number from 1 to 64, not '0'"));
  EXPECT_THAT(faultsOf("version: 1\nthreads: 1.5\n"),
              ElementsAre("2: threads: must be a whole number from 1 to 64, not '1.5'"));
  EXPECT_THAT(
      faultsOf("version: 1\ntransport: shm\n"),
      ElementsAre(
          "2: transport: must be one of loopback, lan, discovery_server, profile, not 'shm'"));
  EXPECT_THAT(faultsOf("version: '1'\n"),
              ElementsAre("1: version: must be a whole number from 1 to 1, not the text '1'"));
  EXPECT_THAT(faultsOf("version: 1\ndomain: 1e400\n"),
              ElementsAre("2: domain: must be a whole number from 0 to 232, not '1e400'"));
  EXPECT_THAT(faultsOf("version: 1\ndomain: 1,0\n"),
              ElementsAre("2: domain: must be a whole number from 0 to 232, not '1,0'"));
  EXPECT_THAT(faultsOf("version: 1\ncells: [[a]]\n"),
              ElementsAre("2: cells.0: must be a text, not a list"));
  EXPECT_THAT(faultsOf("version: 1\ndiscovery_servers: a:1\n"),
              ElementsAre("2: discovery_servers: must be a list, not 'a:1'"));
  EXPECT_THAT(faultsOf("version: 1\nprofile: [a]\n"),
              ElementsAre("2: profile: must be a text, not a list"));
  EXPECT_THAT(faultsOf("version: 1\ncache: {}\n"),
              ElementsAre("2: cache: must be a text, not a map"));
  EXPECT_THAT(faultsOf("version: 1\ntransport: discovery_server\n"),
              ElementsAre("2: transport: discovery_server needs discovery_servers: [host:port]"));
  EXPECT_THAT(faultsOf("version: 1\ntransport: profile\n"),
              ElementsAre("2: transport: profile needs profile: FILE"));
  EXPECT_THAT(
      faultsOf("version: 1\nlog_level: [info]\n"),
      ElementsAre("2: log_level: must be one of trace, debug, info, warn, error, off, not a list"));
  EXPECT_THAT(faultsOf("version: 1\ndomain: x\nthreads: y\n").size(), 2u);
  EXPECT_THAT(faultsOf("version: [1\n")[0], ::testing::HasSubstr("is not well-formed YAML"));
}

TEST(DaemonSettings, NeedTheirFile) {
  EXPECT_THROW(readDaemonSettings("/nonexistent/handoverd.yaml"), FileError);
  EXPECT_THROW(readDaemonSettings("/"), FileError);
}

}  // namespace
}  // namespace handover
