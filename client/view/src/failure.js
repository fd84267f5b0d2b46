// SPDX-License-Identifier: Apache-2.0
// Why a request has no plan: reason, causes, what would help. A cause's two bodies are shown in red.
import {element, find} from './dom.js';

const words = (name) => name.replaceAll('_', ' ').replace(/\bik\b/, 'IK');

/** A stage of a chain that has no plan, so that its holders are known by their places alone. */
const stageText = ({holder, action}) => `${action} of holder ${holder + 1}`;

/** One word of a shell command. */
function quoted(word) { return /^[\w./:=+,@-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`; }

function setOption({path, value}) {
  return `--set ${quoted(`${path}=${typeof value === 'string' ? value : JSON.stringify(value)}`)}`;
}

export class Failure {
  /** @param onPair called with the names of the bodies to show. */
  constructor(explanation, onPair) {
    Object.assign(this, {explanation, onPair});
    find('reason').textContent = words(explanation.reason);
    find('reason-text').textContent = explanation.text;
    find('searched').textContent = `${explanation.filter ? `It ended at: ${words(explanation.filter)}. ` : ''}${
        explanation.exhaustive ? 'Everything within what the search covers was tried.' : 'The search did not try everything.'}`;
    this.fillCauses();
    this.fillFix();
    const first = find('causes').querySelector('button');
    if (first) first.click();
  }

  fillCauses() {
    const rows = find('causes').createTBody();
    for (const {cause, pair, about, stage, count} of this.explanation.causes) {
      const row = rows.insertRow(), where = element('td', pair ? '' : about ?? '');
      if (pair) where.append(this.pairButton(pair));
      row.append(element('td', `${words(cause)}${stage ? `, ${stageText(stage)}` : ''}`), where, element('td', `${count} ×`, 'number'));
    }
  }

  pairButton(pair) {
    const button = element('button', pair.join(' – '));
    button.title = 'Show in red';
    button.setAttribute('aria-pressed', false);
    button.addEventListener('click', () => {
      const on = button.getAttribute('aria-pressed') !== 'true';
      for (const other of find('causes').querySelectorAll('button')) other.setAttribute('aria-pressed', on && other === button);
      this.onPair(on ? pair : []);
    });
    return button;
  }

  fillFix() {
    const {nearest_fix, fix_text} = this.explanation;
    find('fix-text').textContent = fix_text || (nearest_fix ? '' : 'No fix was found.');
    find('fix').textContent = (nearest_fix ?? []).map(setOption).join(' \\\n  ');
    find('fix').hidden = !nearest_fix;
  }
}

/** What the farthest attempt was about, for people. */
export function farthestText({stage, tools}) {
  const arms = tools.map(({robot, arm}) => `${robot}/${arm}`).join(' and ');
  return stage ? `${arms}: ${stageText(stage)}` : arms;
}
