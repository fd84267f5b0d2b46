// SPDX-License-Identifier: Apache-2.0
// All runs; a click on a column's head sorts by it, another one the other way.
import {element, find, link} from './dom.js';

const PARTS = {xyz: ['x', 'y', 'z'], rpy_deg: ['roll', 'pitch', 'yaw'], quat_wxyz: ['w', 'x', 'y', 'z']};

function text(value, digits) {
  if (value === null || value === undefined) return '–';
  if (digits !== undefined) return value.toFixed(digits);
  if (typeof value !== 'number' || Number.isInteger(value)) return String(value);
  return value.toFixed(4);
}

// A column for each drawn number or word: "robots.hubo.base x" of robots.hubo.base.xyz.
function drawnColumns(records) {
  const columns = [];
  for (const [path, value] of Object.entries(records[0]?.drawn ?? {})) {
    const keys = path.split('.');
    const parts = PARTS[keys.at(-1)];
    if (!Array.isArray(value)) {
      columns.push({name: path, of: (record) => record.drawn[path]});
      continue;
    }
    value.forEach((unused, i) => {
      const name = parts ? `${keys.slice(0, -1).join('.')} ${parts[i]}${keys.at(-1) === 'rpy_deg' ? ' [°]' : ''}` : `${path} ${i}`;
      columns.push({name, of: (record) => record.drawn[path]?.[i]});
    });
  }
  return columns;
}

/** The least of a plan, in mm. */
function clearanceOf({quality}) {
  return quality ? 1000 * Math.min(...quality.clearance.map(({least_m}) => least_m)) : undefined;
}

export class RunTable {
  constructor(table, {experiment, more}) {
    this.table = table;
    this.rows = experiment.records.map((record, i) => ({record, command: more[i].command, page: more[i].page}));
    const drawn = drawnColumns(experiment.records);
    const varies = ({of}) => experiment.records.some((record) => of(record) !== of(experiment.records[0]));
    const constant = experiment.records.length > 1 ? drawn.filter((column) => !varies(column)) : [];
    if (constant.length > 0) {
      find('constant').textContent = `The same in every run: ${
          constant.map(({name, of}) => `${name} = ${text(of(experiment.records[0]))}`).join(', ')}.`;
    }
    this.columns = [
      {name: 'run', of: (record) => record.index},
      ...drawn.filter((column) => !constant.includes(column)),
      {name: 'drawn again', of: (record) => record.redrawn},
      {name: 'outcome', of: (record) => record.reason ?? record.outcome, linked: true},
      {name: 'time [s]', of: (record) => record.planning_time_s},
      {name: 'first plan [s]', of: (record) => record.first_plan_s},
      {name: 'giver’s grasps', of: (record) => record.grasps_giver},
      {name: 'receiver’s grasps', of: (record) => record.grasps_receiver},
      {name: 'poses', of: (record) => record.handover_poses},
      {name: 'tuples', of: (record) => record.tuples},
      ...[
        {name: 'failure known [s]', of: (record) => record.failure_s},
        {name: 'first cost', of: (record) => record.first_cost, digits: 2},
        {name: 'cost', of: (record) => record.cost, digits: 2},
        {name: 'motion [s]', of: (record) => record.quality?.duration_s, digits: 1},
        {name: 'clear [mm]', of: clearanceOf, digits: 1},
      ].filter(({of}) => experiment.records.some((record) => typeof of(record) === 'number')),
    ];
    for (const column of this.columns) {
      column.numeric = this.rows.some(({record}) => typeof column.of(record) === 'number');
    }
    this.sorted = this.columns[0];
    this.descending = false;
  }

  draw() {
    const head = this.table.createTHead().insertRow();
    for (const column of this.columns) {
      const cell = element('th', '', column.numeric ? 'number' : '');
      const button = element('button');
      for (const part of column.name.split(/(?<=\.)/)) button.append(part, element('wbr'));
      button.addEventListener('click', () => this.sortBy(column));
      cell.append(button);
      head.append(cell);
      column.head = cell;
    }
    this.body = this.table.createTBody();
    for (const row of this.rows) {
      row.shown = this.body.insertRow();
      row.shown.className = row.record.outcome === 'done' ? '' : 'failed';
      row.shown.title = row.command;
      for (const {of, numeric, digits, linked} of this.columns) {
        const cell = element('td', '', numeric ? 'number' : ''), value = text(of(row.record), digits);
        cell.append(linked && row.page ? link(row.page, value) : value);
        row.shown.append(cell);
      }
    }
    this.arrange();
  }

  sortBy(column) {
    this.descending = column === this.sorted && !this.descending;
    this.sorted = column;
    this.arrange();
  }

  // What a run does not have comes last either way; equal runs stay in the order of their indices.
  arrange() {
    const {of, numeric} = this.sorted, sign = this.descending ? -1 : 1;
    const compare = (a, b) => {
      const [left, right] = [of(a.record), of(b.record)];
      const [noLeft, noRight] = [left ?? null, right ?? null].map((value) => value === null);
      if (noLeft || noRight) return noLeft - noRight;
      return sign * (numeric ? left - right : String(left).localeCompare(String(right)));
    };
    this.body.append(...[...this.rows].sort(compare).map(({shown}) => shown));
    for (const {head} of this.columns) head.removeAttribute('aria-sort');
    this.sorted.head.setAttribute('aria-sort', this.descending ? 'descending' : 'ascending');
  }
}
