// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/grasp_set.hpp"
#include "test_hands.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <functional>
#include <sstream>

namespace handover {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr std::uint64_t kHash = 0x0123456789abcdefULL;

GraspSet twoGrasps() {
  GraspSet set{"cup", "gripper", "hand", {}, {}};
  for (const double quality : {0.3, 0.1}) {
    Grasp grasp;
    grasp.X_OT = toPose(toValue(Pose(Eigen::Translation3d(0.1, -0.2, 1.0 / 3) *
                                     Eigen::AngleAxisd(quality, Eigen::Vector3d::UnitX()))));
    grasp.X_OT = toPose(toValue(grasp.X_OT));
    grasp.open = Eigen::Vector2d(0.05, 1.0 / 7);
    grasp.closed = Eigen::Vector2d(0.01, 0.02);
    grasp.contacts = {{"left", {0.01, 0, 0}, {1, 0, 0}}, {"right", {-0.01, 0, 0}, {-1, 0, 0}}};
    grasp.quality = quality;
    set.grasps.push_back(grasp);
  }
  return set;
}

std::filesystem::path temporaryFile(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / ("handover_" + name);
}

std::string contentOf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

TEST(GraspSetFile, GivesBackWhatWasWritten) {
  const auto file = temporaryFile("grasps_round_trip.json");
  const GraspSet set = twoGrasps();
  ASSERT_TRUE(writeGraspSet(set, kHash, file));
  const auto read = readGraspSet(file, kHash);
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_EQ(read->object, "cup");
  EXPECT_EQ(read->robot, "gripper");
  EXPECT_EQ(read->hand, "hand");
  ASSERT_EQ(read->grasps.size(), 2u);
  EXPECT_TRUE(read->grasps[0].X_OT.isApprox(set.grasps[0].X_OT, 1e-15));
  EXPECT_EQ(read->grasps[0].open, set.grasps[0].open);
  EXPECT_EQ(read->grasps[1].closed, set.grasps[1].closed);
  EXPECT_EQ(read->grasps[1].quality, set.grasps[1].quality);
  EXPECT_EQ(read->grasps[0].contacts[1].link, "right");
  EXPECT_EQ(read->grasps[0].contacts[1].n_O, set.grasps[0].contacts[1].n_O);
}

TEST(GraspSetFile, KeepsAnEmptySetAndItsReason) {
  const auto file = temporaryFile("grasps_none.json");
  const GraspSet none{"cup", "gripper", "hand", {}, "it is too wide"};
  ASSERT_TRUE(writeGraspSet(none, kHash, file));
  const auto read = readGraspSet(file, kHash);
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_TRUE(read->grasps.empty());
  EXPECT_EQ(read->none_because, "it is too wide");
}

TEST(GraspSetFile, OfACupHasNoJointsAndOneContact) {
  const auto file = temporaryFile("grasps_cup.json");
  GraspSet set{"box", "arm", "cup", {}, {}};
  Grasp grasp;
  grasp.X_OT.translation().z() = 0.05;
  grasp.contacts = {{"cup", {0, 0, 0.05}, {0, 0, 1}}};
  grasp.quality = 0.9;
  set.grasps = {grasp};
  ASSERT_TRUE(writeGraspSet(set, kHash, file));
  const auto read = readGraspSet(file, kHash);
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_EQ(read->grasps[0].open.size(), 0);
  EXPECT_EQ(read->grasps[0].contacts[0].link, "cup");
  EXPECT_EQ(read->grasps[0].X_OT.matrix(), grasp.X_OT.matrix());

  set.grasps[0].contacts.push_back(grasp.contacts[0]);
  ASSERT_TRUE(writeGraspSet(set, kHash, file));
  EXPECT_FALSE(readGraspSet(file, kHash));
}

TEST(GraspSetFile, LeavesNoTemporaryFileBehind) {
  const auto folder = temporaryFile("grasp_folder");
  std::filesystem::remove_all(folder);
  ASSERT_TRUE(writeGraspSet(twoGrasps(), kHash, folder / "cup.json"));
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++files;
  EXPECT_EQ(files, 1);
}

TEST(GraspSetFile, CannotBeWrittenIntoAFile) {
  const auto file = temporaryFile("grasp_plain_file");
  std::ofstream(file) << "x";
  const auto written = writeGraspSet(twoGrasps(), kHash, file / "cup.json");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
}

TEST(GraspSetFile, ThatDoesNotExistIsNotFound) {
  const auto read = readGraspSet(temporaryFile("no_such_grasps.json"), kHash);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kNotFound);
}

