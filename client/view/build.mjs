// SPDX-License-Identifier: Apache-2.0
// Bundles the viewer into one page without outside references. usage: node build.mjs OUTPUT.html
// The page holds @DATA@ where the plan goes in; its policy allows this one script and style, and no network.
import {createHash} from 'node:crypto';
import {readFileSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

import {build} from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const output = process.argv[2];
if (!output) {
  console.error('usage: node build.mjs OUTPUT.html');
  process.exit(2);
}

const bundle = await build({
  entryPoints: [join(here, 'src/main.js')],
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2020',
  legalComments: 'inline',
  write: false,
});
const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const script = bundle.outputFiles[0].text.replaceAll('</script', '<\\/script');
const style = readFileSync(join(here, 'src/style.css'), 'utf8');
const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; ` +
    `img-src data: blob:; base-uri 'none'; form-action 'none'`;
const page = readFileSync(join(here, 'src/page.html'), 'utf8')
                 .replace('@POLICY@', () => policy)
                 .replace('@STYLE@', () => style)
                 .replace('@SCRIPT@', () => script);
writeFileSync(output, page);
