// SPDX-License-Identifier: Apache-2.0
// Handover points of all runs, from above and from the side, over slices of one run's crossed maps.
import {extent} from 'd3-array';
import {axisBottom, axisLeft, axisRight} from 'd3-axis';
import {scaleLinear, scaleSequential} from 'd3-scale';
import {interpolateViridis} from 'd3-scale-chromatic';
import {select} from 'd3-selection';

import {find} from './dom.js';

const WIDTH = 1100, GAP = 80, LEFT = 64, RIGHT = 92, TOP = 30, BOTTOM = 46, MOST_HEIGHT = 620;
const ABOVE = {name: 'from above', across: 0, up: 1, deep: 2};
const SIDES = [
  {name: 'from the side (along +y)', across: 0, up: 2, deep: 1}, {name: 'from the side (along −x)', across: 1, up: 2, deep: 0},
];
const AXES = 'xyz';

export class Places {
  constructor({experiment, more, lattice_edge}) {
    this.svg = select(find('places'));
    this.edge = lattice_edge;
    this.runs = more.map(({lattice, handovers}, i) => ({index: experiment.records[i].index, lattice, handovers}));
    this.placed = this.runs.filter(({handovers}) => handovers.length > 0);
    this.mapped = this.runs.filter(({lattice}) => lattice.length > 0);
    this.chosen = this.mapped[0];
    const choice = find('lattice-run');
    for (const {index} of this.mapped) choice.add(new Option(index));
    choice.addEventListener('change', () => {
      this.chosen = this.mapped[choice.selectedIndex];
      this.draw();
    });
    find('points').addEventListener('change', () => this.draw());
  }

  draw() {
    this.svg.selectAll('*').remove();
    if (this.placed.length === 0 && this.mapped.length === 0) {
      find('places-text').textContent = 'No run came as far as a handover.';
      return;
    }
    const what = find('points').value;
    const points = this.placed.flatMap((run) => run.handovers.map((handover, i) => ({run, name: this.nameOf(run, i), p: handover[what]})));
    const cells = this.chosen?.lattice ?? [];
    // All of both, whichever points and whichever run's cells are shown: so switching keeps the scale.
    const bounds = [0, 1, 2].map((axis) => this.boundsOf(axis));
    // The side on which more is to be seen.
    const [wideX, wideY] = bounds.map(([low, high]) => high - low);
    const views = [ABOVE, SIDES[wideY > wideX ? 1 : 0]];
    const pixels = this.scaleFor(bounds, views);
    // Through the chosen run's own point, else its best cell: the runs' mean may lie beside its maps.
    const through = this.chosen?.handovers[0]?.receiver_tool ?? cells[0];
    const colour = this.colourOf();
    const slices = [];
    let left = LEFT, height = 0;
    for (const view of views) {
      const slice = this.sliceAt(cells, view.deep, through?.[view.deep]);
      slices.push(`${AXES[view.deep]} = ${slice.at?.toFixed(3)} m`);
      height = Math.max(height, this.drawView(view, {left, bounds, pixels, points, slice, colour}));
      left += pixels * (bounds[view.across][1] - bounds[view.across][0]) + GAP;
    }
    this.drawLegend(colour, left - GAP + 24);
    this.svg.attr('viewBox', `0 0 ${WIDTH} ${height}`);
    this.explain(what, points, slices);
  }

  nameOf({index, handovers}, i) { return `run ${index}${handovers.length > 1 ? `, handover ${i + 1}` : ''}`; }

  boundsOf(axis) {
    const half = this.edge / 2;
    const values = this.placed.flatMap(({handovers}) => handovers.flatMap((handover) => Object.values(handover).map((p) => p[axis])))
        .concat(this.mapped.flatMap(({lattice}) => lattice.flatMap((cell) => [cell[axis] - half, cell[axis] + half])));
    const [low, high] = extent(values);
    return [low - half, high + half];
  }

  // Pixels per metre, the same for every axis.
  scaleFor(bounds, views) {
    const size = (axis) => bounds[axis][1] - bounds[axis][0];
    const across = views.reduce((sum, view) => sum + size(view.across), 0);
    const up = Math.max(...views.map((view) => size(view.up)));
    return Math.min((WIDTH - LEFT - RIGHT - GAP * (views.length - 1)) / across, MOST_HEIGHT / up);
  }

  colourOf() {
    const [low, high] = extent(this.mapped.flatMap(({lattice}) => lattice.map(([, , , score]) => score)));
    return low === undefined ? undefined : scaleSequential([low, high], interpolateViridis);
  }

