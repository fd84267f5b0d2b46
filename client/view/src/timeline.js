// SPDX-License-Identifier: Apache-2.0
// The stages as bars, a row for each holder, with the cursor of the time shown.
import {armOf, coloursOf, labelOf} from './holders.js';
import {durationOf, endOf} from './motion.js';

const NAMESPACE = 'http://www.w3.org/2000/svg';
const BAR = 26, GAP = 4, NAME = 17, LETTER = 6.6;  // a letter's width in both sizes of text, about
const NARROW = 600;

function make(name, attributes, parent, text) {
  const element = document.createElementNS(NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  parent.append(element);
  return element;
}

export class Timeline {
  constructor(svg, plan, duration, onTime) {
    Object.assign(this, {svg, plan, duration});
    this.names = plan.holders.map(armOf);
    this.colours = coloursOf(plan.holders);
    const pick = (event) => {
      const share = (event.clientX - svg.getBoundingClientRect().left - this.left) / (this.width - this.left);
      onTime(Math.min(1, Math.max(0, share)) * duration);
    };
    svg.addEventListener('pointerdown', (event) => {
      svg.setPointerCapture(event.pointerId);
      pick(event);
    });
    svg.addEventListener('pointermove', (event) => { if (event.buttons) pick(event); });
    new ResizeObserver(() => { if (svg.clientWidth !== this.width) this.draw(); }).observe(svg);
  }

  xOf(time) { return this.left + (time / this.duration) * (this.width - this.left); }

  /** Names stand left of their rows; above them where there is no room for that. */
  layOut() {
    this.width = this.svg.clientWidth;
    this.above = this.width < NARROW;
    this.left = this.above ? 0 : LETTER * Math.max(...this.names.map((name) => name.length)) + 12;
    this.row = BAR + GAP + (this.above ? NAME : 0);
    this.height = this.row * this.names.length;
    this.svg.style.height = `${this.height}px`;
  }

  draw() {
    this.layOut();
    this.svg.replaceChildren();
    this.names.forEach((name, holder) => {
      const top = holder * this.row + (this.above ? NAME : 0);
      make('text', {x: 0, y: this.above ? top - 4 : top + 17, class: 'name', fill: this.colours[holder].strong}, this.svg, name);
      for (const stage of this.plan.stages.filter((entry) => entry.holder === holder)) this.drawBar(stage, top);
    });
    this.cursor = make('line', {y1: 0, y2: this.height}, this.svg);
    this.setTime(this.time ?? 0, this.running ?? []);
  }

  drawBar(stage, top) {
    const x = this.xOf(stage.start), width = this.xOf(endOf(stage)) - x, colour = this.colours[stage.holder].strong;
    const group = make('g', {class: 'bar', fill: colour, stroke: colour}, this.svg);
    group.dataset.stage = stage.index;
    make('title', {}, group, `${labelOf(this.plan, stage)}: ${stage.start.toFixed(2)} s, ${durationOf(stage).toFixed(2)} s long`);
    make('rect', {x: x + 0.5, y: top + 0.5, width: Math.max(1, width - 1), height: BAR - 1, rx: 3}, group);
    if (width > stage.action.length * LETTER + 10) make('text', {x: x + 5, y: top + 17}, group, stage.action);
  }

  setTime(time, running) {
    Object.assign(this, {time, running});
    if (!this.cursor) return;
    this.cursor.setAttribute('x1', this.xOf(time));
    this.cursor.setAttribute('x2', this.xOf(time));
    for (const bar of this.svg.querySelectorAll('.bar')) {
      bar.classList.toggle('runs', running.some((stage) => stage.index === Number(bar.dataset.stage)));
    }
  }
}
