// SPDX-License-Identifier: Apache-2.0
// Opens an experiment's page in headless Chromium and prints what it sees as one JSON object.
// usage: node browse_report.mjs PAGE.html PICTURE.png
import {withPage} from './browser.mjs';

const [page_file, picture] = process.argv.slice(2);
await withPage(page_file, async (page, messages, requests) => {
  const texts = (selector) => page.locator(selector).allTextContents();
  const rowsOf = (id) => page.locator(`#${id} tbody tr`).evaluateAll(
      (rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
  const count = (selector) => page.locator(selector).count();
  const seen = {messages, requests};
  seen.error = await page.locator('#error').isVisible();
  seen.title = await page.title();
  seen.setting = (await texts('#setting')).join(' ');
  seen.means = await rowsOf('means');
  seen.spreads = await rowsOf('spreads');
  seen.qualities = await rowsOf('qualities');
  seen.clearances = await rowsOf('clearances');
  seen.failures = await rowsOf('failures');
  seen.violations = await rowsOf('violations');
  const linksOf = (id) => page.locator(`#${id} a`).evaluateAll((links) => links.map((link) => link.getAttribute('href')));
  seen.failure_links = await linksOf('failures');
  seen.run_links = await linksOf('runs');
  seen.failures_text = await page.locator('#failures-text').textContent();
  seen.commands = await texts('#failures code');
  seen.marks = await texts('#times .mark-label');
  // Each bar's title begins with how many runs it stands for.
  const barsOf = async (kind) => (await texts(`#times .bar.${kind}:not(.legend) title`)).map((text) => parseInt(text));
  seen.bars = {done: await barsOf('done'), failed: await barsOf('failed')};
  const places = async () => ({
    views: await count('#places .view'), points: await count('#places .point'), cells: await count('#places .cell'),
    chosen: await texts('#places .point.chosen title'), text: await page.locator('#places-text').textContent(),
  });
  seen.places = await places();
  seen.runs = await rowsOf('runs');
  const clicked = async (column) => {
    await page.locator('#runs th button', {hasText: column}).click();
    return (await rowsOf('runs')).map(([index]) => index);
  };
  seen.by_time = await clicked(/^time/);
  seen.by_time_down = await clicked(/^time/);
  seen.by_first_plan = await clicked(/^first plan/);
  await page.locator('#points').selectOption('receiver_tool');
  await page.locator('#lattice-run').selectOption({index: 1});
  seen.places_after = await places();
  // What stands out of a phone's width; a table that scrolls in a box of its own does not.
  await page.setViewportSize({width: 390, height: 844});
  seen.beyond_phone = await page.evaluate(() => [...document.querySelectorAll('main *')]
      .filter((part) => !part.closest('.wide *') && part.getBoundingClientRect().right > innerWidth)
      .map((part) => `${part.tagName} ${part.textContent.slice(0, 30)}`));
  if (process.env.PHONE_PICTURE) await page.screenshot({path: process.env.PHONE_PICTURE, fullPage: true});
  await page.setViewportSize({width: 1280, height: 800});
  const shot = (await page.screenshot({path: picture, fullPage: true})).toString('base64');
  // How many colours the picture has: a blank one has one.
  await page.goto('about:blank');
  seen.colours = await page.evaluate(async (image) => {
    const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(image), (c) => c.charCodeAt(0))]));
    const pen = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    pen.drawImage(bitmap, 0, 0);
    const pixels = pen.getImageData(0, 0, bitmap.width, bitmap.height).data, colours = new Set();
    for (let i = 0; i < pixels.length; i += 4) colours.add((pixels[i] << 16) | (pixels[i + 1] << 8) | pixels[i + 2]);
    return colours.size;
  }, shot);
  console.log(JSON.stringify(seen));
});
