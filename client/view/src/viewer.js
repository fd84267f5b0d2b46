// SPDX-License-Identifier: Apache-2.0
// The page of one plan file: scene, time line, plots, and what ties them together; without a plan, why there is none.
import * as THREE from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

import {Cell, MARKERS, matrixOf} from './cell.js';
import {element, find, swatch, table} from './dom.js';
import {Failure, farthestText} from './failure.js';
import {FailureScene} from './failure_scene.js';
import {armOf, coloursOf, labelOf, titleOf} from './holders.js';
import {durationOf, Motion} from './motion.js';
import {Plot} from './plot.js';
import {LeanCurve, qualityRows} from './quality.js';
import {Timeline} from './timeline.js';
import {armsTried} from './workspaces.js';

THREE.Object3D.DEFAULT_UP.set(0, 0, 1);
const QUANTITIES = ['q', 'qd', 'qdd'];

function fail(error) {
  find('error').textContent = `This plan cannot be shown: ${error.message}`;
  find('error').hidden = false;
  throw error;
}

/** One of the page's plan files: its only one, or of several the one that the address names. */
function chosenFile({file, runs}) {
  if (!runs) return file;
  const chosen = runs.findIndex(({name}) => location.hash === `#${name}`);
  return runs[Math.max(0, chosen)].file;
}

/** A choice of which of several files the page shows. */
function addRunChoice(runs) {
  const choice = find('run');
  for (const {name, file} of runs) choice.add(new Option(`${name.replace('-', ' ')}: ${file.explanation.reason.replaceAll('_', ' ')}`, name));
  const chosen = runs.findIndex(({name}) => location.hash === `#${name}`);
  choice.selectedIndex = Math.max(0, chosen);
  choice.addEventListener('change', () => { location.hash = choice.value; });
  addEventListener('hashchange', () => location.reload());
}

