// SPDX-License-Identifier: Apache-2.0
// Where a fix puts a robot: what of its changes speaks of the pose of a base.
import * as THREE from 'three';

function numbersIn(text) {
  const numbers = text?.split(',').map(Number) ?? [];
  return numbers.length === 3 && numbers.every(Number.isFinite) ? numbers : undefined;
}

/** Roll, pitch and yaw about fixed axes, x first, of a base; the angles of a quaternion. */
function quaternionOf(rpy_deg) {
  const [roll, pitch, yaw] = rpy_deg.map(THREE.MathUtils.degToRad);
  return new THREE.Quaternion().setFromEuler(new THREE.Euler(roll, pitch, yaw, 'ZYX'));
}

/** [{robot, matrix}] of the robots that the changes move: the matrix is X_WB. */
export function movedBases(changes, robots) {
  const moved = new Map();
  for (const {path, value} of changes ?? []) {
    const [, name, key] = path.match(/^robots\.(.+)\.base(?:\.(xyz|rpy_deg))?$/) ?? [];
    const robot = robots.find((entry) => entry.name === name);
    if (!robot) continue;
    const part = (wanted) => {
      if (key !== undefined && key !== wanted) return undefined;
      const pattern = key === undefined ? new RegExp(`${wanted}: *\\[([^\\]]*)\\]`) : /\[([^\]]*)\]/;
      return numbersIn(String(value).match(pattern)?.[1]);
    };
    const [w, x, y, z] = robot.X_WB.quat_wxyz;
    const before = moved.get(name) ?? {position: new THREE.Vector3(...robot.X_WB.xyz), rotation: new THREE.Quaternion(x, y, z, w)};
    const xyz = part('xyz'), rpy_deg = part('rpy_deg');
    moved.set(name, {position: xyz ? new THREE.Vector3(...xyz) : before.position, rotation: rpy_deg ? quaternionOf(rpy_deg) : before.rotation});
  }
  const one = new THREE.Vector3(1, 1, 1);
  return [...moved].map(([robot, {position, rotation}]) => ({robot, matrix: new THREE.Matrix4().compose(position, rotation, one)}));
}
