// SPDX-License-Identifier: Apache-2.0
// How many runs took how long, with mean, median and p95 marked.
import {bin, max} from 'd3-array';
import {axisBottom, axisLeft} from 'd3-axis';
import {scaleLinear} from 'd3-scale';
import {select} from 'd3-selection';

const WIDTH = 1100, HEIGHT = 300, LEFT = 56, RIGHT = 120, TOP = 64, BOTTOM = 44;  // the right holds marks' labels too
const ROW = 17;  // of the marks' labels

export class Histogram {
  constructor(svg, text, {experiment, paper}) {
    this.svg = select(svg).attr('viewBox', `0 0 ${WIDTH} ${HEIGHT}`);
    this.text = text;
    this.records = experiment.records;
    this.spread = experiment.summary.planning_time_s;
    this.paper = paper;
  }

  draw() {
    if (!this.spread) return;
    // Milliseconds where seconds would be all zeros after the point.
    const [unit, scale] = this.spread.max < 1 ? ['ms', 1e3] : ['s', 1];
    const timeOf = (record) => record.planning_time_s * scale;
    const x = scaleLinear([0, this.spread.max * scale || 1], [LEFT, WIDTH - RIGHT]).nice();
    // So many bins that those of the middle hold several runs where there are many.
    const about = Math.min(50, Math.max(24, 2.5 * Math.sqrt(this.records.length)));
    const bins = bin().value(timeOf).domain(x.domain()).thresholds(x.ticks(about))(this.records).filter((b) => b.x1 > b.x0);
    const y = scaleLinear([0, max(bins, (b) => b.length)], [HEIGHT - BOTTOM, TOP]).nice();
    const whole = y.ticks(6).filter(Number.isInteger);

    const bars = bins.flatMap((b) => {
      const solved = b.filter((record) => record.outcome === 'done').length;
      return [{b, kind: 'done', from: 0, to: solved}, {b, kind: 'failed', from: solved, to: b.length}];
    }).filter(({from, to}) => to > from);
    this.svg.selectAll('.bar').data(bars).join('rect')
        .attr('class', ({kind}) => `bar ${kind}`)
        .attr('x', ({b}) => x(b.x0) + 0.5)
        .attr('width', ({b}) => Math.max(1, x(b.x1) - x(b.x0) - 1))
        .attr('y', ({to}) => y(to))
        .attr('height', ({from, to}) => y(from) - y(to))
        .append('title').text(({b, kind, from, to}) => `${to - from} ${kind} in ${b.x0} to ${b.x1} ${unit}`);
    this.svg.append('g').attr('transform', `translate(0,${HEIGHT - BOTTOM})`).call(axisBottom(x));
    this.svg.append('g').attr('transform', `translate(${LEFT},0)`)
        .call(axisLeft(y).tickValues(whole).tickFormat(String));
    this.svg.append('text').attr('x', (LEFT + WIDTH - RIGHT) / 2).attr('y', HEIGHT - 6).attr('text-anchor', 'middle')
        .text(`planning time, request to outcome [${unit}]`);
    this.svg.append('text').attr('transform', `translate(14,${(TOP + HEIGHT - BOTTOM) / 2}) rotate(-90)`)
        .attr('text-anchor', 'middle').text('runs');
    this.marks(x, unit, scale);
    this.legend();
    this.explain();
  }

  // Each label stands right of its line and above the lines that follow.
  marks(x, unit, scale) {
    const digits = unit === 'ms' ? 1 : 2;
    const keys = ['mean', 'median', 'p95'].sort((a, b) => this.spread[a] - this.spread[b]);
    keys.forEach((key, i) => {
      const value = this.spread[key] * scale, at = x(value), baseline = 13 + ROW * i;
      this.svg.append('line').attr('class', 'mark').attr('x1', at).attr('x2', at).attr('y1', baseline - 10).attr('y2', HEIGHT - BOTTOM);
      this.svg.append('text').attr('class', 'mark-label').attr('x', at + 5).attr('y', baseline)
          .text(`${key} ${value.toFixed(digits)} ${unit}`);
    });
  }

  legend() {
    if (this.records.every((record) => record.outcome === 'done')) return;
    ['done', 'failed'].forEach((kind, i) => {
      const at = this.svg.append('g').attr('transform', `translate(${WIDTH - RIGHT + 20},${TOP + 20 + ROW * i})`);
      at.append('rect').attr('class', `legend bar ${kind}`).attr('width', 12).attr('height', 12);
      at.append('text').attr('x', 18).attr('y', 10.5).text(kind === 'done' ? 'solved' : 'not solved');
    });
  }

  explain() {
    this.text.textContent = `From the write of the request to its outcome, at the client; mean ${this.spread.mean.toFixed(4)} s.` +
        (this.paper ? ` The paper’s mean is ${this.paper.planning_time_s.toFixed(2)} s (Table ${this.paper.table}), on its own machine.` : '');
  }
}
