// @ts-check
/**
 * The chart of a plan in work: its places can be dragged, moved by keys, and added.
 *
 * It changes nothing itself: it reports the user's wish, and gets the places of the changed text.
 */

import { inksOf, sheet } from './canvas.js';
import { el, mark, say } from './dom.js';
import { bearing, length, place as written } from './format.js';
import { Frame, between } from './geo.js';
import { INK_NAMES, LAYERS, font } from './layers.js';
import { NEARER, Panning } from './panning.js';
import { drawGhost, drawPlaces, placeNear } from './places.js';
import { routesOf, stillOf } from './scene.js';
import { View } from './view.js';
import { word } from './words.js';

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./places.js').Place} Place
 * @typedef {import('./layers.js').Scene} Scene
 * @typedef {{moved: (index: number, to: Pair) => void, added: (to: Pair) => void,
 *   removed: (index: number) => void, chosen: (index: number) => void, redraw: () => void}} Wishes
 *   places as latitude and longitude */

const FAR_M = 20000; // beyond that, another frame
const SAME_M = 0.01;
const CARRY_PX = 6; // step of an arrow key
const AROUND_M = 200; // around a single place

export class DraftChart {
  /** @type {readonly Place[]} */
  places = [];
  chosen = -1;
  isAdding = false; // the next press adds a place
  /** @type {import('./places.js').Ghost | null} */
  ghost = null;
  time = 0; // s, of the ghost
  /** @type {any} the track in still water, from the server */
  still = null;
  /** @type {any} of the last text that could be read */
  _map = null;
  /** @type {number | null} */
  _radius = null;
  /** @type {Pair | null} */
  _home = null;
  /** @type {Frame | null} */
  _frame = null;

  /** @param {Wishes} wishes @param {import('./charts.js').Charts} charts drawn under it */
  constructor(wishes, charts) {
    this._wishes = wishes;
    this._charts = charts;
    this.canvas = el('canvas', { tabindex: '0', role: 'application' });
    this._pointed = el('p', { class: 'pointed' });
    this._buttons = ['+', '−', '⤢'].map((sign) => el('button', { type: 'button' }, sign));
    this.root = el('div', { class: 'draft-chart' }, this.canvas,
      el('div', { class: 'chart-buttons' }, ...this._buttons), this._pointed);
    this._view = new View();
    /** @type {Pair | null} m, where the chosen place is being moved */
    this._carried = null;
    this._isFitted = false;
    this._isAlone = true; // no track of this mission has come so far
    this._panning = new Panning(this.canvas, this._view, { redraw: wishes.redraw,
      fit: () => this._fit(), take: (at, isTouch) => this._take(at, isTouch),
      keys: { n: () => this._next(1), p: () => this._next(-1), Delete: () => this._remove(),
        a: () => this._addAt([this._view.width / 2, this._view.height / 2]) } });
    this._listen();
  }

  _listen() {
    const acts = [() => this._view.zoom(NEARER), () => this._view.zoom(1 / NEARER), () => this._fit()];
    this._buttons.forEach((button, i) => button.addEventListener('click',
      () => this._panning.moved(acts[i] ?? (() => {}))));
    this.canvas.addEventListener('keydown', (event) => this._carryKey(event), { capture: true });
    this.canvas.addEventListener('blur', () => this._letGo());
  }

  /** Take the check's answer. @param {any} said @param {boolean} isNew another mission */
  take(said, isNew) {
    this.places = said.places ?? [];
    if (this.chosen >= this.places.length) this.chosen = -1;
    if (said.map) Object.assign(this, { _map: said.map, _radius: said.radius });
    if (isNew && !said.map) Object.assign(this, { _map: null, _radius: null });
    if (said.home || isNew || this.places.length) this._home = said.home ?? null;
    const first = said.home ?? this.places.find((one) => one.at)?.at ?? null;
    const strange = first && this._frame && Math.hypot(...this._frame.toLocal(.../** @type {Pair} */ (first))) > FAR_M;
    if (first && (!this._frame || strange)) {
      this._frame = new Frame(...(/** @type {Pair} */ (first)));
      this._isFitted = false;
    }
    if (said.home && this._frame) this._measureFrom(said.home);
    if (isNew) Object.assign(this, { _isFitted: false, _isAlone: true });
  }

