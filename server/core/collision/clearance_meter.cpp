// SPDX-License-Identifier: Apache-2.0
#include "core/collision/clearance_meter.hpp"

#include "core/collision/box.hpp"
#include "core/collision/narrow_phase.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace handover {

struct ClearanceMeter::Data {
  explicit Data(const CollisionScene& of)
      : scene(of),
        poses(static_cast<std::size_t>(of.bodies())),
        body_boxes(poses.size()),
        shape_boxes(of.data().shapes.size()) {
    // Equal to no pose.
    for (Pose& it : poses) it.matrix().setConstant(std::numeric_limits<double>::quiet_NaN());
  }

  const SceneShape& shape(int index) const {
    return scene.data().shapes[static_cast<std::size_t>(index)];
  }

  const Aabb& shapeBox(int index) const { return shape_boxes[static_cast<std::size_t>(index)]; }

  int firstShape(BodyId body) const { return scene.data().first_shape[body]; }

  /// One past the last.
  int endShape(BodyId body) const { return scene.data().first_shape[std::size_t{body} + 1]; }

  const CollisionScene& scene;
  std::vector<Pose> poses;
  std::vector<Aabb> body_boxes, shape_boxes;
  std::vector<Aabb> grown;  ///< scratch of findPairs()
};

ClearanceMeter::ClearanceMeter(const CollisionScene& scene)
    : data_(std::make_unique<Data>(scene)) {}

ClearanceMeter::~ClearanceMeter() = default;

void ClearanceMeter::setPose(BodyId body, const Pose& X_WBody) {
  Pose& pose = data_->poses[body];
  if (pose.matrix() == X_WBody.matrix()) return;
  if (!X_WBody.matrix().allFinite()) {
    throw std::invalid_argument("pose of " + data_->scene.name(body) + " is not finite");
  }
  pose = X_WBody;
  Aabb whole;
  for (int i = data_->firstShape(body); i < data_->endShape(body); ++i) {
    Aabb& box = data_->shape_boxes[static_cast<std::size_t>(i)];
    box = worldBox(X_WBody, data_->shape(i));
    whole.add(box);
  }
  data_->body_boxes[body] = whole;
}

void ClearanceMeter::findPairs(const RigidGroups& groups, const std::vector<MovingBody>& moving,
                               const std::vector<int>& index, double within,
                               std::vector<BodyPair>& pairs) {
  pairs.clear();
  Aabb all;
  std::vector<Aabb>& grown = data_->grown;
  grown.clear();
  for (const MovingBody& it : moving) {
    Aabb& box = grown.emplace_back(data_->body_boxes[it.body]);
    box.grow(groups.travel(it.group) + within);
    all.add(box);
  }
  for (const BodyId other : IdRange<BodyId>(data_->scene.bodies())) {
    Aabb box = data_->body_boxes[other];
    const int at = index[other];
    std::size_t end = moving.size();
    if (at >= 0) {
      end = static_cast<std::size_t>(at);
      box.grow(groups.travel(moving[end].group));
    }
    if (!overlap(all, box)) continue;
    for (std::size_t i = 0; i < end; ++i) {
      if (overlap(grown[i], box)) pairs.emplace_back(moving[i].body, other);
    }
  }
}

bool ClearanceMeter::keepApart(BodyId a, BodyId b, const PairMotion& motion, double apart,
                               double& at_most) const {
  bool proven = true;
  at_most = std::numeric_limits<double>::infinity();
  const double far = std::max(0.0, apart + motion.most);
  for (int i = data_->firstShape(a); i < data_->endShape(a); ++i) {
    const Pose X_WA = data_->poses[a] * data_->shape(i).X_BS;
    for (int j = data_->firstShape(b); j < data_->endShape(b); ++j) {
      // The boxes include the margins, so their gap is smaller than that of the shapes: safe.
      if (squaredGap(data_->shapeBox(i), data_->shapeBox(j)) > far * far) continue;
      double distance = 0;
      if (proveApart(data_->shape(i).narrow, X_WA, data_->shape(j).narrow,
                     data_->poses[b] * data_->shape(j).X_BS, motion, apart, distance)) {
        continue;
      }
      proven = false;
      at_most = std::min(at_most, distance);
    }
  }
  return proven;
}

}  // namespace handover