class Viewer {
  constructor(data) {
    const file = chosenFile(data), {scene, plan, explanation} = file;
    Object.assign(this, {file, scene, plan, arms: plan || !explanation ? plan?.holders : armsTried(file)});
    this.motion = new Motion(scene, plan);
    this.cell = new Cell({...data, file}, this.motion, this.arms);
    this.duration = this.motion.duration;
    this.time = 0;
    this.playing = false;
    this.renderer = new THREE.WebGLRenderer({canvas: find('view'), antialias: true, preserveDrawingBuffer: true});
    this.renderer.shadowMap.enabled = true;
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.02, 50);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.wake());
    this.fillPage();
    for (const part of document.querySelectorAll('.planned')) part.toggleAttribute('hidden', !plan);
    for (const part of document.querySelectorAll('.failed')) part.toggleAttribute('hidden', Boolean(plan) || !explanation);
    if (plan) this.showPlan();
    else if (explanation) this.showFailure();
    find('run-choice').hidden = !data.runs;
    if (data.runs) addRunChoice(data.runs);
    this.addCameras();
    this.listen();
    this.setTime(0);
    this.resize();
    this.setCamera('cell');
  }

  showPlan() {
    this.plot = new Plot(find('plot'), find('legend'));
    this.timeline = new Timeline(find('timeline'), this.plan, this.duration, (time) => this.setTime(time));
    const points = [], leans = [], steps = 400;
    for (let i = 0; i <= steps; ++i) {
      const {matrix} = this.cell.setTime(this.duration * i / steps);
      points.push(new THREE.Vector3().setFromMatrixPosition(matrix));
      leans.push(this.leanOf(matrix));
    }
    this.cell.setTrace(points);
    this.showQuality(leans);
    const colours = coloursOf(this.plan.holders);
    this.plan.holders.forEach((holder, k) => {
      const {take, give} = holder.dexterity, item = element('li');
      item.append(swatch(colours[k].strong), armOf(holder), element('br'),
                  element('span', `${holder.gripper}; dexterity ${take.toFixed(4)} taking, ${give.toFixed(4)} giving`));
      find('holders').append(item);
    });
  }

  /** Angle of the object's axis to the vertical [deg]. */
  leanOf(matrix) {
    const axis = new THREE.Vector3(...(this.scene.upright?.axis ?? [0, 0, 1])).transformDirection(matrix);
    return THREE.MathUtils.radToDeg(axis.angleTo(new THREE.Vector3(0, 0, 1)));
  }

  showQuality(leans) {
    const {quality} = this.file, {start, goal} = this.scene;
    find('quality-part').toggleAttribute('hidden', !quality);
    if (quality) table(find('quality'), [], qualityRows(quality, this.plan), 1);
    const ends = Math.max(...[start.X_WO, goal.X_WO].map((pose) => this.leanOf(matrixOf(pose))));
    find('lean-name').textContent = `The ${this.scene.object}'s lean`;
    this.lean = new LeanCurve(find('lean'), leans, ends, this.duration);
  }

  showFailure() {
    const {explanation: {farthest}} = this.file;
    this.cell.setTime(0);
    this.failure = new FailureScene(this.cell, this.file);
    new Failure(this.file, this.failure, () => this.wake());
    for (const [part, name] of [['farthest', 'farthest'], ['workspaces', 'workspaces'], ['fix-shown', 'fix']]) {
      find(part).hidden = this.cell.markers[name].children.length === 0;
    }
    find('farthest').append(farthest ? `: ${farthestText(farthest)}` : '');
  }

  fillPage() {
    const {scene, plan, file} = this;
    document.title = `${scene.cell} ${scene.task}: ${plan ? 'handover plan' : 'no plan'}`;
    find('title').textContent = titleOf(file);
    for (const [name, value] of [['task, seed', `${scene.task}, ${scene.seed}`], ...(plan ? this.planRows() : [])]) {
      find('summary').append(element('dt', name), element('dd', value));
    }
    find('scrub').max = this.duration;
  }

  planRows() {
    const {plan, file: {timing, complete}} = this;
    const rows = [['motion', `${this.duration.toFixed(1)} s, ${plan.stages.length} stages`], ['slack', `${plan.slack_s} s`]];
    if (timing?.total_s !== undefined) rows.push(['planned in', `${(1000 * timing.total_s).toFixed(1)} ms`]);
    if (!complete) rows.push(['search', 'ended by its deadline']);
    return rows;
  }

  /** Name and place of what a camera looks at closely. */
  views() {
    const {scene, plan, file: {explanation}} = this;
    const views = [['start', scene.start.X_WO]], handovers = plan?.handovers ?? [];
    handovers.forEach((pose, i) => views.push([handovers.length > 1 ? `handover ${i + 1}` : 'handover', pose]));
    if (explanation?.farthest && !plan) views.push(['farthest', explanation.farthest.X_WO]);
    return new Map([...views, ['goal', scene.goal.X_WO]].map(([name, {xyz}]) => [name, new THREE.Vector3(...xyz)]));
  }

  addCameras() {
    for (const name of ['cell', ...this.views().keys(), ...(this.plan ? ['object'] : [])]) {
      const button = element('button', name);
      button.addEventListener('click', () => this.setCamera(name));
      find('cameras').append(button);
    }
  }

  /** To the right, looking from the first robot to the last, else from the object's start to its goal. */
  side() {
    const {scene} = this;
    const baseOf = (name) => new THREE.Vector3(...scene.robots.find((robot) => robot.name === name).X_WB.xyz);
    const names = (this.arms?.length ? this.arms : scene.robots.map(({name}) => ({robot: name}))).map(({robot}) => robot);
    const way = baseOf(names.at(-1)).sub(baseOf(names[0])).setZ(0);
    if (way.length() < 0.05) way.set(...scene.goal.X_WO.xyz).sub(new THREE.Vector3(...scene.start.X_WO.xyz)).setZ(0);
    if (way.length() < 0.05) way.set(1, 0, 0);
    return new THREE.Vector3(way.y, -way.x, 0).normalize();
  }

  setCamera(name) {
    const {camera, controls} = this, side = this.side();
    const ahead = new THREE.Vector3(-side.y, side.x, 0);
    if (name === 'cell') {
      this.fitCell(new THREE.Vector3(0, 0, this.failure ? 0.75 : 0.4).addScaledVector(ahead, 0.45).addScaledVector(side, -0.8).normalize());
    } else {
      const at = this.views().get(name) ?? new THREE.Vector3().setFromMatrixPosition(this.cell.objects.get(this.scene.object).matrixWorld);
      controls.target.copy(at);
      camera.position.copy(at).addScaledVector(side, -0.8).addScaledVector(ahead, 0.25).add(new THREE.Vector3(0, 0, 0.7));
    }
    controls.update();
    this.wake();
  }

  /** Sees the whole cell from a direction, as near as that goes. */
  fitCell(back) {
    const {camera, controls, cell: {bounds}} = this;
    if (this.failure) bounds.union(this.failure.bounds);
    bounds.getCenter(controls.target);
    const right = new THREE.Vector3(0, 0, 1).cross(back).normalize(), up = back.clone().cross(right);
    const high = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2)), wide = high * camera.aspect;
    let distance = 0;
    for (let i = 0; i < 8; ++i) {
      const corner = new THREE.Vector3(...['x', 'y', 'z'].map((axis, k) => bounds[i >> k & 1 ? 'max' : 'min'][axis])).sub(controls.target);
      const needed = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / high);
      distance = Math.max(distance, 1.05 * needed + corner.dot(back));
    }
    camera.position.copy(controls.target).addScaledVector(back, distance);
  }

  listen() {
    find('play').addEventListener('click', () => this.togglePlay());
    find('scrub').addEventListener('input', (event) => this.setTime(Number(event.target.value)));
    for (const name of MARKERS) {
      const box = find(`show-${name}`);
      const apply = () => {
        this.cell.markers[name].visible = box.checked;
        this.wake();
      };
      box.addEventListener('change', apply);
      apply();
    }
    for (const quantity of QUANTITIES) {
      find(`plot-${quantity}`).addEventListener('click', () => {
        this.plot.quantity = quantity;
        for (const other of QUANTITIES) find(`plot-${other}`).setAttribute('aria-pressed', other === quantity);
        this.setTime(this.time);
      });
    }
    document.addEventListener('keydown', (event) => this.press(event));
    new ResizeObserver(() => this.resize()).observe(find('scene'));
  }

  press(event) {
    if (!this.plan || event.target.matches('select, [type=range]')) return;
    if (event.key === ' ' && !event.target.matches('button, input')) this.togglePlay();
    else if (event.key === 'ArrowLeft') this.setTime(this.time - 0.1);
    else if (event.key === 'ArrowRight') this.setTime(this.time + 0.1);
    else if (event.key === 'Home') this.setTime(0);
    else if (event.key === 'End') this.setTime(this.duration);
    else return;
    event.preventDefault();
  }

  resize() {
    const {clientWidth, clientHeight} = find('scene');
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.wake();
  }

  togglePlay() {
    this.playing = !this.playing;
    if (this.playing && this.time >= this.duration) this.setTime(0);
    find('play').textContent = this.playing ? '⏸' : '▶';
    find('play').setAttribute('aria-label', this.playing ? 'Pause' : 'Play');
    this.last_frame = undefined;
    this.wake();
  }

  setTime(time) {
    this.time = Math.min(this.duration, Math.max(0, time));
    this.cell.setTime(this.time);
    if (this.plan) this.showTime();
    this.wake();
  }

  showTime() {
    const {plan, motion, time} = this;
    const running = motion.runningAt(time), stage = running.at(-1) ?? motion.begunAt(time);
    this.timeline.setTime(time, running);
    this.lean.setTime(time);
    find('scrub').value = time;
    find('clock').textContent = `${time.toFixed(2)} / ${this.duration.toFixed(2)} s`;
    find('stage-name').textContent = running.length > 0 ? running.map((entry) => labelOf(plan, entry)).join(' + ') : 'all stand still';
    const holders = motion.holdersAt(time).map((holder) => armOf(plan.holders[holder]));
    const which = running.length === 1 ? '' : `${labelOf(plan, stage)}: `;
    find('stage-text').textContent = `${which}${stage.joints.length} joints, ${durationOf(stage).toFixed(2)} s; ` +
        (holders.length ? `${holders.join(' and ')} holding the ${this.scene.object}` : `nobody holds the ${this.scene.object}`);
    this.plot.setStage(stage, this.unitOf(stage));
    this.plot.draw(time - stage.start);
  }

  unitOf(stage) {
    const {joints} = this.cell.robots.get(stage.robot);
    const units = stage.joints.map((name) => joints[name].jointType === 'prismatic' ? 'm' : 'rad');
    return [...new Set(units)].join(', ');
  }

  /** Draws once more soon; keeps drawing only while playing. */
  wake() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame((now) => {
      this.pending = false;
      if (this.playing) {
        const passed = this.last_frame === undefined ? 0 : (now - this.last_frame) / 1000;
        this.last_frame = now;
        this.setTime(this.time + passed * Number(find('speed').value));
        if (this.time >= this.duration) this.togglePlay();
      }
      this.renderer.render(this.cell.scene, this.camera);
    });
  }

  /** World position of a link's frame, for whoever drives the page. */
  linkPosition(robot, link) {
    return new THREE.Vector3().setFromMatrixPosition(this.cell.robots.get(robot).links[link].matrixWorld).toArray();
  }

  /** World position of the planned object's origin. */
  objectPosition() {
    return new THREE.Vector3().setFromMatrixPosition(this.cell.objects.get(this.scene.object).matrixWorld).toArray();
  }
}

try {
  window.handoverViewer = new Viewer(JSON.parse(find('data').textContent));
} catch (error) {
  fail(error);
}
