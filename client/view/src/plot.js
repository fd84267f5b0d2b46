// SPDX-License-Identifier: Apache-2.0
// Joint positions, velocities or accelerations of one stage over its time.
import {durationOf, stageAt} from './motion.js';

const COLOURS = ['#1f77b4', '#ff7f0e', '#2ca02c', '#d62728', '#9467bd', '#8c564b', '#e377c2', '#7f7f7f', '#bcbd22',
                 '#17becf', '#3b4a9c', '#a0522d', '#008b5e', '#b8860b', '#c71585', '#556b2f'];
const POINTS = 240;

export class Plot {
  constructor(canvas, legend) { Object.assign(this, {canvas, legend, quantity: 'q'}); }

  /** @param unit of the joints' positions: rad, m, or both. */
  setStage(stage, unit) {
    if (stage === this.stage) return;
    Object.assign(this, {stage, unit});
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
    pen.font = '11px system-ui, "DejaVu Sans", sans-serif';
    if (this.stage.joints.length === 0) {
      this.write(pen, 'no joint moves', 16);
    } else {
      this.drawCurves(pen, width, height);
    }
    const now = 4 + (width - 8) * Math.min(1, Math.max(0, seconds / durationOf(this.stage)));
    pen.strokeStyle = '#d0021b';
    pen.beginPath();
    pen.moveTo(now, 0);
    pen.lineTo(now, height);
    pen.stroke();
  }

  drawCurves(pen, width, height) {
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
    const per = {q: '', qd: '/s', qdd: '/s²'}[this.quantity];
    this.write(pen, `${high.toFixed(2)} ${this.unit}${per}`, 13);
    this.write(pen, low.toFixed(2), height - 6);
  }

  /** On the left, readable where curves pass. */
  write(pen, text, y) {
    pen.fillStyle = 'rgba(255, 255, 255, 0.85)';
    pen.fillRect(4, y - 10, pen.measureText(text).width + 4, 13);
    pen.fillStyle = '#5d6b7c';
    pen.fillText(text, 6, y);
  }
}
