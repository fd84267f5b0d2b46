// SPDX-License-Identifier: Apache-2.0
#include "core/collision/narrow_phase.hpp"
#include "reference_checker.hpp"

#include <btBulletCollisionCommon.h>

namespace handover::bench {
namespace {

btVector3 toBullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

btTransform toBullet(const Pose& X) {
  const auto& m = X.matrix();
  return btTransform(
      btMatrix3x3(m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)),
      toBullet(Eigen::Vector3d(X.translation())));
}

/// Each grown by our margin: boxes and cylinders have it inside their size, hulls outside.
struct ToBullet {
  using Made = std::unique_ptr<btCollisionShape>;

  Made operator()(const BoxShape& box) const {
    const Eigen::Vector3d half = 0.5 * box.size + Eigen::Vector3d::Constant(kCollisionMargin);
    return withMargin(std::make_unique<btBoxShape>(toBullet(half)));
  }

  Made operator()(const SphereShape& sphere) const {
    return std::make_unique<btSphereShape>(sphere.radius + kCollisionMargin);
  }

  Made operator()(const CylinderShape& cylinder) const {
    const double radius = cylinder.radius + kCollisionMargin;
    return withMargin(std::make_unique<btCylinderShapeZ>(
        btVector3(radius, radius, 0.5 * cylinder.length + kCollisionMargin)));
  }

  Made operator()(const ConvexShape& convex) const {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Eigen::Vector3d& v : convex.vertices) hull->addPoint(toBullet(v), false);
    hull->setMargin(kCollisionMargin);
    hull->recalcLocalAabb();
    return hull;
  }

 private:
  static Made withMargin(Made shape) {
    shape->setMargin(kCollisionMargin);
    return shape;
  }
};

struct PlacedShape {
  BodyId body;
  Pose X_BS;
  std::unique_ptr<btCollisionShape> shape;
  std::unique_ptr<btCollisionObject> object;
};

/// Lets only the wanted pairs into the broadphase.
class WantedPairs : public btOverlapFilterCallback {
 public:
  explicit WantedPairs(BodyPairs pairs) : pairs_(std::move(pairs)) {}

  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    const auto body = [](const btBroadphaseProxy* proxy) {
      return BodyId(static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex());
    };
    return pairs_.contains(body(a), body(b));
  }

 private:
  BodyPairs pairs_;
};

class BulletChecker : public ReferenceChecker {
 public:
  explicit BulletChecker(const CheckedScene& scene)
      : wanted_(scene.pairs),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &configuration_) {
    broadphase_.getOverlappingPairCache()->setOverlapFilterCallback(&wanted_);
    world_.setForceUpdateAllAabbs(false);
    std::vector<bool> moves(scene.shapes.size());
    for (const BodyId body : scene.moving) moves[body] = true;
    for (std::size_t body = 0; body < scene.shapes.size(); ++body) {
      for (const Shape& shape : scene.shapes[body]) {
        add(BodyId(body), shape, scene.X_WBody[body], moves[body]);
      }
    }
  }

  ~BulletChecker() override {
    for (const auto* list : {&moving_, &still_}) {
      for (const PlacedShape& it : *list) world_.removeCollisionObject(it.object.get());
    }
  }

  bool valid(const std::vector<Pose>& X_WBody) override {
    for (PlacedShape& placed : moving_) {
      placed.object->setWorldTransform(toBullet(X_WBody[placed.body] * placed.X_BS));
    }
    world_.performDiscreteCollisionDetection();
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold* manifold = dispatcher_.getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold->getNumContacts(); ++k) {
        if (manifold->getContactPoint(k).getDistance() <= 0) return false;
      }
    }
    return true;
  }

 private:
  void add(BodyId body, const Shape& shape, const Pose& X_WBody, bool moves) {
    PlacedShape placed{body, shape.X_BS, std::visit(ToBullet{}, shape.geometry),
                       std::make_unique<btCollisionObject>()};
    btCollisionObject& object = *placed.object;
    object.setCollisionShape(placed.shape.get());
    object.setWorldTransform(toBullet(X_WBody * shape.X_BS));
    object.setUserIndex(body.value());
    if (moves) {
      object.setCollisionFlags(object.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      object.setActivationState(DISABLE_DEACTIVATION);
    } else {
      object.setCollisionFlags(object.getCollisionFlags() | btCollisionObject::CF_STATIC_OBJECT);
      object.setActivationState(ISLAND_SLEEPING);
    }
    world_.addCollisionObject(&object);
    (moves ? moving_ : still_).push_back(std::move(placed));
  }

  WantedPairs wanted_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_;
  std::vector<PlacedShape> moving_, still_;
};

}  // namespace

std::unique_ptr<ReferenceChecker> makeBulletChecker(const CheckedScene& scene) {
  return std::make_unique<BulletChecker>(scene);
}

}  // namespace handover::bench
