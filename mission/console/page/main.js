// @ts-check
/**
 * The page: loads the setup, opens the connections, and updates each room.
 *
 *     frames --Station--> Vehicle (state) --rooms--> screen           presses --Intents--> server
 */

import { Alarms } from './alarms.js';
import { Bar } from './bar.js';
import { Chart } from './chart.js';
import { Charts } from './charts.js';
import { Checklist } from './checklist.js';
import { Command } from './command.js';
import { ALONE } from './compare.js';
import { byId, el } from './dom.js';
import { Journal } from './journal.js';
import { Legs } from './legs.js';
import { keepLight } from './light.js';
import { Margins } from './margins.js';
import { planRoom } from './plan.js';
import { Review } from './review.js';
import { States } from './states.js';
import { Station } from './station.js';
import { Stick } from './stick.js';
import { Strips } from './strips.js';
import { Tabs } from './tabs.js';
import { Urgent } from './urgent.js';
import { Values } from './values.js';
import { AGAIN_MS, Refused, ask, takeToken } from './wire.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const EVERY_MS = 250; // ages grow without news

/** @param {any} setup @param {string} token */
function open(setup, token) {
  let isDue = false;
  const redraw = () => {
    if (isDue || document.hidden) return;
    isDue = true;
    requestAnimationFrame(() => {
      isDue = false;
      show();
    });
  };
  const changed = () => {
    if (document.hidden) alarms.show(page, performance.now());
    redraw();
  };
  const stations = setup.vehicles.map((/** @type {any} */ one) => new Station(one, token, changed));
  /** @type {Page} */
  const page = { stations, chosen: stations[0], stale: setup.stale_s, token, redraw, compared: { ...ALONE } };
  const here = () => page;
  const alarms = new Alarms(byId('banner'), byId('sound'));
  const charts = new Charts(token, redraw);
  const picked = (/** @type {string} */ room) => {
    for (const place of tabs) place.take(room);
    redraw();
  };
  const tabs = [
    new Tabs(byId('centre'), ['chart', 'legs', 'planner'], 'wide-off', picked),
    new Tabs(byId('side'), ['command', 'stick', 'checklist'], 'wide-off', picked),
    new Tabs(byId('tabs'), ['chart', 'status', 'command', 'stick', 'strips', 'journal', 'legs',
      'planner', 'checklist'], 'narrow-off', picked),
  ];
  const rooms = [
    new Bar(byId, (station) => {
      page.chosen = station;
      redraw();
    }),
    alarms, new Values(byId('values')), new Chart(byId, charts, redraw), new Legs(byId('legs')),
    new States(byId('states')), new Margins(byId('margins')), new Strips(byId('strips'), redraw),
    new Journal(byId('journal'), redraw), new Command(byId('command'), here),
    new Stick(byId('stick'), here), new Checklist(byId('checklist'), here),
    new Review(byId('review'), here), new Urgent(byId, here), planRoom(here, charts), ...tabs,
  ];
  const show = () => {
    const now = performance.now();
    for (const room of rooms) room.show(page, now);
    for (const station of stations) station.shown();
  };
  setInterval(changed, EVERY_MS);
  document.addEventListener('visibilitychange', () => {
    if (document.hidden) for (const station of stations) station.shown();
    redraw();
  });
  for (const press of ['pointerdown', 'keydown']) {
    document.addEventListener(press, () => alarms.allow(), { once: true });
  }
  document.addEventListener('keydown', (event) => {
    const focused = document.activeElement;
    if (event.key === 'Escape' && focused instanceof HTMLElement) focused.blur();
  });
  redraw();
  return redraw;
}

async function begin() {
  const token = takeToken();
  let redraw = () => {};
  keepLight(byId('theme'), byId('language'), () => redraw());
  for (;;) {
    try {
      redraw = open(await ask('/api/setup', token), token);
      return;
    } catch (error) {
      const says = error instanceof Refused && error.status === 403 ? 'refused_page' : 'opening';
      const alarm = el('div', { class: 'alarm', role: 'alert' }, el('strong', {}, word(says)));
      byId('banner').replaceChildren(alarm);
    }
    await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
  }
}

void begin();
