// SPDX-License-Identifier: Apache-2.0
// What a failure adds to the cell: where the search came farthest, the bodies that collide, the workspaces, the fix.
import * as THREE from 'three';

import {movedBases} from './base_move.js';
import {matrixOf, place} from './cell.js';
import {ghostMaterial, ghostOf, handOf, label} from './ghosts.js';
import {armOf, coloursOf} from './holders.js';
import {armsTried, BOTH, workspacesOf} from './workspaces.js';

const COLOURS = {object: '#3fa34d', touching: '#e02020', fix: '#8a3ffc', ink: '#1c2430'};

export class FailureScene {
  /** @param cell at its start. */
  constructor(cell, file) {
    Object.assign(this, {cell, file, description: file.scene, explanation: file.explanation});
    this.entries = [];  // {colour, text} of what is drawn
    this.hands = new Set();  // names of the arms whose hands are
    this.ghosts = new Map();  // meshes by body, of what is drawn elsewhere than it stands
    const arms = armsTried(file), colours = coloursOf(arms);
    this.colours = new Map(arms.map((arm, k) => [armOf(arm), colours[k].strong]));
    this.addObject();
    for (const tool of this.explanation.farthest?.tools ?? []) this.addTool(tool);
    const reach = this.addWorkspaces();
    this.explainArms(reach);
    this.addFix();
    this.addNames();
  }

  /** Where the object is in what failed; undefined: where it stands. */
  get tried() {
    const {reason, farthest} = this.explanation;
    if (farthest) return farthest.X_WO;
    return reason.startsWith('goal') || reason === 'no_grasp_at_goal' ? this.description.goal.X_WO : undefined;
  }

  /** Where `tried` is, for people. */
  get where() {
    const near = ({xyz}) => Math.hypot(...xyz.map((v, i) => v - this.tried.xyz[i])) < 1e-4;
    if (near(this.description.goal.X_WO)) return 'at its goal';
    return near(this.description.start.X_WO) ? 'at its start' : 'where the search came farthest';
  }

  remember(group, robot) {
    group.traverse((mesh) => {
      if (!mesh.isMesh) return;
      const body = robot ? `${robot}/${mesh.userData.body}` : this.description.object;
      this.ghosts.set(body, [...this.ghosts.get(body) ?? [], mesh]);
    });
  }

  addObject() {
    if (!this.tried || this.where === 'at its start') return;
    const {object} = this.description, group = this.cell.ghost(this.tried, COLOURS.object, 0.75);
    this.remember(group);
    this.cell.markers.farthest.add(group);
    this.entries.push({colour: COLOURS.object, text: `${object}: solid as it starts, see-through ${this.where}`});
  }

  /** The hand of an arm as it would be there; a frame alone where its tool's link is not known. */
  addTool({robot, arm, X_WT}) {
    const group = new THREE.Group().add(this.cell.axes(0.1)), {farthest} = this.cell.markers;
    const name = this.file.funnel.workspaces?.slices.find((slice) => armOf(slice) === armOf({robot, arm}))?.tool_link;
    const tool = this.cell.robots.get(robot)?.links[name];
    if (tool) {
      const colour = this.colours.get(armOf({robot, arm})) ?? COLOURS.ink;
      const carried = (part) => [...this.cell.objects.values()].includes(part);
      const hand = ghostOf(handOf(tool), tool, ghostMaterial(colour, 0.6), carried);
      this.remember(hand, robot);
      group.add(hand);
      this.hands.add(armOf({robot, arm}));
    }
    place(group, matrixOf(X_WT));
    farthest.add(group);
  }

  addWorkspaces() {
    const drawn = workspacesOf(this.file);
    if (!drawn) return undefined;
    this.cell.markers.workspaces.add(drawn.group);
    this.slice = `${drawn.z.toFixed(2)} m`;
    return drawn;
  }

  explainArms(reach) {
    for (const [name, colour] of this.colours) {
      const parts = [this.hands.has(name) ? 'its hand where the search came farthest' : '', reach?.texts.get(name) ?? ''].filter(Boolean);
      if (parts.length > 0) this.entries.push({colour, text: `${name}: ${parts.join(', and ')}`});
    }
    if (reach?.both) this.entries.push({colour: BOTH, text: reach.both});
  }

  addFix() {
    for (const {robot, matrix} of movedBases(this.explanation.nearest_fix, this.description.robots)) {
      const base = this.cell.robots.get(robot).parent, group = ghostOf(base, base, ghostMaterial(COLOURS.fix, 0.28));
      place(group, matrix);
      const from = new THREE.Vector3().setFromMatrixPosition(base.matrixWorld), to = new THREE.Vector3().setFromMatrixPosition(matrix);
      const way = to.clone().sub(from), {fix} = this.cell.markers;
      fix.add(group);
      const floor = this.cell.bounds.min.z + 0.01;
      if (way.length() > 0.02) fix.add(new THREE.ArrowHelper(way.clone().normalize(), from.setZ(floor), way.length(), COLOURS.fix, 0.12, 0.08));
      const top = new THREE.Box3().setFromObject(this.cell.robots.get(robot)).max.z;
      fix.add(label(`${robot} here: would work`, COLOURS.fix, to.setZ(top), 0.3));
      this.entries.push({colour: COLOURS.fix, text: `${robot} where it would work`});
    }
  }

  addNames() {
    const {cell, description} = this, {names} = cell.markers;
    const at = ({xyz}) => new THREE.Vector3(...xyz);
    for (const [name, robot] of cell.robots) {
      const box = new THREE.Box3().setFromObject(robot), middle = box.getCenter(new THREE.Vector3());
      names.add(label(name, COLOURS.ink, middle.setZ(box.max.z), 0.06));
    }
    names.add(label(`${description.object}, start`, COLOURS.ink, at(description.start.X_WO), 0.25));
    names.add(label(`${description.object}, goal`, COLOURS.ink, at(description.goal.X_WO), 0.25));
    if (this.tried && this.where.startsWith('where')) names.add(label('came this far', COLOURS.touching, at(this.tried), 0.35));
  }

  /** Shows bodies in red, where they are in what failed, and no other. */
  highlight(names) {
    this.cell.highlight(names, this.ghosts);
  }

  /** Where a body of a cause is drawn, for people; undefined: as it stands at the start. */
  placeOf(body) {
    if (!this.ghosts.has(body)) return undefined;
    return body === this.description.object ? this.where : 'where the search came farthest';
  }

  /** Corners of what a camera that shows the whole failure has to see besides the cell. */
  get bounds() {
    const box = new THREE.Box3();
    for (const name of ['farthest', 'fix']) box.union(new THREE.Box3().setFromObject(this.cell.markers[name]));
    return box;
  }
}
