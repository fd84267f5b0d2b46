// SPDX-License-Identifier: Apache-2.0
// What a plan is like, as a table, and the object's lean over time.
import {max} from 'd3-array';
import {axisBottom, axisLeft} from 'd3-axis';
import {scaleLinear} from 'd3-scale';
import {select} from 'd3-selection';

import {armOf} from './holders.js';

const WIDTH = 328, HEIGHT = 130, LEFT = 34, RIGHT = 8, TOP = 8, BOTTOM = 22;

const secondsOf = (value) => `${value.toFixed(1)} s`;
const degreesOf = (value) => `${value.toFixed(1)}°`;
const percentOf = (value) => `${(100 * value).toFixed(0)} %`;

function clearanceRow({between, least_m: least, pair}) {
  const figure = `${(1000 * least).toFixed(0)} mm`;
  return [`clearance, ${between}`, pair ? figure : `over ${figure}`, pair ? `${pair[0]} – ${pair[1]}` : ''];
}

/** Rows of name, figure, and what it is about. */
export function qualityRows(quality, plan) {
  const {duration_s: duration, bound_s: bound, object_turn_deg: [turn, least]} = quality;
  return [
    ['duration', secondsOf(duration), `${secondsOf(bound)} at least`],
    ['object under way', secondsOf(quality.object_s), ''],
    ...Object.entries(quality.idle_s).map(([robot, idle]) => ['idle with it', secondsOf(idle), robot]),
    ...quality.clearance.map(clearanceRow),
    ['tilt', degreesOf(quality.tilt_deg), 'beyond start and goal'],
    ['turn', degreesOf(turn), `${degreesOf(least)} from start to goal`],
    ...quality.grip.map(({holder, of_best: share}) => ['grip', percentOf(share), `of the best of ${armOf(plan.holders[holder])}`]),
    ...(quality.limit_margin === null ? [] : [['joint limits', percentOf(quality.limit_margin), 'of a range left']]),
    ['jerk', percentOf(quality.jerk_share), 'of its limit'],
  ];
}

/** The angle of the object's axis to the vertical. */
export class LeanCurve {
  /** @param angles degrees, evenly from 0 to `duration`. @param ends  the larger one of start and goal. */
  constructor(svg, angles, ends, duration) {
    this.x = scaleLinear([0, duration], [LEFT, WIDTH - RIGHT]);
    const y = scaleLinear([0, Math.max(5, max(angles))], [HEIGHT - BOTTOM, TOP]).nice();
    const drawing = select(svg).attr('viewBox', `0 0 ${WIDTH} ${HEIGHT}`);
    drawing.append('g').attr('transform', `translate(0,${HEIGHT - BOTTOM})`).call(axisBottom(this.x).ticks(6).tickFormat((t) => `${t} s`));
    drawing.append('g').attr('transform', `translate(${LEFT},0)`).call(axisLeft(y).ticks(4).tickFormat((angle) => `${angle}°`));
    drawing.append('line').attr('class', 'ends').attr('x1', LEFT).attr('x2', WIDTH - RIGHT).attr('y1', y(ends)).attr('y2', y(ends))
        .append('title').text(`${degreesOf(ends)}: the larger of start and goal`);
    const at = (angle, i) => `${this.x(duration * i / (angles.length - 1)).toFixed(1)},${y(angle).toFixed(1)}`;
    drawing.append('polyline').attr('points', angles.map(at).join(' '));
    this.cursor = drawing.append('line').attr('class', 'cursor').attr('y1', TOP).attr('y2', HEIGHT - BOTTOM);
  }

  setTime(time) { this.cursor.attr('x1', this.x(time)).attr('x2', this.x(time)); }
}
