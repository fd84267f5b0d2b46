// SPDX-License-Identifier: Apache-2.0
// The page of one plan: scene, time line, plots, and what ties them together.
import * as THREE from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

import {Cell} from './cell.js';
import {durationOf, Motion} from './motion.js';
import {Plot} from './plot.js';
import {Timeline} from './timeline.js';

THREE.Object3D.DEFAULT_UP.set(0, 0, 1);
const find = (id) => document.getElementById(id);

function fail(error) {
  find('error').textContent = `This plan cannot be shown: ${error.message}`;
  find('error').hidden = false;
  throw error;
}

class Viewer {
  constructor(data) {
    this.file = data.plan;
    this.plan = data.plan.plan;
    this.motion = new Motion(this.plan);
    this.cell = new Cell(data);
    this.duration = this.motion.duration;
    this.time = 0;
    this.playing = false;
    this.renderer = new THREE.WebGLRenderer({canvas: find('view'), antialias: true, preserveDrawingBuffer: true});
    this.renderer.shadowMap.enabled = true;
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.02, 50);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.wake());
    this.plot = new Plot(find('plot'), find('legend'));
    this.timeline = new Timeline(find('timeline'), this.plan, this.duration, (time) => this.setTime(time));
    this.traceObject();
    this.fillPage();
    this.addCameras();
    this.listen();
    this.setCamera('cell');
    this.setTime(0);
  }

  traceObject() {
    const points = [], steps = 400;
    for (let i = 0; i <= steps; ++i) {
      const object = this.cell.setTime(this.motion, this.duration * i / steps);
      points.push(new THREE.Vector3().setFromMatrixPosition(object.matrix));
    }
    this.cell.setTrace(points);
  }

  fillPage() {
    const {plan, file} = this;
    document.title = `${plan.cell} ${plan.task}: handover plan`;
    find('title').textContent = `${plan.cell}: ${plan.giver} gives ${plan.object} to ${plan.receiver}`;
    const rows = [
      ['task, seed', `${plan.task}, ${plan.seed}`],
      ['arms', `${plan.giver_arm} to ${plan.receiver_arm}`],
      ['motion', `${this.duration.toFixed(1)} s, ${plan.stages.length} stages`],
      ['dexterity at placing', plan.dexterity.receiver_place.toFixed(4)],
    ];
    if (file.timing && file.timing.total_s !== undefined) rows.push(['planned in', `${(1000 * file.timing.total_s).toFixed(1)} ms`]);
    for (const [name, value] of rows) {
      const term = document.createElement('dt'), text = document.createElement('dd');
      term.textContent = name;
      text.textContent = value;
      find('summary').append(term, text);
    }
    find('scrub').max = this.duration;
  }

  addCameras() {
    for (const name of ['cell', 'start', 'handover', 'goal', 'object']) {
      const button = document.createElement('button');
      button.textContent = name;
      button.dataset.camera = name;
      button.addEventListener('click', () => this.setCamera(name));
      find('cameras').append(button);
    }
  }

  setCamera(name) {
    const {plan, camera, controls} = this;
    const middle = new THREE.Vector3();
    for (const robot of plan.robots) middle.addScaledVector(new THREE.Vector3(...robot.X_WB.xyz), 1 / plan.robots.length);
    const between = new THREE.Vector3(...plan.robots[plan.robots.length - 1].X_WB.xyz).sub(new THREE.Vector3(...plan.robots[0].X_WB.xyz));
    const side = new THREE.Vector3(between.y, -between.x, 0).normalize();  // to the right, looking from giver to receiver
    const views = {start: plan.X_WO_start, handover: plan.X_WO_handover, goal: plan.X_WO_goal};
    if (name === 'cell') {
      controls.target.set(middle.x, middle.y, 0.9);
      camera.position.copy(controls.target).addScaledVector(side, -3.1).add(new THREE.Vector3(1.6, 0, 1.5));
    } else {
      const at = name === 'object' ? new THREE.Vector3().setFromMatrixPosition(this.cell.objects.get(plan.object).matrixWorld)
                                   : new THREE.Vector3(...views[name].xyz);
      controls.target.copy(at);
      camera.position.copy(at).addScaledVector(side, -0.8).add(new THREE.Vector3(0.25, 0, 0.7));
    }
    controls.update();
    this.wake();
  }

  listen() {
    find('play').addEventListener('click', () => this.togglePlay());
    find('scrub').addEventListener('input', (event) => this.setTime(Number(event.target.value)));
    for (const name of ['handover', 'grasps', 'goal', 'trace']) {
      const box = find(`show-${name}`);
      const apply = () => {
        this.cell.markers[name].visible = box.checked;
        this.wake();
      };
      box.addEventListener('change', apply);
      apply();
    }
    for (const quantity of ['q', 'qd']) {
      find(`plot-${quantity}`).addEventListener('click', () => {
        this.plot.quantity = quantity;
        for (const other of ['q', 'qd']) find(`plot-${other}`).setAttribute('aria-pressed', other === quantity);
        this.setTime(this.time);
      });
    }
    document.addEventListener('keydown', (event) => {
      if (event.target.matches('input, select, button')) return;
      if (event.key === ' ') this.togglePlay();
      else if (event.key === 'ArrowLeft') this.setTime(this.time - 0.1);
      else if (event.key === 'ArrowRight') this.setTime(this.time + 0.1);
      else return;
      event.preventDefault();
    });
    new ResizeObserver(() => this.resize()).observe(find('view').parentElement);
  }

  resize() {
    const canvas = this.renderer.domElement;
    const width = canvas.parentElement.clientWidth - document.querySelector('aside').offsetWidth;
    const narrow = getComputedStyle(canvas.parentElement).flexDirection === 'column';
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(narrow ? canvas.parentElement.clientWidth : width,
                          narrow ? canvas.parentElement.clientHeight * 0.6 : canvas.parentElement.clientHeight, false);
    this.camera.aspect = canvas.width / canvas.height;
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
    this.cell.setTime(this.motion, this.time);
    const running = this.motion.runningAt(this.time);
    const stage = running[running.length - 1] ?? this.plan.stages[0];
    this.timeline.setTime(this.time, running);
    find('scrub').value = this.time;
    find('clock').textContent = `${this.time.toFixed(2)} / ${this.duration.toFixed(2)} s`;
    find('stage-name').textContent = running.length > 1 ? running.map((entry) => entry.kind).join(' + ') : stage.kind;
    const holders = stage.holding.filter((hold) => hold.object === this.plan.object).map((hold) => hold.robot);
    find('stage-text').textContent = `${stage.robot}, ${stage.joints.length} joints, ${durationOf(stage).toFixed(2)} s; ` +
        (holders.length ? `${holders.join(' and ')} holding the ${this.plan.object}` : `nobody holds the ${this.plan.object}`);
    this.plot.setStage(stage);
    this.plot.draw(this.time - stage.start);
    this.wake();
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
}

try {
  const data = JSON.parse(find('data').textContent);
  if (!data.plan.plan) throw new Error('the file holds no plan');
  window.handoverViewer = new Viewer(data);
} catch (error) {
  fail(error);
}
