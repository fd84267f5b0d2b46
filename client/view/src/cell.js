// SPDX-License-Identifier: Apache-2.0
// The cell as three.js objects: robots by urdf-loader, everything else from the plan file. z is up.
import * as THREE from 'three';
import {ColladaLoader} from 'three/addons/loaders/ColladaLoader.js';
import {OBJLoader} from 'three/addons/loaders/OBJLoader.js';
import {STLLoader} from 'three/addons/loaders/STLLoader.js';
import URDFLoader from 'urdf-loader';

import {ghostMaterial} from './ghosts.js';
import {armOf, coloursOf} from './holders.js';

const COLOURS = {idle: 0xb8bec6, hand: 0x4c5561, object: 0x3fa34d, carried: 0x8d949c, start: 0x777777, goal: 0x2b7de9,
                 handover: 0xd0021b, touching: 0xe02020};
/** What may be shown beside the cell itself. */
export const MARKERS = ['handover', 'grasps', 'goal', 'trace', 'farthest', 'workspaces', 'fix', 'names'];
const THINGS = [0xe3e4e6, 0xd9cbb2, 0xc3ccd3, 0xcfd3c2, 0xd3c6c3];

function material(colour, options = {}) {
  return new THREE.MeshStandardMaterial({color: colour, roughness: 0.75, metalness: 0.05, flatShading: true, ...options});
}

export function matrixOf(pose) {
  const [w, x, y, z] = pose.quat_wxyz;
  return new THREE.Matrix4().compose(new THREE.Vector3(...pose.xyz), new THREE.Quaternion(x, y, z, w),
                                     new THREE.Vector3(1, 1, 1));
}

export function place(object, matrix) {
  object.matrixAutoUpdate = false;
  object.matrix.copy(matrix);
  object.matrixWorldNeedsUpdate = true;
}

function placed(object, pose) {
  place(object, matrixOf(pose));
  return object;
}

function bytesOf(base64) { return Uint8Array.from(atob(base64), (c) => c.charCodeAt(0)); }

/** Meshes of the page's own files by path. */
class Meshes {
  constructor(files) { this.files = files; }

  load(path) {
    const file = this.files[path];
    if (!file) throw new Error(`the page has no file ${path}`);
    const kind = path.toLowerCase().split('.').pop();
    if (kind === 'obj') return new OBJLoader().parse(file.text);
    if (kind === 'stl') return new THREE.Mesh(new STLLoader().parse(bytesOf(file.base64).buffer));
    if (kind === 'dae') return new ColladaLoader().parse(file.text, '').scene;
    throw new Error(`${path}: unknown kind of mesh`);
  }
}

function dress(object, mesh_material) {
  object.traverse((child) => {
    if (!child.isMesh) return;
    child.material = mesh_material;
    child.castShadow = true;
    child.receiveShadow = true;
    if (!child.geometry.attributes.normal) child.geometry.computeVertexNormals();
  });
  return object;
}

function geometryOf(geometry, meshes) {
  switch (geometry.type) {
    case 'box': return new THREE.Mesh(new THREE.BoxGeometry(...geometry.size));
    case 'sphere': return new THREE.Mesh(new THREE.SphereGeometry(geometry.radius, 32, 16));
    case 'cylinder': {
      const shape = new THREE.CylinderGeometry(geometry.radius, geometry.radius, geometry.length, 40);
      return new THREE.Mesh(shape.rotateX(Math.PI / 2));
    }
    case 'mesh': {
      const group = new THREE.Group().add(meshes.load(geometry.path));
      group.scale.set(...geometry.scale);
      return group;
    }
    case 'compound': {
      const group = new THREE.Group();
      for (const part of geometry.parts) {
        const shape = new THREE.Group().add(geometryOf(part.geometry, meshes));
        place(shape, matrixOf(part.X_OS));
        group.add(shape);
      }
      return group;
    }
    default: throw new Error(`unknown geometry ${geometry.type}`);
  }
}

function axes(size) {
  const marker = new THREE.AxesHelper(size);
  marker.material.depthTest = false;
  marker.renderOrder = 1;
  return marker;
}

/** The diagonal of a box about meshes. */
function sizeOf(meshes) {
  const box = new THREE.Box3();
  for (const mesh of meshes) box.expandByObject(mesh);
  return box.getSize(new THREE.Vector3()).length();
}

