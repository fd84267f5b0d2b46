// SPDX-License-Identifier: Apache-2.0
#include "core/collision/moving_balls.hpp"

#include "core/collision/scene_data.hpp"

#include <algorithm>

namespace handover {
namespace {

/// Of some balls, one round them all.
Ball ballRound(const std::vector<Ball>& balls) {
  Ball all;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const Ball& ball : balls) {
    if (ball.radius < 0) continue;
    sum += ball.middle;
    ++count;
  }
  if (count == 0) return all;
  all.middle = sum / count;
  for (const Ball& ball : balls) {
    if (ball.radius < 0) continue;
    all.radius = std::max(all.radius, (ball.middle - all.middle).norm() + ball.radius);
  }
  return all;
}

/// Round the boxes of a body's shapes, their margins included; in the group that the body moves
/// with.
void addBalls(const CollisionScene::Data& scene, const MovingBody& body, std::vector<Ball>& balls) {
  const std::size_t id = body.body;
  for (int i = scene.first_shape[id]; i < scene.first_shape[id + 1]; ++i) {
    const SceneShape& shape = scene.shapes[static_cast<std::size_t>(i)];
    balls.push_back({body.X_GB * shape.X_BBox.translation(), shape.box_half.norm()});
  }
}

}  // namespace

void setBalls(const CollisionScene& scene, const std::vector<MovingBody>& bodies,
              RigidGroups& groups) {
  std::vector<std::vector<Ball>> balls(static_cast<std::size_t>(groups.size()));
  for (const MovingBody& it : bodies) {
    addBalls(scene.data(), it, balls[static_cast<std::size_t>(it.group)]);
  }
  for (int group = 0; group < groups.size(); ++group) {
    groups.setBall(group, ballRound(balls[static_cast<std::size_t>(group)]));
  }
}

}  // namespace handover
