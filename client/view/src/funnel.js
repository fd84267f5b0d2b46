// SPDX-License-Identifier: Apache-2.0
// How far a search came: a bar for each of its filters, with what came in and what was left.
import {element, find} from './dom.js';

/** The rows of the explanation's filters, where they are not named alike. */
const ROW_OF = {start: 'scene', goal: 'scene', chains: 'arms_at_goal', grasps_at_both: 'grasps_at_goal', common_workspace: 'points'};
/** Rows of what only a handover has. */
const OF_HANDOVERS = new Set(['points', 'handover_poses', 'tuples']);

const sum = (list, value) => list.reduce((total, entry) => total + value(entry), 0);

/** Of the arms looked at for a place of the chain: how many there are, and how many can. */
function armsOf(scores) { return scores.length === 0 ? undefined : {tested: scores.length, kept: scores.filter(({rejected}) => !rejected).length}; }

/** The scores at the start and those at the goal: the goal's follow, and begin anew with the first arm. */
function scoresByPlace(scores) {
  const name = ({robot, arm, holder}) => `${holder} ${robot}/${arm}`, seen = new Set();
  const goal = scores.findIndex((score) => {
    const again = score.holder > scores[0].holder || seen.has(name(score));
    seen.add(name(score));
    return again;
  });
  return goal < 0 ? [scores, []] : [scores.slice(0, goal), scores.slice(goal)];
}

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
  const [at_start, at_goal] = scoresByPlace(scores), alone = scores.length > 0 && scores.every(({holder}) => holder === 0);
  const tried = handover_candidates.length > 0, handed = tried || reason === 'no_common_workspace';
  const tuples = sum(handover_candidates, (entry) => entry.tuples);
  const motions = sum(explanation.causes.filter(({stage}) => stage), ({count}) => count);
  const ended = ROW_OF[explanation.filter] ?? explanation.filter;
  const filters = [
    {key: 'scene', name: 'start and goal free', tested: 2, kept: ended === 'scene' ? 1 : 2},
    {key: 'arms_at_start', name: 'arms for the start', ...armsOf(at_start)},
    {key: 'arms_at_goal', name: 'arms for the goal', ...armsOf(at_goal)},
    {key: 'grasps_at_start', name: 'grasps at the start', ...graspsOf(grasps_pruned, 'start')},
    {key: 'grasps_at_goal', name: 'grasps at the goal', ...graspsOf(grasps_pruned, 'goal')},
    {key: 'points', name: 'points both reach', ...(handed ? pointsOf(handover_candidates) : {})},
    {
      key: 'handover_poses', name: 'handover poses',
      ...(tried ? {tested: sum(handover_candidates, (entry) => entry.poses_tried), kept: sum(handover_candidates, (entry) => entry.poses)} : {}),
    },
    {key: 'tuples', name: 'poses with both grasps', ...(tried ? {kept: tuples} : {})},
    {key: 'motions', name: 'motions', ...(ended === 'motions' ? {tested: motions, kept: 0} : {})},
  ];
  return filters.filter(({key}) => !(alone && OF_HANDOVERS.has(key))).map((filter) => ({...filter, ended: filter.key === ended}));
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