TEST(GraspSetFile, OfAnotherHashIsRefused) {
  const auto file = temporaryFile("grasps_hash.json");
  ASSERT_TRUE(writeGraspSet(twoGrasps(), kHash, file));
  const auto read = readGraspSet(file, kHash + 1);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(read.error().detail, HasSubstr("hash"));
}

TEST(GraspSetFile, CutShortAtAnyByteIsRefused) {
  const auto file = temporaryFile("grasps_cut.json");
  ASSERT_TRUE(writeGraspSet(twoGrasps(), kHash, file));
  const std::string whole = contentOf(file);
  for (std::size_t length = 0; length + 2 < whole.size(); length += 7) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << whole.substr(0, length);
    const auto read = readGraspSet(file, kHash);
    ASSERT_FALSE(read) << length;
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidInput);
  }
}

struct Fault {
  const char* name;
  std::function<void(json&)> make;
  const char* field;
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class MalformedGraspSet : public testing::TestWithParam<Fault> {};

TEST_P(MalformedGraspSet, IsRefusedNamingFileAndField) {
  const auto file = temporaryFile(std::string("grasps_") + GetParam().name + ".json");
  ASSERT_TRUE(writeGraspSet(twoGrasps(), kHash, file));
  json content = json::parse(contentOf(file));
  GetParam().make(content);
  std::ofstream(file, std::ios::trunc) << content.dump();
  const auto read = readGraspSet(file, kHash);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(read.error().detail, HasSubstr(file.string()));
  EXPECT_THAT(read.error().detail, HasSubstr(GetParam().field));
}

const Fault kFaults[] = {
    {"not_an_object", [](json& f) { f = json::array(); }, "is not an object"},
    {"no_format", [](json& f) { f.erase("format"); }, "format: is missing"},
    {"other_format", [](json& f) { f["format"] = "handover-plan/1"; }, "format"},
    {"hash_number", [](json& f) { f["hash"] = 1; }, "hash"},
    {"no_object", [](json& f) { f.erase("object"); }, "object"},
    {"empty_robot", [](json& f) { f["robot"] = ""; }, "robot"},
    {"hand_list", [](json& f) { f["hand"] = json::array(); }, "hand"},
    {"no_grasps", [](json& f) { f["grasps"] = json::array(); }, "none_because: is missing"},
    {"grasps_text", [](json& f) { f["grasps"] = "many"; }, "grasps"},
    {"grasp_number", [](json& f) { f["grasps"][1] = 3; }, "grasps[1]"},
    {"no_pose", [](json& f) { f["grasps"][0].erase("X_OT"); }, "grasps[0].X_OT"},
    {"short_xyz",
     [](json& f) {
       f["grasps"][0]["X_OT"]["xyz"] = {1, 2};
     },
     "grasps[0].X_OT.xyz"},
    {"null_xyz", [](json& f) { f["grasps"][0]["X_OT"]["xyz"][2] = nullptr; },
     "grasps[0].X_OT.xyz[2]"},
    {"long_quat",
     [](json& f) {
       f["grasps"][0]["X_OT"]["quat_wxyz"] = {1, 0, 0, 1e-3};
     },
     "X_OT.quat_wxyz"},
    {"zero_quat",
     [](json& f) {
       f["grasps"][0]["X_OT"]["quat_wxyz"] = {0, 0, 0, 0};
     },
     "X_OT.quat_wxyz"},
    {"text_joint", [](json& f) { f["grasps"][0]["open"][1] = "wide"; }, "grasps[0].open[1]"},
    {"no_joints", [](json& f) { f["grasps"][0]["open"] = json::array(); }, "grasps[0].closed"},
    {"joint_missing", [](json& f) { f["grasps"][0]["closed"].erase(0); }, "grasps[0].closed"},
    {"other_hand", [](json& f) { f["grasps"][1]["open"] = f["grasps"][1]["closed"] = {0.1}; },
     "grasps[1].open"},
    {"one_contact", [](json& f) { f["grasps"][0]["contacts"].erase(0); }, "grasps[0].contacts"},
    {"contact_link", [](json& f) { f["grasps"][0]["contacts"][1]["link"] = 5; },
     "grasps[0].contacts[1].link"},
    {"contact_point", [](json& f) { f["grasps"][0]["contacts"][1]["p_O"] = {1}; },
     "contacts[1].p_O"},
    {"contact_normal",
     [](json& f) {
       f["grasps"][0]["contacts"][0]["n_O"] = {1, 1, 0};
     },
     "contacts[0].n_O"},
    {"no_quality", [](json& f) { f["grasps"][0].erase("quality"); }, "grasps[0].quality"},
    {"negative_quality", [](json& f) { f["grasps"][1]["quality"] = -0.1; }, "grasps[1].quality"},
    {"other_pose", [](json& f) { f["grasps"][1]["X_OT"]["xyz"][0] = 0.5; },
     "checksum: does not fit the grasps"},
    {"no_checksum", [](json& f) { f.erase("checksum"); }, "checksum: is missing"},
    {"unsorted", [](json& f) { f["grasps"][1]["quality"] = 0.9; }, "grasps[1].quality"},
};

INSTANTIATE_TEST_SUITE_P(Each, MalformedGraspSet, testing::ValuesIn(kFaults),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(GraspSetFile, WithANumberTooLargeIsRefused) {
  const auto file = temporaryFile("grasps_huge.json");
  ASSERT_TRUE(writeGraspSet(twoGrasps(), kHash, file));
  std::string content = contentOf(file);
  const auto at = content.find("0.05,");
  ASSERT_NE(at, std::string::npos);
  content.replace(at, 4, "1e999");
  std::ofstream(file, std::ios::trunc) << content;
  const auto read = readGraspSet(file, kHash);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kInvalidInput);
}

class GraspSetHash : public testing::Test {
 protected:
  std::uint64_t hash() const { return graspSetHash(object_, model_, ArmId(0), params_); }

