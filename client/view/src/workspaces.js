// SPDX-License-Identifier: Apache-2.0
// Horizontal slices of the arms' reachability maps as shaded cells: an arm's colour where it reaches, the darker the
// better; another colour where two arms that follow each other in the chain both do.
import * as THREE from 'three';

import {armOf, coloursOf} from './holders.js';

export const BOTH = '#1f9d55';
const FAINT = 0.14, STRONG = 0.5;  // opacity of the least and the best entry
const LIFT = 0.002;  // [m] between what lies in one plane

/** The arms of the chain that was tried first; where there was none, those that it could not begin or end with. */
export function armsTried({funnel, explanation}) {
  const selected = (funnel.arm_selected ?? []).at(-1);
  const holders = (funnel.arm_selected ?? []).map(({holders}) => holders).findLast((names) => names.length > 0);
  const named = (name) => ({robot: name.split('/')[0], arm: name.split('/').slice(1).join('/')});
  if (holders) return holders.map(named);
  const last = Math.max(0, ...(selected?.scores ?? []).map(({holder}) => holder));
  const place = explanation.reason.startsWith('goal') ? last : 0;
  return (selected?.scores ?? []).filter(({holder}) => holder === place);
}

/** One slice as cells: [x, y, entry]. */
function cellsOf({first: [x, y], columns, scores}, edge) {
  return scores.map((score, i) => [x + edge * (i % columns), y + edge * Math.floor(i / columns), score]).filter(([, , score]) => score > 0);
}

const keyOf = ([x, y], edge) => `${Math.round(x / edge - 0.5)} ${Math.round(y / edge - 0.5)}`;

function shaded(cells, edge, z, colour) {
  const best = Math.max(...cells.map(([, , score]) => score)), half = edge / 2, {r, g, b} = new THREE.Color(colour);
  const positions = [], colours = [];
  for (const [x, y, score] of cells) {
    const alpha = FAINT + (STRONG - FAINT) * score / best;
    for (const [i, j] of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]) {
      positions.push(x + i * half, y + j * half, z);
      colours.push(r, g, b, alpha);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(positions, 3));
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(colours, 4));
  const material = new THREE.MeshBasicMaterial({vertexColors: true, transparent: true, side: THREE.DoubleSide, depthWrite: false});
  return new THREE.Mesh(geometry, material);
}

/** Lines between the cells and what is none of them. */
function outlined(cells, edge, z, colour) {
  const inside = new Set(cells.map((cell) => keyOf(cell, edge))), half = edge / 2, points = [];
  for (const [x, y] of cells) {
    for (const [i, j] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      if (inside.has(keyOf([x + i * edge, y + j * edge], edge))) continue;
      for (const k of [-1, 1]) points.push(new THREE.Vector3(x + (i + k * j) * half, y + (j + k * i) * half, z));
    }
  }
  return new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({color: colour}));
}

/** Of the arms that were tried those that a failure is about: at the start the first, at the goal the last. */
function concerned(arms, reason) {
  if (/^(start|no_grasp_at_start)/.test(reason)) return [0];
  return /^(goal|no_grasp_at_goal)/.test(reason) ? [arms.length - 1] : [...arms.keys()];
}

/** {group, z, texts, both}: what is drawn, what is to be said of arms by name, and of where two reach, undefined where
 *  that is not asked; undefined without slices to show. */
export function workspacesOf(file) {
  const {workspaces, arm_selected} = file.funnel, {reason} = file.explanation;
  const chained = arm_selected?.some(({holders}) => holders.length > 0);
  const arms = armsTried(file), colours = coloursOf(arms), names = arms.map(armOf);
  const shown = chained ? concerned(arms, reason) : [...arms.keys()];
  const slices = names.map((name, k) => shown.includes(k) ? workspaces?.slices.find((slice) => armOf(slice) === name) : undefined);
  if (!workspaces || slices.every((slice) => !slice)) return undefined;
  const {z, edge} = workspaces, group = new THREE.Group(), texts = new Map();
  const cells = slices.map((slice) => slice ? cellsOf(slice, edge) : []);
  const draw = (these, level, colour) => {
    if (these.length > 0) group.add(shaded(these, edge, z + level * LIFT, colour), outlined(these, edge, z + level * LIFT, colour));
  };
  names.forEach((name, k) => {
    if (!slices[k] || names.indexOf(name) !== k) return;
    draw(cells[k], k, colours[k].strong);
    texts.set(name, cells[k].length > 0 ? 'where it reaches' : 'reaches nowhere at this height');
  });
  if (!chained || shown.length < 2) return {group, z, texts};
  const common = bothReach(cells, edge);
  draw(common, names.length, BOTH);
  return {group, z, texts, both: common.length > 0 ? 'where both reach' : 'where both reach: nowhere at this height'};
}

/** Cells of two arms that follow each other, with the mean of both entries. */
function bothReach(cells, edge) {
  const both = new Map();
  for (let k = 0; k + 1 < cells.length; ++k) {
    const next = new Map(cells[k + 1].map((cell) => [keyOf(cell, edge), cell]));
    for (const cell of cells[k]) {
      const other = next.get(keyOf(cell, edge));
      if (other) both.set(keyOf(cell, edge), [cell[0], cell[1], (cell[2] + other[2]) / 2]);
    }
  }
  return [...both.values()];
}
