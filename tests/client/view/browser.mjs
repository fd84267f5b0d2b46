// SPDX-License-Identifier: Apache-2.0
// A page of ours in headless Chromium, as the scripts beside this one open it.
import {chromium} from 'playwright-core';

/// Opens a page and hands it to `look` with what went wrong so far and what it asked of the network; both lists grow.
export async function withPage(file, look, viewport = {width: 1280, height: 800}) {
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM || '/usr/bin/chromium',
    args: ['--headless=new', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
           '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
           '--disable-sync'],
  });
  try {
    const page = await browser.newPage({viewport});
    page.setDefaultTimeout(100_000);  // a machine may have more to do
    const messages = [], requests = [];
    page.on('console', (message) => {
      // The software renderer's own remarks on how fast it is are none of the page's.
      const own = !/GPU stall due to ReadPixels/.test(message.text());
      if (own && ['error', 'warning'].includes(message.type())) messages.push(message.text());
    });
    page.on('pageerror', (error) => messages.push(String(error)));
    page.on('request', (request) => { if (!/^(file|data|blob):/.test(request.url())) requests.push(request.url()); });
    await page.goto(`file://${file}`);
    await look(page, messages, requests);
  } finally {
    await browser.close();
  }
}
