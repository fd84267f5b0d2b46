// SPDX-License-Identifier: Apache-2.0
// Joint positions or velocities of one stage over its time.
import {durationOf, stageAt} from './motion.js';

const COLOURS = ['#1f77b4', '#ff7f0e', '#2ca02c', '#d62728', '#9467bd', '#8c564b', '#e377c2', '#7f7f7f', '#bcbd22',
                 '#17becf', '#3b4a9c', '#a0522d', '#008b5e', '#b8860b', '#c71585', '#556b2f'];
const POINTS = 240;

export class Plot {
  constructor(canvas, legend) { Object.assign(this, {canvas, legend, quantity: 'q'}); }

  setStage(stage) {
    if (stage === this.stage) return;
    this.stage = stage;
    this.legend.replaceChildren();
    stage.joints.forEach((joint, j) => {
      const item = document.createElement('li');
      const swatch = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
      swatch.setAttribute('width', 14);
      swatch.setAttribute('height', 4);
      const line = document.createElementNS('http://www.w3.org/2000/svg', 'rect');
      for (const [key, value] of Object.entries({width: 14, height: 4, fill: COLOURS[j % COLOURS.length]})) line.setAttribute(key, value);
      swatch.append(line);
      item.append(swatch, joint.replace(/_joint$/, ''));
      this.legend.append(item);
    });
    const duration = durationOf(stage);
    this.rows = Array.from({length: POINTS + 1}, (unused, i) => stageAt(stage, duration * i / POINTS));
  }

  draw(seconds) {
    const scale = window.devicePixelRatio || 1;
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    this.canvas.width = width * scale;
    this.canvas.height = height * scale;
    const pen = this.canvas.getContext('2d');
    pen.scale(scale, scale);
    const values = this.rows.map((row) => row[this.quantity]);
    let low = Math.min(...values.flat()), high = Math.max(...values.flat());
    const pad = Math.max(0.02, 0.06 * (high - low));
    low -= pad;
    high += pad;
    const x = (i) => 4 + (width - 8) * i / POINTS;
    const y = (value) => height - 4 - (height - 8) * (value - low) / (high - low);
    pen.strokeStyle = '#d5dbe3';
    pen.beginPath();
    if (low < 0 && high > 0) {
      pen.moveTo(0, y(0));
      pen.lineTo(width, y(0));
    }
    pen.stroke();
    this.stage.joints.forEach((unused, j) => {
      pen.strokeStyle = COLOURS[j % COLOURS.length];
      pen.lineWidth = 1.4;
      pen.beginPath();
      values.forEach((row, i) => { pen[i ? 'lineTo' : 'moveTo'](x(i), y(row[j])); });
      pen.stroke();
    });
    const now = x(POINTS * Math.min(1, Math.max(0, seconds / durationOf(this.stage))));
    pen.strokeStyle = '#d0021b';
    pen.beginPath();
    pen.moveTo(now, 0);
    pen.lineTo(now, height);
    pen.stroke();
    pen.fillStyle = '#5d6b7c';
    pen.font = '11px system-ui, "DejaVu Sans", sans-serif';
    const unit = this.quantity === 'q' ? '' : '/s';
    pen.fillText(`${high.toFixed(2)} rad${unit}`, 6, 13);
    pen.fillText(`${low.toFixed(2)}`, 6, height - 6);
  }
}
