// SPDX-License-Identifier: Apache-2.0
// Opens a plan's page in headless Chromium and prints what it sees as one JSON object: most of it in a window of the
// first size, what is misplaced in windows of all of them. Pictures are of the first time and size.
// usage: node browse.mjs PAGE.html WIDTHxHEIGHT[,WIDTHxHEIGHT ...] [TIME ...] [CAMERA:PICTURE.png ...]
import {withPage} from './browser.mjs';

const [page_file, sizes, ...rest] = process.argv.slice(2);
const times = rest.filter((argument) => !argument.includes(':')).map(Number);
const windows = sizes.split(',').map((size) => {
  const [width, height] = size.split('x').map(Number);
  return {width, height};
});

/** What stands on what, and what is cut off or beyond the page, as a person would see it. */
function misplaced() {
  const boxOf = (element) => element.getBoundingClientRect();
  const shown = (element) => boxOf(element).width > 0 && boxOf(element).height > 0;
  const nameOf = (element) => `${element.tagName.toLowerCase()}${element.id ? `#${element.id}` : ''} "${element.textContent.trim().slice(0, 30)}"`;
  const leaves = [...document.querySelectorAll(
      'h1, h2, p, dt, dd, li, pre, td, label, button, select, output, .bar, #scrub, #plot, #scene, #timeline text, #timeline')].filter(shown);
  const overlaps = [], outside = [];
  const scroller = document.querySelector('aside');
  for (const [i, a] of leaves.entries()) {
    const box = boxOf(a);
    if (box.left < -1 || box.right > innerWidth + 1 || a.scrollWidth > a.clientWidth + 1 && a.clientWidth > 0) outside.push(nameOf(a));
    for (const b of leaves.slice(i + 1)) {
      if (a.contains(b) || b.contains(a) || scroller.contains(a) !== scroller.contains(b)) continue;
      const other = boxOf(b);
      const across = Math.min(box.right, other.right) - Math.max(box.left, other.left);
      const down = Math.min(box.bottom, other.bottom) - Math.max(box.top, other.top);
      if (across > 1.5 && down > 1.5) overlaps.push(`${nameOf(a)} on ${nameOf(b)}`);
    }
  }
  for (const bar of document.querySelectorAll('#timeline .bar text')) {
    if (boxOf(bar).right > boxOf(bar.parentElement.querySelector('rect')).right) outside.push(`label ${bar.textContent}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) outside.push(`page ${document.documentElement.scrollWidth} px`);
  return {overlaps, outside};
}

/** How many colours the picture has, a blank one has one, and how many of its points are as red as bodies that touch. */
function coloursOf(image) {
  const copy = document.createElement('canvas');
  copy.width = image.width;
  copy.height = image.height;
  const pen = copy.getContext('2d');
  pen.drawImage(image, 0, 0);
  const pixels = pen.getImageData(0, 0, copy.width, copy.height).data, colours = new Set();
  let red = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    colours.add((pixels[i] << 16) | (pixels[i + 1] << 8) | pixels[i + 2]);
    if (pixels[i] > 120 && pixels[i] > 3 * pixels[i + 1] && pixels[i] > 3 * pixels[i + 2]) ++red;
  }
  return {colours: colours.size, red};
}

await withPage(page_file, async (page, messages, requests) => {
  const text = (selector) => page.locator(selector).textContent();
  const texts = (selector) => page.locator(selector).allTextContents();
  const inPage = (expression) => page.evaluate(expression);
  const drawn = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const visible = (selector) => page.locator(selector).evaluateAll((all) => all.filter((part) => part.getClientRects().length > 0).length);
  const seen = {messages, requests, error: await page.locator('#error').isVisible() ? await text('#error') : ''};
  if (seen.error === '') {
    seen.title = await text('#title');
    seen.planned_parts = await visible('.planned');
    seen.failed_parts = await visible('.failed');
    seen.reason = await text('#reason');
    seen.cameras = await texts('#cameras button');
    seen.text = await page.locator('aside').innerText();
    seen.duration = await inPage('handoverViewer.duration');
    if (seen.planned_parts > 0) await lookAtPlan();
    if (seen.failed_parts > 0) seen.failure = await lookAtFailure();
    await drawn();
    Object.assign(seen, await page.evaluate(`(${coloursOf})(document.getElementById('view'))`));
    seen.misplaced = [];
    for (const size of [...windows].reverse()) {  // the first one last: it stays
      await page.setViewportSize(size);
      await drawn();
      seen.misplaced.push({...size, ...await page.evaluate(misplaced)});
    }
    seen.at = [];
    for (const time of times) seen.at.push(await momentAt(time));
    for (const [camera, picture] of rest.filter((argument) => argument.includes(':')).map((argument) => argument.split(':'))) {
      await page.evaluate(([t, c]) => {
        handoverViewer.setTime(t);
        handoverViewer.setCamera(c);
      }, [times[0] ?? 0, camera]);
      await drawn();
      await page.screenshot({path: picture, fullPage: true});
    }
  }
  console.log(JSON.stringify(seen));

  async function lookAtPlan() {
    await page.locator('#timeline .bar').first().waitFor();  // drawn once the page has its size
    seen.names = await texts('#timeline .name');
    seen.bars = await page.locator('#timeline .bar').evaluateAll((bars) => bars.map((bar) => {
      const {left, right, top} = bar.querySelector('rect').getBoundingClientRect();
      return {stage: Number(bar.dataset.stage), left, right, top, title: bar.querySelector('title').textContent};
    }));
    const {left, right, top} = await page.evaluate(() => {
      const box = document.getElementById('timeline').getBoundingClientRect();
      return {left: box.left + handoverViewer.timeline.xOf(0), right: box.right, top: box.top};
    });
    seen.time_line = {left, right};
    // Scrubbing as a person does it: a click on the time line.
    await page.mouse.click(Math.round((left + right) / 2), top + 10);
    const pixel = seen.duration / (right - left);
    const time = await inPage('handoverViewer.time');
    seen.time_after_click = {time, half: Math.abs(time - seen.duration / 2) < 2 * pixel ? time : seen.duration / 2};
    // Playing moves time on; slowly, so that the end is far on a busy machine too.
    await page.locator('#speed').selectOption('0.5');
    await page.locator('#play').click();
    const later = await page.waitForFunction((from) => handoverViewer.time > from + 0.1 && handoverViewer.time, time);
    seen.time_after_play = await later.jsonValue();
    if (await inPage('handoverViewer.playing')) await page.locator('#play').click();  // it stops at the end
    // Keys work after a click on a button.
    await page.keyboard.press('End');
    seen.time_after_key = await inPage('handoverViewer.time');
  }

  async function lookAtFailure() {
    const failure = {
      funnel: await page.locator('#funnel tr').evaluateAll((rows) => rows.map((row) => [row.className, ...[...row.cells].map((cell) => cell.textContent)])),
      key: await texts('#key li'), slice: await text('#slice'), red: await text('#red'), runs: await texts('#run option'),
      causes: await visible('#causes tr'),
    };
    await drawn();
    Object.assign(failure, await page.evaluate(() => {
      const {cell} = handoverViewer, {markers, highlighted} = cell;
      const placeOf = ({matrixWorld: {elements}}) => [12, 13, 14].map((i) => elements[i]);
      return {
        red_places: highlighted.map(({mesh}) => placeOf(mesh)),
        farthest: markers.farthest.children.map(placeOf),
        fix: markers.fix.children.slice(0, 1).map(placeOf),
        // Two triangles a cell, in the order in which they are drawn.
        shaded: markers.workspaces.children.flatMap(({children}) => children).filter(({isMesh}) => isMesh).map(({geometry}) => geometry.attributes.position.count / 6),
      };
    }));
    if (await page.locator('#copy').isVisible()) {
      await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
      await page.locator('#copy').click();
      await page.locator('#copy', {hasText: 'copied'}).waitFor();
      failure.copied = await page.evaluate(() => navigator.clipboard.readText());
    }
    return failure;
  }

  async function momentAt(time) {
    return page.evaluate((t) => {
      const {cell} = handoverViewer;
      handoverViewer.setTime(t);
      const joints = {};
      for (const [name, robot] of cell.robots) {
        joints[name] = Object.fromEntries(Object.entries(robot.joints).map(([joint, {angle}]) => [joint, angle]));
      }
      return {
        joints, object: handoverViewer.objectPosition(), stage: document.getElementById('stage-name').textContent,
        text: document.getElementById('stage-text').textContent,
      };
    }, time);
  }
}, windows[0]);