  // The layer of cells whose middle is nearest to `value` on an axis.
  sliceAt(cells, axis, value) {
    if (cells.length === 0) return {cells: []};
    const at = cells.map((cell) => cell[axis]).reduce((a, b) => Math.abs(b - value) < Math.abs(a - value) ? b : a);
    return {at, cells: cells.filter((cell) => Math.abs(cell[axis] - at) < this.edge / 2)};
  }

  drawView({name, across, up}, {left, bounds, pixels, points, slice, colour}) {
    const width = pixels * (bounds[across][1] - bounds[across][0]), height = pixels * (bounds[up][1] - bounds[up][0]);
    const x = scaleLinear(bounds[across], [left, left + width]);
    const y = scaleLinear(bounds[up], [TOP + height, TOP]);
    const view = this.svg.append('g').attr('class', 'view');
    view.append('rect').attr('class', 'frame').attr('x', left).attr('y', TOP).attr('width', width).attr('height', height);
    view.selectAll('.cell').data(slice.cells).join('rect')
        .attr('class', 'cell')
        .attr('x', (cell) => x(cell[across] - this.edge / 2) + 0.5)
        .attr('y', (cell) => y(cell[up] + this.edge / 2) + 0.5)
        .attr('width', pixels * this.edge - 1)
        .attr('height', pixels * this.edge - 1)
        .attr('fill', (cell) => colour(cell[3]))
        .append('title').text((cell) => `${cell.slice(0, 3).map((v) => v.toFixed(3)).join(', ')} m: ${cell[3].toFixed(4)}`);
    const chosenLast = [...points].sort((a, b) => (a.run === this.chosen) - (b.run === this.chosen));
    view.selectAll('.point').data(chosenLast).join('circle')
        .attr('class', ({run}) => run === this.chosen ? 'point chosen' : 'point')
        .attr('cx', ({p}) => x(p[across]))
        .attr('cy', ({p}) => y(p[up]))
        .attr('r', ({run}) => run === this.chosen ? 6 : 4)
        .append('title').text(({name, p}) => `${name}: ${p.map((v) => v.toFixed(3)).join(', ')} m`);
    view.append('g').attr('transform', `translate(0,${TOP + height})`).call(axisBottom(x).ticks(Math.max(2, width / 70)));
    view.append('g').attr('transform', `translate(${left},0)`).call(axisLeft(y).ticks(Math.max(2, height / 60)));
    view.append('text').attr('x', left).attr('y', TOP - 10).text(name);
    view.append('text').attr('x', left + width / 2).attr('y', TOP + height + 38).attr('text-anchor', 'middle').text(`${AXES[across]} [m]`);
    view.append('text').attr('transform', `translate(${left - 48},${TOP + height / 2}) rotate(-90)`)
        .attr('text-anchor', 'middle').text(`${AXES[up]} [m]`);
    return TOP + height + BOTTOM;
  }

  drawLegend(colour, left) {
    if (!colour) return;
    const [low, high] = colour.domain(), steps = 40, height = 160;
    const y = scaleLinear([low, high], [TOP + height, TOP]);
    for (let i = 0; i < steps; ++i) {
      const value = low + (high - low) * (i + 0.5) / steps;
      this.svg.append('rect').attr('x', left).attr('width', 14).attr('y', TOP + height * (steps - 1 - i) / steps)
          .attr('height', height / steps + 0.5).attr('fill', colour(value));
    }
    this.svg.append('g').attr('transform', `translate(${left + 14},0)`).call(axisRight(y).ticks(5));
    this.svg.append('text').attr('x', left).attr('y', TOP - 10).text('score');
  }

  explain(what, points, slices) {
    const spot = what === 'object' ? 'the object’s origin' : 'the receiver’s tool';
    let text = `Circles: where ${spot} is when the object changes hands, ${points.length} in ${this.placed.length} solved runs; some may cover others.`;
    if (this.chosen) {
      const edge = (this.edge * 100).toFixed(0), solved = this.chosen.handovers.length > 0;
      text += ` Squares: cells (${edge} cm) near the shoulders’ midpoint that both arms reach, as places of the receiver’s tool, coloured` +
          ` by the mean of both maps’ manipulability. They are those of run ${this.chosen.index}: how the maps cross depends on where a` +
          ` run’s robots stand. Of them, the layers ${slices.join(' and ')}` +
          (solved ? `, where the run’s first handover has the receiver’s tool; the run’s circles are red.` : ', where its best cell is.');
    }
    find('places-text').textContent = text;
  }
}
