// SPDX-License-Identifier: Apache-2.0
// The page of one experiment: its tables, and what places and histogram draw.
import {Histogram} from './histogram.js';
import {Places} from './places.js';
import {RunTable} from './run_table.js';
import {element, find, number, seconds, table} from './dom.js';

function header({experiment, task, versions}) {
  const {summary} = experiment;
  const title = `${experiment.cell}: ${summary.solved} of ${summary.runs} runs solved`;
  document.title = title;
  find('title').textContent = title;
  const setting = {
    cell: experiment.cell, task, seed: experiment.seed, mode: experiment.mode, search: experiment.search,
    stretch: experiment.stretch, machine: experiment.machine, handoverctl: versions.handoverctl,
    handoverd: versions.handoverd,
  };
  for (const [name, value] of Object.entries(setting)) {
    const pair = element('div');
    pair.append(element('dt', name), element('dd', String(value)));
    find('setting').append(pair);
  }
}

function means({experiment, paper}) {
  const {summary} = experiment;
  const rows = [
    ['planning time [s]', paper?.planning_time_s, summary.planning_time_s?.mean, seconds],
    ['giver’s grasps |G_g|', paper?.grasps_giver, summary.grasps_giver_mean, number],
    ['receiver’s grasps |G_r|', paper?.grasps_receiver, summary.grasps_receiver_mean, number],
    ['handover poses', paper?.handover_poses, summary.handover_poses_mean, number],
  ];
  table(find('means'), paper ? ['means', 'paper', 'ours'] : ['means', 'ours'], rows.map(
      ([what, theirs, ours, text]) => paper ? [what, number(theirs), text(ours)] : [what, text(ours)]), 1);
  find('paper').textContent = paper ?
      `Paper: Table ${paper.table}, 100 runs, all solved; its counts are those of --search paper --mode all.` :
      'The paper has no such scene.';
  const spreads = [['to the outcome', summary.planning_time_s], ['to the first plan', summary.first_plan_s]];
  table(find('spreads'), ['seconds', 'mean', 'median', 'p95', 'max'], spreads.filter(([, spread]) => spread).map(
      ([what, spread]) => [what, ...['mean', 'median', 'p95', 'max'].map((key) => seconds(spread[key]))]), 1);
  find('redrawn').textContent = summary.redrawn === 0 ? 'No start scene touched, so no run was drawn again.' :
      `Drawn again, as the start touches: ${summary.touched.map(({pair, count}) => `${pair.join(' – ')} (${count} ×)`).join(', ')}.`;
}

// By reason, most frequent first.
function failures({experiment, more}) {
  const reasons = new Map();
  experiment.records.forEach((record, i) => {
    if (record.outcome === 'done') return;
    const reason = record.reason ?? record.outcome;
    if (!reasons.has(reason)) reasons.set(reason, []);
    reasons.get(reason).push([record, more[i].command]);
  });
  const failed = experiment.records.length - experiment.summary.solved;
  find('failures-text').textContent = failed === 0 ? 'Every run was solved.' :
      `${failed} of ${experiment.records.length}. A command repeats its run with a daemon that serves the cell.`;
  if (failed === 0) return;
  table(find('failures'), ['reason', 'run', 'explanation and command'], [], 3);
  const body = find('failures').tBodies[0];
  for (const [reason, runs] of [...reasons].sort((a, b) => b[1].length - a[1].length)) {
    runs.forEach(([record, command], i) => {
      const row = body.insertRow();
      if (i === 0) {
        const cell = element('th', `${reason} (${runs.length} ×)`);
        cell.rowSpan = runs.length;
        row.append(cell);
      }
      const text = element('td', record.explanation ?? '');
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
