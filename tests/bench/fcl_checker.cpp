// SPDX-License-Identifier: Apache-2.0
#include "fcl_shapes.hpp"
#include "reference_checker.hpp"

#include <fcl/fcl.h>

namespace handover::bench {
namespace {

/// An FCL object of one shape, which knows its body.
struct PlacedShape {
  BodyId body;
  Pose X_BS;
  std::unique_ptr<fcl::CollisionObjectd> object;
};

struct Query {
  const BodyPairs& pairs;
  fcl::CollisionRequestd request;
  bool hit = false;
};

BodyId bodyOf(const fcl::CollisionObjectd& object) {
  return static_cast<const PlacedShape*>(object.getUserData())->body;
}

/// True to end the search.
bool onPair(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data) {
  Query& query = *static_cast<Query*>(data);
  if (!query.pairs.contains(bodyOf(*a), bodyOf(*b))) return false;
  fcl::CollisionResultd result;
  query.hit = fcl::collide(a, b, query.request, result) > 0;
  return query.hit;
}

class FclChecker : public ReferenceChecker {
 public:
  explicit FclChecker(const CheckedScene& scene) : pairs_(scene.pairs) {
    std::vector<bool> moves(scene.shapes.size());
    for (const BodyId body : scene.moving) moves[body] = true;
    for (const bool moving : {true, false}) {
      auto& list = moving ? moving_ : still_;
      for (std::size_t body = 0; body < scene.shapes.size(); ++body) {
        if (moves[body] != moving) continue;
        for (const Shape& shape : scene.shapes[body]) {
          list.push_back({BodyId(body), shape.X_BS,
                          std::make_unique<fcl::CollisionObjectd>(
                              test::fclGeometry(shape), scene.X_WBody[body] * shape.X_BS)});
        }
      }
      for (PlacedShape& placed : list) {
        placed.object->setUserData(&placed);
        (moving ? moving_tree_ : still_tree_).registerObject(placed.object.get());
      }
    }
    moving_tree_.setup();
    still_tree_.setup();
  }

  bool valid(const std::vector<Pose>& X_WBody) override {
    for (PlacedShape& placed : moving_) {
      placed.object->setTransform(X_WBody[placed.body] * placed.X_BS);
      placed.object->computeAABB();
    }
    moving_tree_.update();
    Query query{pairs_, {}};
    moving_tree_.collide(&still_tree_, &query, onPair);
    if (!query.hit) moving_tree_.collide(&query, onPair);
    return !query.hit;
  }

 private:
  BodyPairs pairs_;
  std::vector<PlacedShape> moving_, still_;
  fcl::DynamicAABBTreeCollisionManagerd moving_tree_, still_tree_;
};

}  // namespace

std::unique_ptr<ReferenceChecker> makeFclChecker(const CheckedScene& scene) {
  return std::make_unique<FclChecker>(scene);
}

}  // namespace handover::bench
