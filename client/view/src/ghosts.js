// SPDX-License-Identifier: Apache-2.0
// Translucent copies of what stands in the cell, somewhere else.
import * as THREE from 'three';

export function ghostMaterial(colour, opacity = 0.3) {
  return new THREE.MeshStandardMaterial({
    color: colour, roughness: 0.75, metalness: 0.05, flatShading: true, transparent: true, opacity, depthWrite: false,
  });
}

function shown(mesh) {
  for (let object = mesh; object; object = object.parent) if (!object.visible) return false;
  return true;
}

/** Copies of the visible meshes below an object, in a group whose frame is that of `frame` now. @param skip leaves out
 *  what is below such an object. Each copy's userData.body names the link that it is of. */
export function ghostOf(object, frame, material, skip = () => false) {
  const group = new THREE.Group(), X_FW = frame.matrixWorld.clone().invert();
  const copy = (part, body) => {
    if (skip(part)) return;
    const name = part.isURDFLink ? part.urdfName : body;
    if (part.isMesh && shown(part)) {
      const mesh = new THREE.Mesh(part.geometry, material);
      mesh.matrixAutoUpdate = false;
      mesh.matrix.multiplyMatrices(X_FW, part.matrixWorld);
      mesh.userData.body = name;
      group.add(mesh);
    }
    for (const child of part.children) copy(child, name);
  };
  copy(object);
  return group;
}

/** The link that a hand begins with: the first above the tool that a joint moves. */
export function handOf(tool) {
  let link = tool;
  while (link.parent?.isURDFJoint && link.parent.jointType === 'fixed' && link.parent.parent?.isURDFLink) link = link.parent.parent;
  return link;
}

/** Words above a point, with a line down to it: they face the camera, as high on the screen wherever they are. */
export function label(text, colour, point, above) {
  const position = point.clone().add(new THREE.Vector3(0, 0, above));
  const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints([point, position]), new THREE.LineBasicMaterial({color: colour}));
  return new THREE.Group().add(line, words(text, colour, position));
}

function words(text, colour, position) {
  const canvas = document.createElement('canvas'), pen = canvas.getContext('2d'), font = '600 30px system-ui, "DejaVu Sans", sans-serif';
  pen.font = font;
  [canvas.width, canvas.height] = [Math.ceil(pen.measureText(text).width) + 24, 44];
  pen.font = font;
  pen.fillStyle = 'rgba(255, 255, 255, 0.88)';
  pen.roundRect(0, 0, canvas.width, canvas.height, 10);
  pen.fill();
  pen.fillStyle = colour;
  pen.textBaseline = 'middle';
  pen.fillText(text, 12, canvas.height / 2 + 1);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  const material = new THREE.SpriteMaterial({map: texture, sizeAttenuation: false, depthTest: false, transparent: true});
  const sprite = new THREE.Sprite(material);
  const high = 0.022;
  sprite.scale.set(high * canvas.width / canvas.height, high, 1);
  sprite.center.set(0.5, 0);
  sprite.position.copy(position);
  sprite.renderOrder = 2;
  return sprite;
}
