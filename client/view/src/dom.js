// SPDX-License-Identifier: Apache-2.0
// Elements of the pages, and numbers as they write them.
export const find = (id) => document.getElementById(id);

export function element(tag, text = '', className = '') {
  const made = document.createElement(tag);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}

export function link(address, text) {
  const made = element('a', text);
  made.href = address;
  return made;
}

/// A square of a colour.
export function swatch(colour) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  const square = document.createElementNS('http://www.w3.org/2000/svg', 'rect');
  for (const each of [svg, square]) {
    each.setAttribute('width', 11);
    each.setAttribute('height', 11);
  }
  square.setAttribute('fill', colour);
  svg.append(square);
  return svg;
}

export const number = (value) => value === undefined || value === null ? '' : value.toFixed(2);
export const seconds = (value) => value === undefined || value === null ? '' : value.toFixed(4);

/// Fills a table with rows of texts; columns from `numbers` on are set as numbers.
export function table(target, heads, rows, numbers) {
  const head = target.createTHead().insertRow();
  heads.forEach((text, i) => head.append(element('th', text, i >= numbers ? 'number' : '')));
  const body = target.createTBody();
  for (const texts of rows) {
    const row = body.insertRow();
    texts.forEach((text, i) => row.append(element('td', text, i >= numbers ? 'number' : '')));
  }
}
