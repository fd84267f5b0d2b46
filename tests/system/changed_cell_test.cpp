// SPDX-License-Identifier: Apache-2.0
// A daemon that is killed while it plans, its cell file changed, and started again.
#include "served_cells.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>

namespace handover::test {
namespace {

constexpr const char* kBase = "base: {xyz: [1.18, 0, 0.98], rpy_deg: [0, 0, 180]}";
constexpr const char* kOtherBase = "base: {xyz: [1.18, 0.1, 0.98], rpy_deg: [0, 0, 185]}";

class ChangedCell : public ServedCells {
 protected:
  /// A request of which stages have come when its daemon is killed, and no outcome; on a busy
  /// machine the daemon may be quicker than the test. nullptr: five times.
  std::unique_ptr<Process> killedWhilePlanning(const std::string& cell) {
    for (int i = 0; i < 5; ++i) {
      serve("--cell " + cell, HANDOVER_SOURCE_DIR);
      auto planning = std::make_unique<Process>(
          ctl("plan --cell butler --mode all --wait 20 --json --output " + file("p.json")));
      EXPECT_TRUE(planning->waitForOutput("\"trajectory\"")) << planning->err();
      daemon_->signal(SIGKILL);
      EXPECT_EQ(daemon_->wait(), 128 + SIGKILL);
      if (!planning->wait(200ms)) return planning;
    }
    return nullptr;
  }
};

TEST_F(ChangedCell, IsAnsweredWithAPlanOfTheNewSceneAlone) {
  std::string cell = textOf(HANDOVER_SOURCE_DIR "/config/cells/butler.yaml");
  const std::string changed = folder_.write("butler.yaml", cell).string();
  const auto planning = killedWhilePlanning(changed);
  ASSERT_TRUE(planning);

  const auto at = cell.find(kBase);
  ASSERT_NE(at, cell.npos);
  folder_.write("butler.yaml", cell.replace(at, std::string(kBase).size(), kOtherBase));
  serve("--cell " + changed, HANDOVER_SOURCE_DIR);
  ASSERT_EQ(planning->wait(120s), 0) << planning->err();
  expectValid("p.json");
  const auto plan = nlohmann::json::parse(textOf(file("p.json")));
  const auto& robots = plan["scene"]["robots"];
  const auto hubo = std::find_if(robots.begin(), robots.end(),
                                 [](const auto& robot) { return robot["name"] == "hubo"; });
  ASSERT_NE(hubo, robots.end());
  EXPECT_EQ((*hubo)["X_WB"]["xyz"][1], 0.1);
}

}  // namespace
}  // namespace handover::test
