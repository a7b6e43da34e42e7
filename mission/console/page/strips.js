// @ts-check
/**
 * Values over time, one below the other with one time axis; the depth together with the floor.
 *
 * There is no line where a value was not known, nor between two reports that are more than ``GAP_S``
 * apart, or further apart than the rows kept of a long past.
 */

import { inksOf, sheet } from './canvas.js';
import { el, mark, say } from './dom.js';
import { clock, number } from './format.js';
import { font } from './layers.js';
import { ROWS, timeOf } from './state.js';
import { extent, roundUp, ticks } from './view.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {import('./state.js').Sample} Sample
 * @typedef {{name: string, unit: string, least: number, down?: boolean, with?: string,
 *   turns?: boolean}} Spec ``least``: of the axis, in the unit */

/** @type {readonly Spec[]} */
const SPECS = [
  { name: 'depth', unit: 'm', least: 2, down: true, with: 'floor' },
  { name: 'altitude', unit: 'm', least: 2 },
  { name: 'heading', unit: '°', least: 360, turns: true },
  { name: 'uncertainty', unit: 'm', least: 5 },
  { name: 'battery', unit: 'V', least: 1 },
];
const SPANS_S = [300, 1200, 3600, 0]; // 0: all
const SHORTEST_S = 60;
const GAP_S = 15;
const LEFT = 118; // px, for names and numbers
const HIGH = 40; // px, least height of a strip
const NAMES = { ink: 'ink', soft: 'soft', grid: 'edge', line: 'track', fill: 'depths', floor: 'careful',
  paper: 'panel', at: 'target' };

/** Greatest time between two samples of one line, s. Of a long past only some rows are kept, which
 * are further apart. @param {readonly Sample[]} samples */
export function gapOf(samples) {
  const spanned = (samples.at(-1)?.[0] ?? 0) - (samples[0]?.[0] ?? 0);
  const apart = 2 ** Math.ceil(Math.log2(Math.max(1, spanned / ROWS)));
  return Math.max(GAP_S, 2.5 * apart);
}

/** Runs of samples without a gap, between two times. @param {readonly Sample[]} samples
 * @param {number} from @param {number} to s @param {number} [gap] s
 * @returns {Array<Array<[number, number]>>} */
export function runs(samples, from, to, gap = GAP_S) {
  /** @type {Array<Array<[number, number]>>} */
  const found = [];
  let before = -Infinity;
  for (const [t, value] of samples) {
    if (t < from || t > to) continue;
    if (value === null) {
      before = -Infinity;
      continue;
    }
    if (t - before > gap) found.push([]);
    found.at(-1)?.push([t, value]);
    before = t;
  }
  return found;
}

/** As many as fit, from the first on; the first follows the last. @template T
 * @param {readonly T[]} of @param {number} first @param {number} fit @returns {T[]} */
export function turned(of, first, fit) {
  const begin = of.length > fit ? first % of.length : 0;
  return [...of.slice(begin), ...of.slice(0, begin)].slice(0, fit);
}

export class Strips {
  /** @param {HTMLElement} root @param {() => void} redraw */
  constructor(root, redraw) {
    this._redraw = redraw;
    this._span = SPANS_S[1] ?? 0;
    /** @type {number | null} px */
    this._pointer = null;
    this._fit = 1; // strips that fit
    this._first = 0; // of the known strips, if not all fit
    this._more = el('button', { type: 'button', class: 'more', onclick: () => this._turn() });
    this._title = el('h2', {}, this._more);
    this._spans = el('div', { class: 'tabs', role: 'group' },
      ...SPANS_S.map((s) => el('button', { type: 'button', onclick: () => this._choose(s) })));
    this._canvas = el('canvas', { role: 'img', 'aria-label': word('strips') });
    const hold = el('div', { class: 'hold' }, this._canvas);
    root.replaceChildren(el('div', { class: 'head' }, this._title, this._spans), hold);
    this._canvas.addEventListener('pointermove', (e) => this._point(e.offsetX));
    this._canvas.addEventListener('pointerleave', () => this._point(null));
    new ResizeObserver(redraw).observe(hold);
  }

  /** @param {number} span s */
  _choose(span) {
    this._span = span;
    this._redraw();
  }

  /** Show the strips that did not fit. */
  _turn() {
    this._first += this._fit;
    this._redraw();
  }

