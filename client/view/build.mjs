// SPDX-License-Identifier: Apache-2.0
// Bundles src/NAME.{js,html,css} and src/frame.html into one page without outside references.
// usage: node build.mjs NAME OUTPUT.html
// The page holds @DATA@ where its data go in; its policy allows this one script and style, and no network.
import {createHash} from 'node:crypto';
import {existsSync, readFileSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

import {build} from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const [name, output] = process.argv.slice(2);
if (!output) {
  console.error('usage: node build.mjs NAME OUTPUT.html');
  process.exit(2);
}
const source = (ending) => readFileSync(join(here, `src/${name}.${ending}`), 'utf8');

// The licences of the packages in the bundle: the text where a package brings it, else its name.
function notices(inputs) {
  const packages = new Set(inputs.map((input) => input.match(/node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1]));
  packages.delete(undefined);
  return [...packages].sort().map((each) => {
    const folder = join(here, 'node_modules', each), file = join(folder, 'LICENSE');
    const text = existsSync(file) ? readFileSync(file, 'utf8').trim() :
                                    JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8')).license;
    return `/* ${each}:\n${text}\n*/\n`;
  }).join('');
}

const bundle = await build({
  entryPoints: [join(here, `src/${name}.js`)],
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2020',
  legalComments: 'none',
  metafile: true,
  write: false,
});
const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const script = (notices(Object.keys(bundle.metafile.inputs)) + bundle.outputFiles[0].text).replaceAll('</script', '<\\/script');
const style = source('css');
const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; ` +
    `img-src data: blob:; base-uri 'none'; form-action 'none'`;
// The first line of the page's own part is its title.
const [title, ...body] = source('html').split('\n');
const page = readFileSync(join(here, 'src/frame.html'), 'utf8')
                 .replace('@POLICY@', () => policy)
                 .replace('@TITLE@', () => title)
                 .replace('@BODY@', () => body.join('\n'))
                 .replace('@STYLE@', () => style)
                 .replace('@SCRIPT@', () => script);
writeFileSync(output, page);