  /** Count the grid from home, as the text does, without moving the picture. @param {Pair} home */
  _measureFrom(home) {
    const by = this._frame?.toLocal(...home) ?? [0, 0];
    if (Math.hypot(...by) < SAME_M) return;
    this._frame = new Frame(...home);
    this._view.shift(by);
    if (this._carried) this._carried = [this._carried[0] - by[0], this._carried[1] - by[1]];
  }

  /** Take the track in still water; a plan by heading has nothing else to show.
   * @param {any} said null: none so far */
  takeStill(said) {
    this.still = said;
    if (said?.track && this._isAlone && this.places.length < 2) this._isFitted = false;
    if (said && said.is !== 'flown') this._isAlone = false;
  }

  show() {
    mark(this.canvas, 'aria-label', word('plan_chart_keys'));
    ['zoom_in', 'zoom_out', 'fit'].forEach((key, i) => {
      if (this._buttons[i]) mark(this._buttons[i], 'aria-label', word(key));
    });
    const drawn = sheet(this.canvas);
    if (drawn === null) return;
    Object.assign(this._view, { width: drawn.width, height: drawn.height });
    const frame = this._frame;
    if (frame && !this._isFitted) this._fit();
    const inks = inksOf(INK_NAMES);
    const scene = this._scene();
    for (const layer of LAYERS) layer(drawn.pen, this._view, scene, inks);
    if (frame) {
      if (this.ghost) drawGhost(drawn.pen, this._view, frame, inks, this.ghost, this.time);
      drawPlaces(drawn.pen, this._view, frame, inks, this.places, this.chosen, this._carried);
    } else this._empty(drawn.pen, inks.soft);
    mark(this.root, 'data-still', this.still?.is ?? null);
    this.canvas.style.cursor = this.isAdding ? 'copy' : 'crosshair';
    this._tellPointer();
  }

  /** @returns {Scene} */
  _scene() {
    const frame = this._frame;
    const still = frame ? stillOf(this.still, frame) : null;
    if (still && this.ghost) still.turns = []; // the ghost has its own ellipses
    /** @type {Scene} */
    const made = { hasPlace: frame !== null, home: frame && this._home ? frame.toLocal(...this._home) : null,
      radius: this._radius, routes: frame ? routesOf(this._map, frame) : [],
      still, leg: this.places[this.chosen]?.path ?? '',
      target: null, track: [], here: null, others: [] };
    if (frame) made.charts = { draw: (pen, view) => this._charts.draw(pen, view, frame) };
    return made;
  }

  /** @param {CanvasRenderingContext2D} pen @param {string} ink */
  _empty(pen, ink) {
    font(pen, 18, 600);
    pen.textAlign = 'center';
    pen.fillStyle = ink;
    pen.fillText(word('plan_no_home'), this._view.width / 2, this._view.height / 2);
  }

  _tellPointer() {
    const frame = this._frame;
    const at = this._carried ?? (this._panning.pointer && this._view.toWorld(this._panning.pointer));
    if (!frame || !at) return say(this._pointed, '');
    const chosen = this.places[this.chosen];
    const depth = this._charts.depthAt(at, this._view, frame);
    const parts = [written(...frame.toEarth(...at)), depth && word('charted', depth)];
    if (this._home) {
      const way = between(frame.toLocal(...this._home), at);
      parts.push(`${length(way.range)} ${bearing(way.bearing)} ${word('of_home')}`);
    }
    if (this._carried && chosen) parts.unshift(chosen.path);
    say(this._pointed, parts.filter(Boolean).join(' · '));
  }

