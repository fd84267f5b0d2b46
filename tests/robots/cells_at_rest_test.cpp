// SPDX-License-Identifier: Apache-2.0
// Our cells as one would see them: no link stands in the furniture, whether it can move or not.
#include "core/collision/collision_scene.hpp"
#include "settings/cell_file.hpp"

#include <gtest/gtest.h>

#include <ostream>

namespace handover {
namespace {

struct AtRest {
  const char* cell;
  std::vector<Override> overrides;

  friend std::ostream& operator<<(std::ostream& out, const AtRest& at) {
    out << at.cell;
    for (const Override& change : at.overrides) out << ' ' << change.path << '=' << change.value;
    return out;
  }
};

class CellAtRest : public testing::TestWithParam<AtRest> {};

TEST_P(CellAtRest, HasNoLinkInTheFurniture) {
  ModelCache models;
  const std::filesystem::path root = HANDOVER_SOURCE_DIR;
  const Cell cell =
      Cell::load(root / "config/cells" / (std::string(GetParam().cell) + ".yaml"), root, models);
  const auto made = cell.instantiate(GetParam().overrides, 1);
  const auto collision =
      std::make_shared<const CollisionScene>(*std::get<Cell::Instance>(made).scene);
  CollisionWorld world(collision);
  std::vector<BodyId> all;
  for (BodyId body = 0; body < collision->bodies(); ++body) all.push_back(body);
  for (const BodyContact& contact :
       world.contacts(world.makePairs(all, BodyPairs(collision->bodies())))) {
    EXPECT_LT(contact.depth, 0.0005)
        << collision->name(contact.a) << " and " << collision->name(contact.b);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Ours, CellAtRest,
    testing::Values(AtRest{"butler", {}}, AtRest{"butler_left", {}}, AtRest{"kneeling", {}},
                    AtRest{"stool", {}},
                    AtRest{"stool", {{"robots.hubo.base.xyz", "[0, -0.276, 0.748]"}}},
                    AtRest{"stool", {{"robots.hubo.base.xyz", "[0, 0.015, 1.273]"}}}));

}  // namespace
}  // namespace handover