  RobotModel model_ = parallelGripper();
  SceneObject object_ = boxObject({0.05, 0.05, 0.1});
  GraspParams params_;
};

TEST_F(GraspSetHash, StaysForTheSameInputs) {
  const std::uint64_t before = hash();
  EXPECT_EQ(before,
            graspSetHash(boxObject({0.05, 0.05, 0.1}), parallelGripper(), ArmId(0), GraspParams{}));
  object_.X_WO.translation().x() = 3;  // where the object stands does not matter
  EXPECT_EQ(before, hash());
}

TEST_F(GraspSetHash, ChangesWithObjectHandPostureAndEveryParameter) {
  std::vector<std::uint64_t> seen{hash()};
  const auto expectNew = [&](const char* what) {
    EXPECT_THAT(seen, testing::Not(testing::Contains(hash()))) << what;
    seen.push_back(hash());
  };
  object_.shapes[0].X_BS.translation().z() = 1e-6;
  expectNew("object pose of a part");
  std::get<BoxShape>(object_.shapes[0].geometry).size.x() += 1e-6;
  expectNew("object size");
  std::get<BoxShape>(model_.links.back().collision[0].geometry).size.x() += 1e-6;
  expectNew("finger size");
  model_.joints.back().X_PJ.translation().x() += 1e-6;
  expectNew("finger root");
  model_.hands[0].open[0] -= 1e-6;
  expectNew("open posture");
  model_.hands[0].closed[0] += 1e-6;
  expectNew("closed posture");
  params_.wanted += 1;
  expectNew("wanted");
  params_.surplus += 0.1;
  expectNew("surplus");
  params_.palm_gap += 1e-3;
  expectNew("palm gap");
  params_.rolls += 1;
  expectNew("rolls");
  params_.min_spacing += 1e-3;
  expectNew("spacing");
  params_.min_angle += 1e-3;
  expectNew("angle");
  params_.friction += 0.1;
  expectNew("friction");
  params_.seed += 1;
  expectNew("seed");
}

TEST_F(GraspSetHash, KnowsACupAndWhatASealNeeds) {
  const std::uint64_t of_fingers = hash();
  params_.seal_bend *= 2;
  params_.holding *= 2;
  EXPECT_EQ(hash(), of_fingers);  // for cups alone
  model_ = suctionGripper(0.015);
  std::vector<std::uint64_t> seen{hash()};
  const auto expectNew = [&](const char* what) {
    EXPECT_THAT(seen, testing::Not(testing::Contains(hash()))) << what;
    seen.push_back(hash());
  };
  model_.hands[0].suction->radius += 1e-3;
  expectNew("radius");
  model_.hands[0].suction->axis = -Eigen::Vector3d::UnitZ();
  expectNew("axis");
  params_.seal_bend += 0.01;
  expectNew("bend");
  params_.holding += 0.1;
  expectNew("holding");
  model_.hands[0].suction->engage_s += 1;
  EXPECT_THAT(seen, testing::Contains(hash())) << "how long it takes changes no grasp";
}

}  // namespace
}  // namespace handover
