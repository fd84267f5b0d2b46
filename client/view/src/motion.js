// SPDX-License-Identifier: Apache-2.0
// Where everything is at a time of the plan: joints along quintic Hermite curves, the object in a hand or at rest.

function segmentAt({q, qd, qdd}, low, high, h, u) {
  const at = {q: [], qd: [], qdd: []};
  q[low].forEach((p, j) => {
    const d = q[high][j] - p, v = qd[low][j] * h, w = qd[high][j] * h, a = qdd[low][j] * h * h, b = qdd[high][j] * h * h;
    const c3 = 10 * d - 6 * v - 4 * w - 1.5 * a + 0.5 * b, c4 = -15 * d + 8 * v + 7 * w + 1.5 * a - b,
          c5 = 6 * d - 3 * (v + w) + 0.5 * (b - a);
    at.q.push(p + u * (v + u * (a / 2 + u * (c3 + u * (c4 + u * c5)))));
    at.qd.push((v + u * (a + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / h);
    at.qdd.push((a + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))) / (h * h));
  });
  return at;
}

/** Position, velocity and acceleration of every joint of a stage `s` seconds after it began; it stands before and after. */
export function stageAt(stage, s) {
  const {t} = stage, last = t.length - 1;
  const sample = (i) => ({q: stage.q[i], qd: stage.qd[i], qdd: stage.qdd[i]});
  if (s <= 0) return sample(0);
  if (s >= t[last]) return sample(last);
  let low = 0, high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (t[middle] <= s) low = middle; else high = middle;
  }
  const h = t[high] - t[low];
  return segmentAt(stage, low, high, h, (s - t[low]) / h);
}

export function durationOf(stage) { return stage.t[stage.t.length - 1]; }

export function endOf(stage) { return stage.start + durationOf(stage); }

/** A plan's stages over time; without a plan everything stands where the scene has it. */
export class Motion {
  constructor(scene, plan) {
    this.robots = scene.robots;
    this.stages = plan?.stages ?? [];
    this.in_time = [...this.stages].sort((a, b) => a.start - b.start || a.index - b.index);
    this.duration = Math.max(0, ...this.stages.map(endOf));
    // From the end of a holder's grasp, or the start, to the end of its release, or for good.
    this.holds = (plan?.holders ?? []).map((unused, holder) => {
      const grasp = this.stageOf(holder, 'grasp'), release = this.stageOf(holder, 'release');
      return {from: grasp ? endOf(grasp) : 0, to: release ? endOf(release) : Infinity};
    });
  }

  stageOf(holder, action) { return this.stages.find((stage) => stage.holder === holder && stage.action === action); }

  /** Joint positions by robot, then joint. */
  jointsAt(time) {
    const robots = new Map(this.robots.map((robot) => [robot.name, new Map(Object.entries(robot.q_start))]));
    for (const stage of this.in_time) {
      if (stage.start > time) break;
      const {q} = stageAt(stage, time - stage.start);
      stage.joints.forEach((joint, j) => robots.get(stage.robot).set(joint, q[j]));
    }
    return robots;
  }

  /** The stages that run at a time, the one that began last at the end; those that end with the plan run until its end. */
  runningAt(time) {
    const runs = (stage) => stage.start <= time && (time < endOf(stage) || endOf(stage) === this.duration);
    return this.in_time.filter(runs);
  }

  /** The stage that began last. */
  begunAt(time) { return this.in_time.findLast((stage) => stage.start <= time) ?? this.in_time[0]; }

  /** Which holders have the object at a time: one, two while it changes hands, none where it stands. */
  holdersAt(time) { return [...this.holds.keys()].filter((holder) => this.holds[holder].from <= time && time < this.holds[holder].to); }

  /** When the last holder lets the object go; infinite if it never does. */
  get put_down() { return this.holds.at(-1)?.to ?? Infinity; }
}
