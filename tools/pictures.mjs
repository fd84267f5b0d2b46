// SPDX-License-Identifier: Apache-2.0
// A picture of a plan's page as both hands of its first handover have the object: the scene alone. tools/pictures calls
// it beside the packages that the tests of the pages use.
// usage: node pictures.mjs PAGE.html PICTURE.png WIDTHxHEIGHT CAMERA_X,Y,Z TARGET_X,Y,Z
import {withPage} from './browser.mjs';

const [page_file, picture, size, camera, target] = process.argv.slice(2);
const numbersOf = (text) => text.split(/[x,]/).map(Number);
const [width, height] = numbersOf(size);

async function pose({camera, target}) {
  Object.assign(document.getElementById('scene').style, {position: 'fixed', inset: 0, width: '100%', height: '100%', zIndex: 1});
  const viewer = handoverViewer;
  viewer.setTime(viewer.plan.stages.find(({action}) => action === 'release').start);
  for (const markers of Object.values(viewer.cell.markers)) markers.visible = false;
  viewer.resize();
  viewer.camera.position.set(...camera);
  viewer.controls.target.set(...target);
  viewer.controls.update();
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
}

await withPage(page_file, async (page, messages) => {
  await page.evaluate(pose, {camera: numbersOf(camera), target: numbersOf(target)});
  await page.screenshot({path: picture});
  if (messages.length > 0) throw new Error(messages.join('\n'));
}, {width, height});