  _fit() {
    const frame = this._frame;
    if (frame === null) return;
    this._isFitted = true;
    const { home, routes, still } = this._scene();
    const known = this.places.flatMap((one) => (one.at ? [frame.toLocal(...one.at)] : []));
    const ghost = this.ghost?.track.map((row) => frame.toLocal(row[1], row[2])) ?? [];
    const points = [...known, ...ghost, ...(still?.line ?? []), ...routes.flatMap((route) => route.points)];
    if (home) points.push(home);
    const [one] = points;
    if (one && points.every((p) => Math.hypot(p[0] - one[0], p[1] - one[1]) < 1)) {
      points.push([one[0] - AROUND_M, one[1] - AROUND_M], [one[0] + AROUND_M, one[1] + AROUND_M]);
    }
    this._view.fit(points);
  }

  // --- places ---

  /** @param {number} index */
  choose(index) {
    if (this.chosen === index) return;
    this.chosen = index;
    this._carried = null;
  }

  /** @param {Pair} at px @param {boolean} isTouch */
  _take(at, isTouch) {
    const frame = this._frame;
    if (!frame) return null;
    if (this.isAdding) {
      this._addAt(at);
      return { drag: () => {}, drop: () => {} };
    }
    const found = placeNear(this.places, frame, this._view, at, isTouch);
    const place = this.places[found];
    if (!place) return null;
    this.choose(found);
    this._wishes.chosen(found);
    const from = at;
    let isMoved = false;
    return {
      drag: (/** @type {Pair} */ to) => {
        isMoved ||= Math.hypot(to[0] - from[0], to[1] - from[1]) > 3;
        if (isMoved && !place.fixed) this._carried = this._view.toWorld(to);
      },
      drop: (/** @type {Pair | null} */ to) => {
        this._carried = null;
        if (to && isMoved) this._wishes.moved(found, frame.toEarth(...this._view.toWorld(to)));
      },
    };
  }

  /** @param {Pair} at px */
  _addAt(at) {
    this.isAdding = false;
    if (this._frame) this._wishes.added(this._frame.toEarth(...this._view.toWorld(at)));
  }

  _remove() {
    if (this.places[this.chosen]) this._wishes.removed(this.chosen);
  }

  /** @param {number} by */
  _next(by) {
    const count = this.places.length;
    if (!count) return;
    this.choose(((this.chosen < 0 ? (by > 0 ? -1 : 0) : this.chosen) + by + count) % count);
    this._wishes.chosen(this.chosen);
    const at = this.places[this.chosen]?.at;
    if (at && this._frame) this._view.centre(this._frame.toLocal(...at));
  }

  // --- moving a place by keys: Enter picks it up and puts it down ---

  /** @param {KeyboardEvent} event */
  _carryKey(event) {
    const place = this.places[this.chosen];
    if (!this._frame || !place?.at || event.ctrlKey || event.altKey || event.metaKey) return;
    /** @type {Record<string, Pair>} */
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const way = ways[event.key];
    if (event.key === 'Enter') this._pickOrPut(place);
    else if (this._carried && way) {
      const step = CARRY_PX / this._view.scale;
      this._carried = [this._carried[0] + way[0] * step, this._carried[1] + way[1] * step];
    } else if (this._carried && event.key === 'Escape') this._letGo();
    else return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this._wishes.redraw();
  }

  /** @param {Place} place */
  _pickOrPut(place) {
    const frame = /** @type {Frame} */ (this._frame);
    if (this._carried) {
      const to = frame.toEarth(...this._carried);
      this._carried = null;
      this._wishes.moved(this.chosen, to);
    } else if (place.fixed) this._wishes.moved(this.chosen, /** @type {Pair} */ (place.at)); // told why not
    else this._carried = frame.toLocal(.../** @type {Pair} */ (place.at));
  }

  _letGo() {
    this._carried = null;
    this._wishes.redraw();
  }
}
