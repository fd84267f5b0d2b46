// SPDX-License-Identifier: Apache-2.0
// Where everything is at a time of the plan: joints along cubic Hermite curves, the object in a hand or at rest.

/** Position and velocity of every joint of a stage `s` seconds after it began. */
export function stageAt(stage, s) {
  const {t, q, qd} = stage;
  const last = t.length - 1;
  if (s <= 0) return {q: q[0], qd: qd[0]};
  if (s >= t[last]) return {q: q[last], qd: qd[last]};
  let low = 0, high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (t[middle] <= s) low = middle; else high = middle;
  }
  const h = t[high] - t[low], u = (s - t[low]) / h;
  const position = [], velocity = [];
  for (let j = 0; j < stage.joints.length; ++j) {
    const a = q[low][j], b = q[high][j], da = qd[low][j] * h, db = qd[high][j] * h;
    position.push(a + u * (da + u * (3 * (b - a) - 2 * da - db + u * (2 * (a - b) + da + db))));
    velocity.push((da + u * (6 * (b - a) - 4 * da - 2 * db + u * 3 * (2 * (a - b) + da + db))) / h);
  }
  return {q: position, qd: velocity};
}

export function durationOf(stage) { return stage.t[stage.t.length - 1]; }

export function endOf(stage) { return stage.start + durationOf(stage); }

/** A plan's stages over time. */
export class Motion {
  constructor(plan) {
    this.plan = plan;
    this.duration = Math.max(...plan.stages.map(endOf));
  }

  /** Joint positions by robot, then joint. */
  jointsAt(time) {
    const robots = new Map(this.plan.robots.map((robot) => [robot.name, new Map(Object.entries(robot.q_start))]));
    for (const stage of this.plan.stages) {
      if (stage.start > time) continue;
      const {q} = stageAt(stage, time - stage.start);
      stage.joints.forEach((joint, j) => robots.get(stage.robot).set(joint, q[j]));
    }
    return robots;
  }

  /** The stages that run at a time, the one that began last at the end. */
  runningAt(time) {
    return this.plan.stages.filter((stage) => stage.start <= time && time <= endOf(stage))
        .sort((a, b) => a.start - b.start || a.index - b.index);
  }

  /** How the planned object is held at a time, or null when it stands at its start or goal. */
  holdAt(time) {
    const begun = this.plan.stages.filter((stage) => stage.start <= time);
    const running = begun.filter((stage) => time < endOf(stage));
    for (const stage of running.length > 0 ? running : begun.slice(-1)) {
      const hold = stage.holding.find((entry) => entry.object === this.plan.object);
      if (hold) return hold;
    }
    return null;
  }

  /** Where the object stands when nobody holds it. */
  restAt(time) {
    const release = this.plan.stages.find((stage) => stage.kind === 'receiver_release');
    return release && time >= release.start ? this.plan.X_WO_goal : this.plan.X_WO_start;
  }
}