export class Cell {
  /** @param data {file, files, meshes}: the plan file, texts by path, and per URDF its mesh names' paths.
   *  @param arms {robot, arm} that have colours; left out: the plan's holders. */
  constructor({file, files, meshes}, motion, arms) {
    Object.assign(this, {motion, plan: file.plan, description: file.scene});
    this.holders = this.plan?.holders ?? [];
    this.arms = arms ?? this.holders;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xeef1f5);
    this.meshes = new Meshes(files);
    this.robots = new Map();
    this.objects = new Map();
    this.markers = {};
    for (const name of MARKERS) this.markers[name] = new THREE.Group();
    this.addLights();
    for (const robot of this.description.robots) this.addRobot(robot, files[robot.urdf].text, meshes[robot.urdf]);
    this.colourArms();
    for (const object of this.description.objects) this.addObject(object);
    this.addMarkers();
    this.setJoints(Number.isFinite(motion.put_down) ? motion.put_down : 0);
    this.X_WO_end = this.heldBy(this.holders.length - 1);
  }

  addLights() {
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 1.6));
    const sun = new THREE.DirectionalLight(0xffffff, 2.2);
    sun.position.set(2.5, -2, 5);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.bias = -0.0004;
    Object.assign(sun.shadow.camera, {left: -3, right: 3, top: 3, bottom: -3, near: 0.5, far: 12});
    this.scene.add(sun);
  }

  addRobot(entry, urdf, meshes) {
    const loader = new URDFLoader();
    loader.parseVisual = true;
    loader.parseCollision = true;
    loader.workingPath = '';
    loader.packages = (name) => `package://${name}`;
    loader.loadMeshCb = (name, manager, unused, done) => {
      if (meshes[name] === undefined) {
        done(null);  // a picture that is not there; see below
        return;
      }
      try {
        done(this.meshes.load(meshes[name]));
      } catch (error) {
        done(null, error);
      }
    };
    const robot = loader.parse(urdf);
    for (const link of Object.values(robot.links)) {  // shapes stand in where a link shows nothing else
      const pictures = link.children.filter((child) => child.isURDFVisual && child.getObjectByProperty('isMesh', true));
      for (const child of link.children) if (child.isURDFCollider) child.visible = pictures.length === 0;
    }
    dress(robot, material(COLOURS.idle));
    for (const joint of Object.values(robot.joints)) joint.ignoreLimits = true;
    this.scene.add(placed(new THREE.Group().add(robot), entry.X_WB));
    this.robots.set(entry.name, robot);
  }

  /** A robot has the colour of the arm that is in the chain; with several of them, each arm has its own. Hands stand out. */
  colourArms() {
    const colours = coloursOf(this.arms);
    this.arms.forEach((holder, k) => {
      const robot = this.robots.get(holder.robot);
      const alone = this.arms.every((other) => other.robot !== holder.robot || armOf(other) === armOf(holder));
      if (alone || this.plan) dress(alone ? robot : this.topOf(k), material(new THREE.Color(colours[k].light)));
    });
    for (const {robot, hand} of this.holders) {
      for (const link of [hand.palm, hand.cup_link, ...(hand.fingers ?? [])]) {
        if (link) dress(this.robots.get(robot).links[link], material(COLOURS.hand));
      }
    }
  }

  /** The joint above all that a holder's arm moves: the first of those that carry the object. */
  topOf(holder) {
    const robot = this.robots.get(this.holders[holder].robot);
    const joints = this.motion.stageOf(holder, 'carry').joints.map((name) => robot.joints[name]);
    return joints.find((joint) => joints.every((other) => other === joint || !other.getObjectById(joint.id)));
  }

  addObject(entry) {
    const group = new THREE.Group();
    const colour = entry.name === this.description.object ? COLOURS.object :
        entry.attached_to ? COLOURS.carried : THINGS[this.objects.size % THINGS.length];
    group.add(dress(geometryOf(entry.geometry, this.meshes), material(colour)));
    place(group, matrixOf(entry.X_WO));
    if (entry.attached_to) {
      place(group, matrixOf(entry.attached_to.X_LO));
      this.robots.get(entry.attached_to.robot).links[entry.attached_to.link].add(group);
    } else {
      this.scene.add(group);
    }
    this.objects.set(entry.name, group);
  }

  /** The object that is brought, at another pose. */
  ghost(pose, colour, opacity = 0.25) {
    const entry = this.description.objects.find((object) => object.name === this.description.object);
    const group = new THREE.Group();
    group.add(dress(geometryOf(entry.geometry, this.meshes), ghostMaterial(colour, opacity)));
    group.traverse((child) => { child.castShadow = false; });
    return placed(group, pose);
  }

  axes(size) { return axes(size); }

  addMarkers() {
    const {description, markers} = this;
    markers.goal.add(this.ghost(description.start.X_WO, COLOURS.start), this.ghost(description.goal.X_WO, COLOURS.goal));
    for (const pose of this.plan?.handovers ?? []) markers.handover.add(this.ghost(pose, COLOURS.handover), placed(axes(0.12), pose));
    for (const {X_OT} of this.holders) markers.grasps.add(placed(axes(0.07), X_OT));
    this.objects.get(description.object).add(markers.grasps);
    for (const [name, group] of Object.entries(markers)) if (name !== 'grasps') this.scene.add(group);
  }

  /** A line through the object's origin from start to goal. */
  setTrace(points) {
    const geometry = new THREE.BufferGeometry().setFromPoints(points);
    this.markers.trace.add(new THREE.Line(geometry, new THREE.LineBasicMaterial({color: COLOURS.object})));
  }

  /** Shows bodies, `robot/link` or objects, in red, and no other. @param ghosts meshes by body, of those that are shown
   *  elsewhere: these are red instead. */
  highlight(names, ghosts = new Map()) {
    for (const {mesh, material: before} of this.highlighted ?? []) mesh.material = before;
    this.highlighted = [];
    const bodies = names.map((name) => ghosts.get(name) ?? this.meshesOf(name));
    const sizes = bodies.map(sizeOf), largest = Math.max(...sizes);
    bodies.forEach((meshes, i) => {
      // One may be inside the other.
      const red = bodies.length > 1 && sizes[i] === largest ? ghostMaterial(COLOURS.touching, 0.5) : material(COLOURS.touching);
      for (const mesh of meshes) {
        this.highlighted.push({mesh, material: mesh.material});
        mesh.material = red;
      }
    });
  }

  /** Of one body, `robot/link` or an object, where it stands. */
  meshesOf(name) {
    const [robot, link] = name.split('/'), found = [], objects = [...this.objects.values()];
    const gather = (part, body) => {
      if (part.isURDFJoint || part !== body && objects.includes(part)) return;  // that is another body
      if (part.isMesh) found.push(part);
      part.children.forEach((child) => gather(child, body));
    };
    const body = this.objects.get(name) ?? this.robots.get(robot)?.links[link];
    if (body) gather(body, body);
    return found;
  }

  setJoints(time) {
    for (const [name, joints] of this.motion.jointsAt(time)) {
      const robot = this.robots.get(name);
      for (const [joint, position] of joints) {
        if (robot.joints[joint] && !robot.joints[joint].mimicJoint) robot.setJointValue(joint, position);
      }
    }
    this.scene.updateMatrixWorld();
  }

  /** X_WO as a holder's tool has it; undefined without one. */
  heldBy(holder) {
    if (!this.holders[holder]) return undefined;
    const {robot, tool_link, X_OT} = this.holders[holder];
    return this.robots.get(robot).links[tool_link].matrixWorld.clone().multiply(matrixOf(X_OT).invert());
  }

  /** Moves everything to a time of the motion; returns the object. */
  setTime(time) {
    this.setJoints(time);
    const [holder] = this.motion.holdersAt(time);
    const X_WO = holder !== undefined ? this.heldBy(holder) :
        time >= this.motion.put_down  ? this.X_WO_end : matrixOf(this.description.start.X_WO);
    const object = this.objects.get(this.description.object);
    place(object, X_WO);
    object.updateMatrixWorld(true);
    return object;
  }

  /** What a camera that shows the whole cell has to see: the robots, and the object wherever it comes. */
  get bounds() {
    const box = new THREE.Box3();
    for (const robot of this.robots.values()) box.expandByObject(robot);
    for (const {X_WO} of [this.description.start, this.description.goal]) box.expandByPoint(new THREE.Vector3(...X_WO.xyz));
    return box;
  }
}