  /** @param {number | null} x */
  _point(x) {
    this._pointer = x;
    this._redraw();
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    this._words();
    const drawn = sheet(this._canvas);
    if (drawn === null) return;
    const { vehicle } = page.chosen;
    const to = timeOf(vehicle, now);
    const first = Math.min(to, ...Object.values(vehicle.strips).map((s) => s[0]?.[0] ?? to));
    const from = Math.min(this._span ? Math.max(first, to - this._span) : first, to - SHORTEST_S);
    const wanted = SPECS.filter((s) => vehicle.strips[s.name]?.some(([, v]) => v !== null));
    this._fit = Math.max(1, Math.floor((drawn.height - 18) / HIGH));
    const specs = turned(wanted, this._first, this._fit);
    this._sayMore(wanted.length);
    const { pen, width, height } = drawn;
    const inks = inksOf(NAMES);
    pen.clearRect(0, 0, width, height);
    if (specs.length === 0) return empty(pen, width, height, inks.soft);
    const high = (height - 18) / specs.length;
    const axis = { from, to, width, x: (/** @type {number} */ t) =>
      LEFT + ((t - from) / (to - from)) * (width - LEFT - 8) };
    times(pen, axis, height, inks);
    specs.forEach((spec, i) => this._strip(pen, spec, vehicle, axis, [i * high, high], inks));
    this._tell(specs, vehicle);
  }

  /** @param {number} count of known strips */
  _sayMore(count) {
    this._more.disabled = count <= this._fit;
    say(this._more, this._more.disabled ? word('strips') : `${word('strips')} ▾`);
    mark(this._more, 'aria-label', this._more.disabled ? null : word('strips_more'));
    mark(this._more, 'title', this._more.disabled ? null : word('strips_more'));
  }

  _words() {
    [...this._spans.children].forEach((button, i) => {
      const span = SPANS_S[i] ?? 0;
      say(button, span ? word('minutes', span / 60) : word('all'));
      button.setAttribute('aria-pressed', String(span === this._span));
    });
  }

  /** @param {CanvasRenderingContext2D} pen @param {Spec} spec
   * @param {import('./state.js').Vehicle} vehicle @param {Axis} axis
   * @param {[number, number]} box top and height, px @param {Record<keyof NAMES, string>} inks */
  _strip(pen, spec, vehicle, axis, [top, high], inks) {
    const gap = gapOf(vehicle.strips[spec.name] ?? []);
    const own = runs(vehicle.strips[spec.name] ?? [], axis.from, axis.to, gap);
    const other = spec.with ? runs(vehicle.strips[spec.with] ?? [], axis.from, axis.to, gap) : [];
    const [low, up] = bounds([...own, ...other].flat().map((p) => p[1]), spec);
    const y = (/** @type {number} */ v) => {
      const share = (v - low) / (up - low);
      return top + 5 + (spec.down ? share : 1 - share) * (high - 10);
    };
    pen.strokeStyle = inks.grid;
    pen.lineWidth = 1;
    pen.strokeRect(LEFT + 0.5, Math.round(top + 3) + 0.5, axis.width - LEFT - 9, high - 7);
    if (spec.down) area(pen, own, axis, y, y(0), inks.fill);
    lines(pen, own, axis, y, inks.line, 2, spec.turns ? 180 : Infinity);
    lines(pen, other, axis, y, inks.floor, 2, Infinity);
    const at = this._pointer === null || this._pointer < LEFT ? null
      : axis.from + ((this._pointer - LEFT) / (axis.width - LEFT - 8)) * (axis.to - axis.from);
    const shown = nearest(own.flat(), at ?? Infinity);
    names(pen, spec, [top, high], [low, up], shown?.[1] ?? null, inks);
    if (at !== null && shown) cursor(pen, axis.x(shown[0]), y(shown[1]), [top, high], inks.at);
  }

  /** A text for screen readers. @param {readonly Spec[]} specs
   * @param {import('./state.js').Vehicle} vehicle */
  _tell(specs, vehicle) {
    const text = specs.map((s) => `${word(s.name)} ${number(vehicle.strips[s.name]?.at(-1)?.[1], 1)} ${s.unit}`);
    this._canvas.setAttribute('aria-label', [word('strips'), ...text].join(', '));
  }
}

/** @typedef {{from: number, to: number, width: number, x: (t: number) => number}} Axis
 * @typedef {CanvasRenderingContext2D} Pen
 * @typedef {Array<Array<[number, number]>>} Runs */

/** @param {number[]} values @param {Spec} spec @returns {[number, number]} */
export function bounds(values, spec) {
  if (spec.turns) return [0, 360];
  const [low, up] = values.length ? extent(values) : [0, spec.least];
  if (spec.down) return [Math.min(0, low), Math.max(up, spec.least) * 1.05];
  const middle = (low + up) / 2;
  const half = Math.max(up - low, spec.least) / 2;
  return low >= 0 && low < up / 2 ? [0, Math.max(up, spec.least)] : [middle - half, middle + half];
}

