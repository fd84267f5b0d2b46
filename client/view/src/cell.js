// SPDX-License-Identifier: Apache-2.0
// The cell as three.js objects: robots by urdf-loader, everything else from the plan file. z is up.
import * as THREE from 'three';
import {ColladaLoader} from 'three/addons/loaders/ColladaLoader.js';
import {OBJLoader} from 'three/addons/loaders/OBJLoader.js';
import {STLLoader} from 'three/addons/loaders/STLLoader.js';
import URDFLoader from 'urdf-loader';

const COLOURS = {giver: 0xd9985f, receiver: 0x7fa6cf, other: 0xb8bec6, hand: 0x4c5561, object: 0x3fa34d, carried: 0x8d949c};
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

export class Cell {
  /** @param data {plan, files, meshes}: the plan file, texts by path, and per URDF its mesh names' paths. */
  constructor(data) {
    this.plan = data.plan.plan;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xeef1f5);
    this.meshes = new Meshes(data.files);
    this.robots = new Map();
    this.objects = new Map();
    this.markers = {handover: new THREE.Group(), grasps: new THREE.Group(), goal: new THREE.Group(), trace: new THREE.Group()};
    this.addLights();
    for (const robot of this.plan.robots) this.addRobot(robot, data);
    for (const object of this.plan.objects) this.addObject(object);
    this.addMarkers();
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

  addRobot(entry, data) {
    const loader = new URDFLoader();
    loader.parseVisual = true;
    loader.parseCollision = true;
    loader.workingPath = '';
    loader.packages = (name) => `package://${name}`;
    loader.loadMeshCb = (name, manager, unused, done) => {
      try {
        done(this.meshes.load(data.meshes[entry.urdf][name]));
      } catch (error) {
        done(null, error);
      }
    };
    const robot = loader.parse(data.files[entry.urdf].text);
    for (const link of Object.values(robot.links)) {  // shapes stand in where a link shows nothing else
      const visible = link.children.some((child) => child.isURDFVisual);
      for (const child of link.children) if (child.isURDFCollider) child.visible = !visible;
    }
    const role = entry.name === this.plan.giver ? 'giver' : entry.name === this.plan.receiver ? 'receiver' : 'other';
    dress(robot, material(COLOURS[role]));
    for (const link of [this.plan.giver_tool_link, this.plan.receiver_tool_link]) {
      if (robot.links[link]) this.darkenHand(robot, robot.links[link]);
    }
    for (const joint of Object.values(robot.joints)) joint.ignoreLimits = true;
    const base = new THREE.Group().add(robot);
    place(base, matrixOf(entry.X_WB));
    this.scene.add(base);
    this.robots.set(entry.name, robot);
  }

  /** The chosen hand, palm and fingers, stands out: all that hangs on the nearest link with more than one joint. */
  darkenHand(robot, tool) {
    let link = tool;
    while (link && link !== robot && !(link.isURDFLink && link.children.filter((c) => c.isURDFJoint && c.jointType !== 'fixed').length > 1)) {
      link = link.parent;
    }
    if (link && link !== robot && link.children.some((c) => c.isURDFJoint)) dress(link, material(COLOURS.hand));
  }

  addObject(entry) {
    const group = new THREE.Group();
    const colour = entry.name === this.plan.object ? COLOURS.object :
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

  ghost(pose, colour) {
    const entry = this.plan.objects.find((object) => object.name === this.plan.object);
    const group = new THREE.Group();
    group.add(dress(geometryOf(entry.geometry, this.meshes), material(colour, {transparent: true, opacity: 0.25, depthWrite: false})));
    group.traverse((child) => { child.castShadow = false; });
    place(group, matrixOf(pose));
    return group;
  }

  addMarkers() {
    const {plan, markers} = this;
    const handover = axes(0.12);
    place(handover, matrixOf(plan.X_WO_handover));
    markers.handover.add(this.ghost(plan.X_WO_handover, 0xd0021b), handover);
    markers.goal.add(this.ghost(plan.X_WO_start, 0x777777), this.ghost(plan.X_WO_goal, 0x2b7de9));
    for (const X_OT of [plan.X_OT_giver, plan.X_OT_receiver]) {
      const grasp = axes(0.07);
      place(grasp, matrixOf(X_OT));
      markers.grasps.add(grasp);
    }
    this.objects.get(plan.object).add(markers.grasps);
    this.scene.add(markers.handover, markers.goal, markers.trace);
  }

  /** A line through the object's origin from start to goal. */
  setTrace(points) {
    const geometry = new THREE.BufferGeometry().setFromPoints(points);
    this.markers.trace.add(new THREE.Line(geometry, new THREE.LineBasicMaterial({color: 0x3fa34d})));
  }

  /** Moves everything to a time of the motion. */
  setTime(motion, time) {
    for (const [name, joints] of motion.jointsAt(time)) {
      const robot = this.robots.get(name);
      for (const [joint, position] of joints) {
        if (robot.joints[joint] && !robot.joints[joint].mimicJoint) robot.setJointValue(joint, position);
      }
    }
    this.scene.updateMatrixWorld();
    const hold = motion.holdAt(time);
    const object = this.objects.get(this.plan.object);
    if (hold) {
      const link = this.robots.get(hold.robot).links[hold.link];
      place(object, link.matrixWorld.clone().multiply(matrixOf(hold.X_LO)));
    } else {
      place(object, matrixOf(motion.restAt(time)));
    }
    object.updateMatrixWorld(true);
    return object;
  }
}
