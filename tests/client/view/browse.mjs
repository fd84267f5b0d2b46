// SPDX-License-Identifier: Apache-2.0
// Opens a plan's page in headless Chromium and prints what it sees as one JSON object.
// usage: node browse.mjs PAGE.html ROBOT LINK [TIME:CAMERA:PICTURE.png ...]
import {withPage} from './browser.mjs';

const [page_file, robot, link, ...pictures] = process.argv.slice(2);
await withPage(page_file, async (page, messages, requests) => {
  const shown = await page.evaluate(() => window.handoverViewer !== undefined);
  const seen = {shown, messages, requests};
  if (shown) {
    const drawn = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const linkAt = () => page.evaluate(([r, l]) => window.handoverViewer.linkPosition(r, l), [robot, link]);
    seen.duration = await page.evaluate(() => window.handoverViewer.duration);
    seen.link_at_start = await linkAt();
    // Scrubbing as a person does it: a click on the time line.
    const bars = page.locator('#timeline rect');
    await bars.first().waitFor();  // drawn once the page has its size
    seen.bars = await bars.count();
    const box = await page.locator('#timeline').boundingBox();
    await page.mouse.click(box.x + 74 + 0.5 * (box.width - 74), box.y + 10);
    seen.time_after_click = await page.evaluate(() => window.handoverViewer.time);
    seen.link_after_click = await linkAt();
    seen.stage_after_click = await page.locator('#stage-name').textContent();
    // Playing moves time on.
    await page.locator('#speed').selectOption('5');
    await page.locator('#play').click();
    await page.waitForFunction((from) => window.handoverViewer.time > from + 0.2, seen.time_after_click);
    await page.locator('#play').click();
    seen.time_after_play = await page.evaluate(() => window.handoverViewer.time);
    await drawn();
    // How many colours the picture has: a blank canvas has one.
    seen.colours = await page.evaluate(() => {
      const view = document.getElementById('view');
      const copy = document.createElement('canvas');
      copy.width = view.width;
      copy.height = view.height;
      const pen = copy.getContext('2d');
      pen.drawImage(view, 0, 0);
      const pixels = pen.getImageData(0, 0, copy.width, copy.height).data, colours = new Set();
      for (let i = 0; i < pixels.length; i += 4) colours.add((pixels[i] << 16) | (pixels[i + 1] << 8) | pixels[i + 2]);
      return colours.size;
    });
    for (const picture of pictures) {
      const [time, camera, file] = picture.split(':');
      await page.evaluate(([t, c]) => {
        window.handoverViewer.setTime(t);
        window.handoverViewer.setCamera(c);
      }, [Number(time), camera]);
      await drawn();
      await page.screenshot({path: file});
    }
  }
  console.log(JSON.stringify(seen));
});