/** The last point at or before a time. @param {Array<[number, number]>} points @param {number} t */
function nearest(points, t) {
  return points.findLast((p) => p[0] <= t) ?? null;
}

/** @param {Pen} pen @param {Axis} axis @param {number} height @param {Record<'soft' | 'grid', string>} inks */
function times(pen, axis, height, inks) {
  const step = [10, 30, 60, 120, 300, 600, 1200, 3600].find((s) =>
    (s / (axis.to - axis.from)) * (axis.width - LEFT) > 70) ?? roundUp((axis.to - axis.from) / 6);
  font(pen, 12);
  pen.textAlign = 'center';
  pen.strokeStyle = inks.grid;
  pen.fillStyle = inks.soft;
  pen.lineWidth = 1;
  pen.beginPath();
  for (const t of ticks(axis.from, axis.to, step)) {
    const x = Math.round(axis.x(t)) + 0.5;
    pen.moveTo(x, 3);
    pen.lineTo(x, height - 16);
    if (t >= 0 && x < axis.width - 20) pen.fillText(clock(t), x, height - 3);
  }
  pen.stroke();
}

/** @param {Pen} pen @param {Runs} found @param {Axis} axis @param {(v: number) => number} y
 * @param {string} ink @param {number} wide px @param {number} jump beyond which no line is drawn */
function lines(pen, found, axis, y, ink, wide, jump) {
  pen.strokeStyle = ink;
  pen.lineWidth = wide;
  pen.lineJoin = 'round';
  pen.beginPath();
  for (const run of found) {
    run.forEach(([t, v], i) => {
      const apart = i === 0 || Math.abs(v - (run[i - 1]?.[1] ?? v)) > jump;
      if (apart) pen.moveTo(axis.x(t), y(v));
      else pen.lineTo(axis.x(t), y(v));
    });
    if (run.length === 1 && run[0]) pen.rect(axis.x(run[0][0]) - 1, y(run[0][1]) - 1, 2, 2);
  }
  pen.stroke();
}

/** Fill the water above the line. @param {Pen} pen @param {Runs} found @param {Axis} axis
 * @param {(v: number) => number} y @param {number} top @param {string} ink */
function area(pen, found, axis, y, top, ink) {
  pen.fillStyle = ink;
  for (const run of found) {
    pen.beginPath();
    pen.moveTo(axis.x(run[0]?.[0] ?? 0), top);
    for (const [t, v] of run) pen.lineTo(axis.x(t), y(v));
    pen.lineTo(axis.x(run.at(-1)?.[0] ?? 0), top);
    pen.fill();
  }
}

/** @param {Pen} pen @param {Spec} spec @param {[number, number]} box @param {[number, number]} bound
 * @param {number | null} value @param {Record<'ink' | 'soft', string>} inks */
function names(pen, spec, [top, high], [low, up], value, inks) {
  const digits = spec.turns ? 0 : 1;
  pen.textAlign = 'left';
  font(pen, 13, 600);
  pen.fillStyle = inks.ink;
  pen.fillText(word(spec.name), 0, top + 15);
  font(pen, 15, 700);
  pen.fillText(`${number(value, digits)} ${spec.unit}`, 0, top + 33);
  if (high < 46) return;
  font(pen, 11);
  pen.fillStyle = inks.soft;
  pen.textAlign = 'right';
  const [upper, lower] = spec.down ? [low, up] : [up, low];
  pen.fillText(number(upper, 0), LEFT - 4, top + 13);
  pen.fillText(number(lower, 0), LEFT - 4, top + high - 6);
}

/** @param {Pen} pen @param {number} x @param {number} y @param {[number, number]} box
 * @param {string} ink */
function cursor(pen, x, y, [top, high], ink) {
  pen.strokeStyle = pen.fillStyle = ink;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(x, top + 3);
  pen.lineTo(x, top + high - 4);
  pen.stroke();
  pen.beginPath();
  pen.arc(x, y, 3.5, 0, 2 * Math.PI);
  pen.fill();
}

/** @param {Pen} pen @param {number} width @param {number} height @param {string} ink */
function empty(pen, width, height, ink) {
  font(pen, 15);
  pen.textAlign = 'center';
  pen.fillStyle = ink;
  pen.fillText(word('nothing'), width / 2, height / 2);
}
