// SPDX-License-Identifier: Apache-2.0
// How far a search came: a bar for each of its filters, with what came in and what was left.
import {element, find} from './dom.js';

const UNFIT = new Set(['start_in_collision', 'goal_in_collision', 'start_unsupported', 'goal_unsupported']);
/** The filter that a failure's reason is about. */
const ENDED_AT = {
  start_unreachable: 'arms_start', goal_unreachable: 'arms_goal', no_grasp: 'arms_start', no_grasp_at_start: 'grasps_start',
  no_grasp_at_goal: 'grasps_goal', no_common_workspace: 'points', no_handover_pose: 'poses', no_path: 'motions',
};

const sum = (list, value) => list.reduce((total, entry) => total + value(entry), 0);

/** Of the arms looked at for a place of the chain: how many there are, and how many can. */
function armsOf(scores) { return {tested: scores.length, kept: scores.filter(({rejected}) => !rejected).length}; }

function graspsOf(pruned, place) {
  const there = pruned.filter((entry) => entry.place === place);
  return there.length === 0 ? undefined : {tested: sum(there, ({tested}) => tested), kept: sum(there, ({kept}) => kept)};
}

/** Points that both arms reach: what a pair of arms has of them is said again by each of its events. */
function pointsOf(candidates) {
  const pairs = new Map(candidates.map(({handover, giver, receiver, lattice_points}) => [`${handover} ${giver} ${receiver}`, lattice_points]));
  return {kept: sum([...pairs.values()], (points) => points)};
}

/** {key, name, tested, kept} of each filter; without numbers where the search did not come so far. */
export function filtersOf({funnel, explanation}) {
  const {arm_selected = [], grasps_pruned = [], handover_candidates = []} = funnel;
  const reason = explanation.reason, scores = arm_selected.at(-1)?.scores ?? [];
  const last = Math.max(0, ...scores.map(({holder}) => holder));
  const at = (holder) => scores.length > 0 ? armsOf(scores.filter((score) => score.holder === holder)) : undefined;
  const tried = handover_candidates.length > 0, handed = tried || reason === 'no_common_workspace';
  const tuples = sum(handover_candidates, (entry) => entry.tuples);
  const motions = sum(explanation.causes.filter(({stage}) => stage), ({count}) => count);
  const filters = [
    {key: 'scene', name: 'start and goal free', tested: 2, kept: UNFIT.has(reason) ? 1 : 2},
    {key: 'arms_start', name: 'arms for the start', ...at(0)},
    {key: 'arms_goal', name: 'arms for the goal', ...at(last)},
    {key: 'grasps_start', name: 'grasps at the start', ...graspsOf(grasps_pruned, 'start')},
    {key: 'grasps_goal', name: 'grasps at the goal', ...graspsOf(grasps_pruned, 'goal')},
    {key: 'points', name: 'points both reach', ...(handed ? pointsOf(handover_candidates) : {})},
    {
      key: 'poses', name: 'handover poses',
      ...(tried ? {tested: sum(handover_candidates, (entry) => entry.poses_tried), kept: sum(handover_candidates, (entry) => entry.poses)} : {}),
    },
    {key: 'tuples', name: 'poses with both grasps', ...(tried ? {kept: tuples} : {})},
    {key: 'motions', name: 'motions', ...(reason === 'no_path' ? {tested: motions, kept: 0} : {})},
  ];
  const ended = UNFIT.has(reason) ? 'scene' : ENDED_AT[reason];
  return filters.map((filter) => ({...filter, ended: filter.key === ended}));
}

/** As long as the share that was left. */
function barOf({tested, kept}) {
  const bar = element('div', '', 'bar'), filled = element('div', '', kept > 0 ? 'filled' : '');
  filled.style.width = `${100 * (kept ?? 0) / (tested || kept || 1)}%`;
  bar.append(filled);
  return bar;
}

function textOf({tested, kept, ended}) {
  if (kept === undefined) return ended ? 'none' : '–';
  return tested === undefined ? String(kept) : `${kept} of ${tested}`;
}

export function drawFunnel(file) {
  const rows = find('funnel').createTBody();
  for (const filter of filtersOf(file)) {
    const row = rows.insertRow(), bar = element('td');
    row.className = filter.ended ? 'ended' : filter.kept === undefined ? 'unreached' : '';
    bar.append(barOf(filter));
    row.append(element('td', filter.name), bar, element('td', textOf(filter), 'number'));
  }
}
