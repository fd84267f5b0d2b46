// SPDX-License-Identifier: Apache-2.0
// The stages as bars, a row for each robot, with the cursor of the time shown.
import {durationOf} from './motion.js';

const NAMESPACE = 'http://www.w3.org/2000/svg';
const ROW = 30, LEFT = 74;

function make(name, attributes, parent) {
  const element = document.createElementNS(NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

export class Timeline {
  constructor(svg, plan, duration, onTime) {
    Object.assign(this, {svg, plan, duration});
    const pick = (event) => {
      const box = svg.getBoundingClientRect();
      const share = (event.clientX - box.left - LEFT) / (box.width - LEFT);
      onTime(Math.min(1, Math.max(0, share)) * duration);
    };
    svg.addEventListener('pointerdown', (event) => {
      svg.setPointerCapture(event.pointerId);
      pick(event);
    });
    svg.addEventListener('pointermove', (event) => { if (event.buttons) pick(event); });
    new ResizeObserver(() => this.draw()).observe(svg);
  }

  xOf(time) { return LEFT + (time / this.duration) * (this.width - LEFT); }

  draw() {
    this.width = this.svg.clientWidth;
    this.svg.replaceChildren();
    [this.plan.giver, this.plan.receiver].forEach((robot, row) => {
      make('text', {x: 0, y: row * ROW + 20, class: 'row'}, this.svg).textContent = robot;
      for (const stage of this.plan.stages.filter((entry) => entry.robot === robot)) {
        const x = this.xOf(stage.start), width = this.xOf(stage.start + durationOf(stage)) - x;
        const bar = make('rect', {x, y: row * ROW + 2, width, height: ROW - 4, rx: 3, class: row ? 'receiver' : 'giver'}, this.svg);
        bar.dataset.stage = stage.index;
        make('title', {}, bar).textContent =
            `${stage.kind}: ${stage.start.toFixed(2)} s, ${durationOf(stage).toFixed(2)} s long`;
        const label = stage.kind.replace(/^(giver|receiver)_/, '');
        if (width > label.length * 7 + 6) make('text', {x: x + 5, y: row * ROW + 19}, this.svg).textContent = label;
      }
    });
    this.cursor = make('line', {y1: 0, y2: 2 * ROW}, this.svg);
    this.setTime(this.time ?? 0, this.running ?? []);
  }

  setTime(time, running) {
    Object.assign(this, {time, running});
    if (!this.cursor) return;
    this.cursor.setAttribute('x1', this.xOf(time));
    this.cursor.setAttribute('x2', this.xOf(time));
    for (const bar of this.svg.querySelectorAll('rect')) {
      bar.classList.toggle('off', !running.some((stage) => stage.index === Number(bar.dataset.stage)));
    }
  }
}
