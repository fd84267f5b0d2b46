// SPDX-License-Identifier: Apache-2.0
// Holders as the page names and colours them: an arm has one colour, in the scene, the time line and the lists.
const COLOURS = [
  {strong: '#b3591c', light: '#d9985f'}, {strong: '#2f6fb3', light: '#7fa6cf'}, {strong: '#7a4a9e', light: '#b598ce'},
  {strong: '#a33a5f', light: '#d48fa8'}, {strong: '#6d6a1a', light: '#b9b568'}, {strong: '#14757a', light: '#74b3b6'},
];

export const armOf = ({robot, arm}) => `${robot}/${arm}`;

/** {strong, light} of each holder of a plan. */
export function coloursOf(holders) {
  const arms = [...new Set(holders.map(armOf))];
  return holders.map((holder) => COLOURS[arms.indexOf(armOf(holder)) % COLOURS.length]);
}

/** "carry" of the second holder: "hubo/left carry". */
export function labelOf(plan, stage) { return `${armOf(plan.holders[stage.holder])} ${stage.action}`; }

/** What the plan does, for people. */
export function titleOf({scene, plan}) {
  const {object, cell} = scene;
  if (!plan) return `${cell}: no plan for ${object}`;
  const robots = plan.holders.map(({robot}) => robot);
  const names = new Set(robots).size === robots.length ? robots : plan.holders.map(armOf);
  if (names.length === 1) return `${cell}: ${names[0]} brings ${object}`;
  const gives = names.slice(0, -1).map((name, i) => i === 0 ? `${name} gives ${object} to ${names[1]}` : `${name} to ${names[i + 1]}`);
  return `${cell}: ${gives.join(', ')}`;
}
