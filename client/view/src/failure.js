// SPDX-License-Identifier: Apache-2.0
// Why a request has no plan, beside the picture of it: reason, how far the search came, causes, what would help.
import {element, find, swatch} from './dom.js';
import {drawFunnel} from './funnel.js';

const MOST_CAUSES = 8;  // shown at once

const words = (name) => name.replaceAll('_', ' ').replace(/\bik\b/, 'IK');

/** A stage of a chain that has no plan, so that its holders are known by their places alone. */
const stageText = ({holder, action}) => `${action} of holder ${holder + 1}`;

/** One word of a shell command. */
function quoted(word) { return /^[\w./:=+,@-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`; }

function setOption({path, value}) {
  return `--set ${quoted(`${path}=${typeof value === 'string' ? value : JSON.stringify(value)}`)}`;
}

/** To the clipboard, or, where a browser keeps that from pages, into the selection and from there. */
async function copy(target) {
  try {
    await navigator.clipboard.writeText(target.textContent);
  } catch {
    getSelection().selectAllChildren(target);
    document.execCommand('copy');
  }
}

export class Failure {
  /** @param scene what the picture shows of it, a FailureScene. @param changed called when the picture has changed. */
  constructor(file, scene, changed) {
    Object.assign(this, {explanation: file.explanation, scene, changed});
    const {reason, text, filter, exhaustive} = this.explanation;
    find('reason').textContent = words(reason);
    find('reason-text').textContent = text;
    find('searched').textContent = `${filter ? `It ended at: ${words(filter)}. ` : ''}${
        exhaustive ? 'Everything within what the search covers was tried.' : 'The search did not try everything.'}`;
    drawFunnel(file);
    this.fillCauses();
    this.fillFix();
    this.fillKey();
    this.show(this.telling());
  }

  fillCauses() {
    const rows = find('causes').createTBody(), {causes} = this.explanation;
    this.buttons = new Map();
    causes.forEach((cause, i) => {
      const {pair, about, stage, count} = cause, row = rows.insertRow(), where = element('td', pair ? '' : about ?? '');
      row.hidden = i >= MOST_CAUSES;
      if (pair) where.append(this.pairButton(cause));
      row.append(element('td', `${words(cause.cause)}${stage ? `, ${stageText(stage)}` : ''}`), where, element('td', `${count} ×`, 'number'));
    });
    const more = find('more-causes');
    more.hidden = causes.length <= MOST_CAUSES;
    more.textContent = `All ${causes.length} causes`;
    more.addEventListener('click', () => {
      for (const row of rows.rows) row.hidden = false;
      more.hidden = true;
    });
  }

  pairButton(cause) {
    const button = element('button', cause.pair.join(' – '));
    button.title = 'Show in red';
    button.addEventListener('click', () => this.show(this.shown === cause ? undefined : cause));
    this.buttons.set(cause, button);
    return button;
  }

  /** The cause whose bodies are red at first: of the stage that came farthest, else the most frequent. */
  telling() {
    const {causes, farthest} = this.explanation, pairs = causes.filter(({pair}) => pair), at = farthest?.stage;
    return pairs.find(({stage}) => at && stage && stage.holder === at.holder && stage.action === at.action) ?? pairs[0];
  }

  show(cause) {
    this.shown = cause;
    for (const [other, button] of this.buttons) button.setAttribute('aria-pressed', other === cause);
    this.scene.highlight(cause?.pair ?? []);
    find('red').hidden = !cause;
    if (cause) find('red').textContent = `Red: ${cause.pair.join(' and ')}${cause.cause === 'collision' ? ', which collide' : `: ${words(cause.cause)}`}. ${this.whereText(cause.pair)}`;
    this.changed();
  }

  /** Where the picture has the two: of an arm that has no ghost it shows no other posture than that of the start. */
  whereText(pair) {
    const [a, b] = pair.map((body) => this.scene.placeOf(body));
    if (a === b) return `Both are drawn ${a ?? 'as they stand at the start'}.`;
    return pair.map((body, i) => `${body} is drawn ${[a, b][i] ?? 'as it stands at the start'}`).join(', ') + '.';
  }

  fillFix() {
    const {nearest_fix, fix_text} = this.explanation;
    find('fix-text').textContent = fix_text || (nearest_fix ? '' : 'No fix is known.');
    find('fix').textContent = (nearest_fix ?? []).map(setOption).join(' \\\n  ');
    find('fix-box').hidden = !nearest_fix;
    find('copy').addEventListener('click', async () => {
      await copy(find('fix'));
      find('copy').textContent = 'copied';
    });
  }

  /** What the colours of the picture mean. */
  fillKey() {
    for (const {colour, text} of this.scene.entries) {
      const item = element('li');
      item.append(swatch(colour), text);
      find('key').append(item);
    }
    find('key-part').hidden = this.scene.entries.length === 0 && !this.telling();
    find('slice').textContent = this.scene.slice ?
        `Where arms reach is a slice of their maps at a height of ${this.scene.slice}: the darker, the better the arm moves there.` : '';
  }
}

/** What the farthest attempt was about, for people. */
export function farthestText({stage, tools}) {
  const arms = tools.map(({robot, arm}) => `${robot}/${arm}`).join(' and ');
  return [arms, stage ? stageText(stage) : ''].filter(Boolean).join(': ');
}
