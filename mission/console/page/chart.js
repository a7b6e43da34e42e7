// @ts-check
/**
 * The chart: a metric grid with plan, track, vehicle and its 95 % ellipse; moved by pointer or keys.
 *
 * ``layers`` draws it, ``scene`` collects what to draw.
 */

import { inksOf, sheet } from './canvas.js';
import { besides } from './compare.js';
import { mark, say } from './dom.js';
import { bearing, lasting, length, place } from './format.js';
import { between, ellipse } from './geo.js';
import { LayerBox } from './layerbox.js';
import { INK_NAMES, LAYERS, font } from './layers.js';
import { NEARER, Panning } from './panning.js';
import { frameOf, sceneOf } from './scene.js';
import { age } from './state.js';
import { View } from './view.js';
import { word } from './words.js';

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./station.js').Page} Page
 * @typedef {import('./charts.js').Charts} Charts
 * @typedef {import('./layers.js').Scene} Scene */

const EDGE = 0.3; // of the screen, from its middle: a followed vehicle stays within

export class Chart {
  /** @param {(id: string) => HTMLElement} at @param {Charts} charts @param {() => void} redraw */
  constructor(at, charts, redraw) {
    this._charts = charts;
    this._box = new LayerBox(at, charts, redraw);
    this._canvas = /** @type {HTMLCanvasElement} */ (at('chart-canvas'));
    this._place = at('chart-place');
    this._pointed = at('chart-pointer');
    this._following = at('follow');
    this._view = new View();
    this._isFollowing = true;
    this._isFitted = '';
    this._hadStill = false;
    this._scale = 0; // of the last fit; another scale was chosen by the user
    this._panning = new Panning(this._canvas, this._view, { redraw, fit: () => this._fit(),
      moved: () => {
        this._isFollowing = false;
      },
      keys: { f: () => this._follow(!this._isFollowing) } });
    /** @type {Scene | null} */
    this._scene = null;
    this._listen(at);
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle } = page.chosen;
    const drawn = sheet(this._canvas);
    if (drawn === null) return;
    Object.assign(this._view, { width: drawn.width, height: drawn.height });
    this._frame = frameOf(vehicle) ?? this._charts.frame();
    const others = page.stations.filter((s) => s !== page.chosen
      && s.vehicle.setup.id !== page.compared.other).map((s) => s.vehicle);
    this._scene = sceneOf(vehicle, this._frame, page.stale.report, now, others);
    const frame = this._frame;
    if (frame) this._scene.charts = { draw: (pen, view) => this._charts.draw(pen, view, frame) };
    Object.assign(this._scene, { beside: besides(page, frame, now) });
    this._box.show();
    this._aim(`${vehicle.setup.id} ${this._frame?.lat} ${this._frame?.lon} ${vehicle.plan?.digest}`,
      Boolean(vehicle.still));
    const inks = inksOf(INK_NAMES);
    for (const layer of LAYERS) layer(drawn.pen, this._view, this._scene, inks);
    if (!this._scene.hasPlace) this._empty(drawn.pen, inks.soft);
    mark(this._following, 'aria-pressed', String(this._isFollowing));
    this._tellPlace(page, now);
    this._tellPointer();
  }

  /** Fit all once, and again when the planned track comes or the ellipse becomes larger than the
   * chart, unless the user has moved it; after that keep the vehicle in sight.
   * @param {string} of @param {boolean} hasStill */
  _aim(of, hasStill) {
    const scene = this._scene;
    if (scene === null || !scene.hasPlace) return;
    const isOwn = !this._isFollowing || this._view.scale !== this._scale;
    const hasMore = hasStill && !this._hadStill;
    if (this._isFitted !== of || (!isOwn && (hasMore || this._view.isOutgrown(scene.here?.ellipse?.[0] ?? 0)))) {
      this._isFitted = of;
      this._view.fit(this._points(scene));
      this._scale = this._view.scale;
    }
    this._hadStill = hasStill;
    if (!this._isFollowing || scene.here === null) return;
    const [x, y] = this._view.toScreen(scene.here.at);
    const [wide, high] = [this._view.width * EDGE, this._view.height * EDGE];
    const outside = Math.abs(x - this._view.width / 2) > wide
      || Math.abs(y - this._view.height / 2) > high;
    if (outside && this._view.scale * 200 > 1) this._view.centre(scene.here.at);
  }

  /** The points that must be visible; the charts' corners if there are no others.
   * @param {Scene} scene */
  _points(scene) {
    const points = pointsOf(scene);
    return points.length || !this._frame ? points : this._charts.corners(this._frame);
  }

  /** @param {CanvasRenderingContext2D} pen @param {string} ink */
  _empty(pen, ink) {
    font(pen, 18, 600);
    pen.textAlign = 'center';
    pen.fillStyle = ink;
    pen.fillText(word('no_place'), this._view.width / 2, this._view.height / 2);
  }

  /** Show the position, its uncertainty, and the age of the last fix. @param {Page} page
   * @param {number} now */
  _tellPlace(page, now) {
    const { vehicle } = page.chosen;
    const { latitude, longitude, ellipse: around } = vehicle.state;
    const isKnown = typeof latitude === 'number';
    const since = age(vehicle, 'fix_at', now);
    const reckoned = since !== null && since > page.stale.fix;
    say(this._place, !isKnown ? (this._scene?.here ? word('unknown') : '') : [
      place(latitude, longitude),
      around ? `${word('uncertainty')} ${length(around[0])}` : '',
      reckoned ? word('reckoned', lasting(since)) : '',
    ].filter(Boolean).join(' · '));
    mark(this._place, 'data-is', this._scene?.here?.isOld ? 'old' : 'fresh');
  }

  /** Show the point under the pointer, and its distance from vehicle and home. */
  _tellPointer() {
    const scene = this._scene;
    if (this._panning.pointer === null || scene === null || !this._frame) return say(this._pointed, '');
    const at = this._view.toWorld(this._panning.pointer);
    const from = (/** @type {Pair | undefined} */ point, /** @type {string} */ name) => {
      if (point === undefined) return '';
      const way = between(point, at);
      return `${length(way.range)} ${bearing(way.bearing)} ${word(name)}`;
    };
    const depth = this._charts.depthAt(at, this._view, this._frame);
    say(this._pointed, [place(...this._frame.toEarth(...at)), depth && word('charted', depth), from(scene.here?.at, 'of_vehicle'),
      from(scene.home ?? undefined, 'of_home')].filter(Boolean).join(' · '));
  }

  // --- panning and zoom ---

  /** @param {(id: string) => HTMLElement} at */
  _listen(at) {
    const on = (/** @type {string} */ id, /** @type {() => void} */ act) =>
      at(id).addEventListener('click', () => this._panning.moved(act));
    on('zoom-in', () => this._view.zoom(NEARER));
    on('zoom-out', () => this._view.zoom(1 / NEARER));
    on('fit', () => this._fit());
    on('follow', () => this._follow(!this._isFollowing));
  }

  _fit() {
    this._isFollowing = false;
    if (this._scene) this._view.fit(this._points(this._scene));
  }

  /** @param {boolean} on */
  _follow(on) {
    this._isFollowing = on;
    if (on && this._scene?.here) this._view.centre(this._scene.here.at);
  }
}

/** The vehicle, its track and its plan; the radius only if nothing else is large.
 * @param {Scene} scene @returns {Pair[]} */
function pointsOf(scene) {
  const { here, home } = scene;
  const points = [...scene.track, ...scene.routes.flatMap((route) => route.points), ...(scene.still?.line ?? [])];
  if (home) points.push(home);
  if (here) points.push(here.at, ...(here.ellipse ? ellipse(here.at, ...here.ellipse, 8) : []));
  return points;
}
