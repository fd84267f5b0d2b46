// SPDX-License-Identifier: Apache-2.0
// The page of one experiment: its tables, and what places and histogram draw.
import {Histogram} from './histogram.js';
import {Places} from './places.js';
import {RunTable} from './run_table.js';
import {element, find, link, number, seconds, table} from './dom.js';

function header({experiment, task, versions}) {
  const {summary} = experiment;
  const title = `${experiment.cell}: ${summary.solved} of ${summary.runs} runs solved`;
  document.title = title;
  find('title').textContent = title;
  const setting = {
    cell: experiment.cell, task, seed: experiment.seed, mode: experiment.mode, search: experiment.search,
    objective: experiment.objective, stretch: experiment.stretch, machine: experiment.machine, handoverctl: versions.handoverctl,
    handoverd: versions.handoverd,
  };
  for (const [name, value] of Object.entries(setting)) {
    const pair = element('div');
    pair.append(element('dt', name), element('dd', String(value)));
    find('setting').append(pair);
  }
}

/** Of what records have: those without are left out; undefined where none has it. */
function meanOf(records, key) {
  const values = records.map((record) => record[key]).filter((value) => value !== null && value !== undefined);
  return values.length > 0 ? values.reduce((sum, value) => sum + value, 0) / values.length : undefined;
}

// The paper's |G_g| is a fraction although giver and start never vary, so what it counts is open: both counts are shown.
function means({experiment, paper}) {
  const {summary, records} = experiment;
  const rows = [
    ['planning time [s]', paper?.planning_time_s, summary.planning_time_s?.mean, seconds],
    ['giver’s grasps |G_g|, at the start (§IV-C)', paper?.grasps_giver, summary.grasps_giver_mean, number],
    ['giver’s grasps |G_g*|, for each handover pose', undefined, meanOf(records, 'grasps_giver_per_pose'), number],
    ['receiver’s grasps |G_r|, at the goal (§IV-B)', paper?.grasps_receiver, summary.grasps_receiver_mean, number],
    ['receiver’s grasps, for each handover pose', undefined, meanOf(records, 'grasps_receiver_per_pose'), number],
    ['handover poses', paper?.handover_poses, summary.handover_poses_mean, number],
  ];
  table(find('means'), paper ? ['means', 'paper', 'ours'] : ['means', 'ours'], rows.map(
      ([what, theirs, ours, text]) => paper ? [what, number(theirs), text(ours)] : [what, text(ours)]), 1);
  find('paper').textContent = paper ?
      `Paper: Table ${paper.table}, 100 runs, all solved; its counts are those of --search paper --mode all.` :
      'The paper has no such scene.';
  spreads(find('spreads'), 'seconds', [['to the outcome', summary.planning_time_s], ['to the first plan', summary.first_plan_s]], seconds);
  find('redrawn').textContent = summary.redrawn === 0 ? 'No start scene touched, so no run was drawn again.' :
      `Drawn again, as the start touches: ${touched(summary)}.`;
}

function touched({redrawn, touched: pairs}) {
  return pairs ? pairs.map(({pair, count}) => `${pair.join(' – ')} (${count} ×)`).join(', ') : `${redrawn} runs`;
}

function spreads(target, head, rows, text) {
  const there = rows.filter(([, spread]) => spread);
  table(target, [head, 'mean', 'median', 'p95', 'max'], there.map(
      ([what, spread]) => [what, ...['mean', 'median', 'p95', 'max'].map((key) => text(spread[key]))]), 1);
}

// What the plans are like that solved runs ended with.
function qualities({experiment: {summary}}) {
  const {duration_s, object_s, duration_over_bound} = summary;
  const clearances = [['to furniture', summary.clearance_furniture_m], ['between robots', summary.clearance_robots_m]].filter(([, spread]) => spread);
  find('qualities-section').hidden = !duration_s && clearances.length === 0;
  spreads(find('qualities'), 'plans', [['duration [s]', duration_s], ['object under way [s]', object_s],
                                       ['duration, of the shortest possible', duration_over_bound]], number);
  find('clearances').hidden = clearances.length === 0;
  const millimetres = (metres) => (1000 * metres).toFixed(1);
  table(find('clearances'), ['least clearance [mm]', 'median', 'min'], clearances.map(
      ([what, {median, min}]) => [what, millimetres(median), millimetres(min)]), 1);
}

function shownText(more) {
  const pages = more.filter(({page}) => page).length;
  return pages > 0 ? ` “Show it” leads to the picture of a failure (${pages} have one), in a file beside this one.` : '';
}

// By reason, most frequent first.
function failures({experiment, more}) {
  const reasons = new Map();
  experiment.records.forEach((record, i) => {
    if (record.outcome === 'done') return;
    const reason = record.reason ?? record.outcome;
    if (!reasons.has(reason)) reasons.set(reason, []);
    reasons.get(reason).push([record, more[i]]);
  });
  const failed = experiment.records.length - experiment.summary.solved;
  find('failures-text').textContent = failed === 0 ? 'Every run was solved.' :
      `${failed} of ${experiment.records.length}. A command repeats its run with a daemon that serves the cell.${shownText(more)}`;
  if (failed === 0) return;
  table(find('failures'), ['reason', 'run', 'explanation and command'], [], 3);
  const body = find('failures').tBodies[0];
  for (const [reason, runs] of [...reasons].sort((a, b) => b[1].length - a[1].length)) {
    runs.forEach(([record, {command, page}], i) => {
      const row = body.insertRow();
      if (i === 0) {
        const cell = element('th', `${reason} (${runs.length} ×)`);
        cell.rowSpan = runs.length;
        row.append(cell);
      }
      const text = element('td', record.explanation ?? '');
      if (page) text.append(' ', link(page, 'Show it'));
      text.append(element('br'), element('code', command));
      row.append(element('td', String(record.index), 'number'), text);
    });
  }
}

function violations({experiment}) {
  const invalid = experiment.records.filter((record) => record.violations?.length > 0);
  find('violations-section').hidden = invalid.length === 0;
  table(find('violations'), ['run', 'violations'], invalid.map(
      (record) => [String(record.index), record.violations.join('\n')]), 2);
}

try {
  const data = JSON.parse(find('data').textContent);
  header(data);
  means(data);
  qualities(data);
  new Histogram(find('times'), find('times-text'), data).draw();
  failures(data);
  violations(data);
  new Places(data).draw();
  new RunTable(find('runs'), data).draw();
} catch (error) {
  find('error').textContent = `This experiment cannot be shown: ${error.message}`;
  find('error').hidden = false;
  throw error;
}
