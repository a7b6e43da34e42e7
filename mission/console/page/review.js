// @ts-check
/**
 * A recording: its position and speed, and its events to jump to.
 */

import { Compare } from './compare.js';
import { el, mark, say } from './dom.js';
import { clock } from './format.js';
import { timeOf } from './state.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {import('./station.js').Event} Event */

const SPEEDS = [1, 2, 5, 10, 20, 50, 100];
const WARNING = 3; // levels of events
const ERROR = 4;
const MARKS = 300; // drawn at most
const NEAR_S = 0.5;
const SLACK_S = 1.5; // to the event before: not the one just passed

/** The next event in a direction; of the important ones, if there are any.
 * @param {readonly Event[]} events @param {number} t s @param {1 | -1} way */
export function eventNear(events, t, way) {
  const worth = events.filter((e) => e.level >= WARNING || /^(now|leg|entered)\b/.test(e.says));
  const among = worth.length ? worth : events;
  return way > 0 ? among.find((e) => e.t > t + 0.05) ?? null
    : among.findLast((e) => e.t < t - SLACK_S) ?? null;
}

/** A jump under way: a position that was not reached so far takes time. */
export class Goal {
  /** @type {number | null} s */
  to = null;
  _since = 0;

  /** @param {number} t s @param {number} snapshots received: the jump begins with one */
  set(t, snapshots) {
    [this.to, this._since] = [t, snapshots];
  }

  /** The wanted position until it is reached. @param {number} t the present position, s
   * @param {number} snapshots */
  at(t, snapshots) {
    if (this.to === null) return t;
    if (snapshots > this._since && t >= this.to - NEAR_S) this.to = null;
    return this.to ?? t;
  }
}

export class Review {
  /** @param {HTMLElement} root @param {() => Page} page */
  constructor(root, page) {
    this._root = root;
    this._page = page;
    this._play = el('button', { type: 'button', onclick: () => this._toggle() });
    this._before = el('button', { type: 'button', onclick: () => this._jump(-1) }, '«');
    this._after = el('button', { type: 'button', onclick: () => this._jump(1) }, '»');
    this._speed = el('select', { onchange: () => this._run(this._chosenSpeed()) },
      ...SPEEDS.map((s) => el('option', { value: String(s) }, `${s}×`)));
    this._slider = el('input', { type: 'range', step: '0.5' });
    this._marks = el('div', { class: 'marks', 'aria-hidden': 'true' });
    this._at = el('span', { class: 'at' });
    this._isDragged = false;
    this._goal = new Goal();
    this._marked = '';
    this._compare = new Compare(page);
    root.replaceChildren(
      el('div', { class: 'buttons' }, this._before, this._play, this._after, this._speed),
      el('div', { class: 'time' }, this._slider, this._marks), this._at, this._compare.root);
    this._slider.addEventListener('input', () => this._seek(this._slider.valueAsNumber));
    this._slider.addEventListener('pointerdown', () => { this._isDragged = true; });
    for (const name of ['pointerup', 'pointercancel']) {
      this._slider.addEventListener(name, () => { this._isDragged = false; });
    }
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle, happened } = page.chosen;
    const review = vehicle.state['review'];
    this._root.hidden = !review;
    if (!review) return;
    const t = Math.min(timeOf(vehicle, now), review.end);
    say(this._play, word(review.playing ? 'pause' : 'play'));
    mark(this._play, 'aria-pressed', String(review.playing));
    this._before.setAttribute('aria-label', word('event_before'));
    this._after.setAttribute('aria-label', word('event_after'));
    this._speed.setAttribute('aria-label', word('speed_of'));
    this._slider.setAttribute('aria-label', word('scrub'));
    this._slider.setAttribute('aria-valuetext', clock(t - review.begin));
    this._slider.min = String(review.begin);
    this._slider.max = String(review.end);
    const goal = this._goal.at(t, vehicle.snapshots);
    if (!this._isDragged) this._slider.value = String(goal);
    if (document.activeElement !== this._speed) this._speed.value = String(nearest(review.speed));
    const utc = new Date((review.wall + t) * 1000).toISOString().slice(11, 19);
    const way = goal === t ? '' : ` → ${clock(goal - review.begin)}`;
    say(this._at, `${clock(t - review.begin)}${way} / ${clock(review.end - review.begin)}  ${utc} UTC`);
    this._compare.show(page, now);
    this._mark(happened, review.begin, review.end, vehicle.setup.id);
  }

  /** @param {Event[]} events @param {number} begin @param {number} end s @param {string} id */
  _mark(events, begin, end, id) {
    const shown = `${id} ${events.length} ${begin} ${end}`;
    if (shown === this._marked || end <= begin) return;
    this._marked = shown;
    const worth = events.filter((e) => e.level >= WARNING).slice(0, MARKS);
    this._marks.replaceChildren(...worth.map((event) => {
      const made = el('div', { 'data-level': event.level >= ERROR ? 'danger' : 'warning' });
      made.style.left = `${(100 * (event.t - begin)) / (end - begin)}%`;
      return made;
    }));
  }

  _toggle() {
    const { vehicle } = this._page().chosen;
    if (vehicle.state['review']?.playing) this._say({ do: 'pause' });
    else this._run(this._chosenSpeed());
  }

  _chosenSpeed() {
    return Number(this._speed.value) || 1;
  }

  /** @param {number} speed */
  _run(speed) {
    this._say({ do: 'play', speed });
  }

  /** @param {number} t s */
  _seek(t) {
    this._goal.set(t, this._page().chosen.vehicle.snapshots);
    this._say({ do: 'seek', t });
  }

  /** @param {1 | -1} way */
  _jump(way) {
    const { chosen } = this._page();
    const from = this._goal.at(timeOf(chosen.vehicle, performance.now()), chosen.vehicle.snapshots);
    const event = eventNear(chosen.happened, from, way);
    if (event) this._seek(event.t);
  }

  /** @param {object} message */
  _say(message) {
    this._page().chosen.review.send(message);
  }
}

/** @param {number} speed */
function nearest(speed) {
  return SPEEDS.reduce((a, b) => (Math.abs(b - speed) < Math.abs(a - speed) ? b : a));
}
