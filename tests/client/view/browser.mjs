// SPDX-License-Identifier: Apache-2.0
// A page of ours in headless Chromium, as the scripts beside this one open it.
import {chromium} from 'playwright-core';

async function launch() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM || '/usr/bin/chromium',
    args: ['--headless=new', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
           '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
           '--disable-sync'],
  });
}

async function open(browser, file, viewport, messages, requests) {
  const page = await browser.newPage({viewport});
  page.setDefaultTimeout(60_000);  // a machine may have more to do
  page.on('console', (message) => {
    // The software renderer's own remarks on how fast it is are none of the page's.
    const own = !/GPU stall due to ReadPixels/.test(message.text());
    if (own && ['error', 'warning'].includes(message.type())) messages.push(message.text());
  });
  page.on('pageerror', (error) => messages.push(String(error)));
  page.on('request', (request) => { if (!/^(file|data|blob):/.test(request.url())) requests.push(request.url()); });
  await page.goto(`file://${file}`);
  return page;
}

/// Opens a page and hands it to `look` with what went wrong so far and what it asked of the network; both lists grow.
/// A browser that does not get as far on a busy machine, Chromium hangs there now and then, is started again, twice.
export async function withPage(file, look, viewport = {width: 1280, height: 800}) {
  for (let tries_left = 2;; --tries_left) {
    const browser = await launch();
    try {
      const messages = [], requests = [];
      const page = await open(browser, file, viewport, messages, requests).catch((error) => {
        if (tries_left === 0 || error.name !== 'TimeoutError') throw error;
      });
      if (!page) continue;
      await look(page, messages, requests);
      return;
    } finally {
      await browser.close();
    }
  }
}
