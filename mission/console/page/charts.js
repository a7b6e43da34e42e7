// @ts-check
/**
 * The user's charts under the vehicle: loaded once and drawn in their order. The server stores how
 * they are shown.
 *
 * An <img> could not send the token, so pictures are loaded by fetch.
 */

import { inksOf } from './canvas.js';
import { Frame } from './geo.js';
import { Depths, Picture, blend, share } from './pictures.js';
import { Shapes } from './shapes.js';
import { Tiles } from './tiles.js';
import { ask, load, want } from './wire.js';

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./view.js').View} View
 * @typedef {CanvasRenderingContext2D} Pen
 * @typedef {{shape: string, shallow: string, deep: string, tint: string,
 *   depth: (depth: number, least: number, greatest: number) => string}} Inks
 * @typedef {{draw: (pen: Pen, view: View, frame: Frame, inks: Inks) => void,
 *   depthAt?: (at: Pair, view: View, frame: Frame) => string}} Drawn
 * @typedef {{name: string, kind: 'shapes' | 'picture' | 'tiles' | 'depths', note: string,
 *   bounds: [number, number, number, number], on: boolean, opacity: number,
 *   off_m?: number}} About off_m: its possible position error
 * @typedef {About & {drawn: Drawn | null, problem: string}} Layer */

const OFF_PX = 60; // a chart whose error is larger on the screen is not shown
const KEEP_MS = 500; // a moved slider is sent once
const NAMES = { shape: 'ink', shallow: 'shallow', deep: 'deep', tint: 'tint' };
const PLACES = /\.([a-z]{2,4}w|wld|json)$/i; // files with the position of a picture: sent before it

export class Charts {
  /** @param {string} token @param {() => void} redraw */
  constructor(token, redraw) {
    this._token = token;
    this._redraw = redraw;
    /** @type {Layer[]} lowest first */
    this.layers = [];
    this.problem = '';
    this._timer = 0;
    /** @type {Frame | null} */
    this._frame = null;
    void this._ask();
  }

  async _ask() {
    /** @type {About[]} */
    const found = await ask('/api/charts', this._token).catch(() => this.layers);
    const known = new Map(this.layers.map((layer) => [layer.name, layer]));
    this.layers = found.map((about) => known.get(about.name) ?? { ...about, drawn: null, problem: '' });
    for (const layer of this.layers) if (!layer.drawn) void this._load(layer);
    this._redraw();
  }

  /** @param {Layer} layer */
  async _load(layer) {
    try {
      layer.drawn = await this._drawn(layer, `/api/charts/${encodeURIComponent(layer.name)}`);
    } catch (error) {
      layer.problem = String(error instanceof Error ? error.message : error);
    }
    this._redraw();
  }

  /** @param {any} about @param {string} path @returns {Promise<Drawn>} */
  async _drawn(about, path) {
    if (about.kind === 'tiles') {
      const tiled = (/** @type {number[]} */ ...tile) => this._picture([path, ...tile].join('/'));
      return new Tiles(about, tiled, this._redraw);
    }
    if (about.kind === 'picture') {
      const picture = await this._picture(path);
      if (picture === null) throw new Error('no picture');
      return new Picture(picture, about);
    }
    const answer = await load(path, this._token);
    if (about.kind === 'depths') return new Depths(new Float32Array(await answer.arrayBuffer()), about);
    return new Shapes(await answer.json());
  }

  /** @param {string} path @returns {Promise<ImageBitmap | null>} null: there is none */
  async _picture(path) {
    const answer = await load(path, this._token);
    return answer.status === 204 ? null : createImageBitmap(await answer.blob());
  }

  // --- drawing ---

  /** The plane of the chart while no vehicle has a position. @returns {Frame | null} */
  frame() {
    const first = this.layers.find((layer) => !layer.off_m);
    if (this._frame === null && first !== undefined) {
      const [west, south, east, north] = first.bounds;
      this._frame = new Frame((south + north) / 2, (west + east) / 2);
    }
    return this._frame;
  }

  /** The corners of all layers that are on, without background. @param {Frame} frame @returns {Pair[]} */
  corners(frame) {
    const own = this.layers.filter((layer) => layer.on && !layer.off_m);
    return own.flatMap(({ bounds: [west, south, east, north] }) =>
      [frame.toLocal(south, west), frame.toLocal(north, east)]);
  }

  /** @param {Pen} pen @param {View} view @param {Frame} frame */
  draw(pen, view, frame) {
    const inks = { ...inksOf(NAMES),
      depth: (/** @type {number} */ depth, /** @type {number} */ least, /** @type {number} */ greatest) =>
        `rgb(${blend(inks.shallow, inks.deep, share(depth, least, greatest)).join(' ')})` };
    const last = this.layers.findLast((one) => one.on && ['picture', 'tiles'].includes(one.kind));
    for (const layer of this.layers) {
      if (!layer.on || layer.drawn === null || (layer.off_m ?? 0) * view.scale > OFF_PX) continue;
      pen.save();
      pen.globalAlpha = layer.opacity;
      layer.drawn.draw(pen, view, frame, inks);
      pen.restore();
      if (layer === last) tinted(pen, view, inks.tint);
    }
  }

  /** Of the highest layer that knows a depth, else ''. @param {Pair} at east, north @param {View} view
   * @param {Frame} frame */
  depthAt(at, view, frame) {
    for (const layer of this.layers.filter((one) => one.on).reverse()) {
      const depth = layer.drawn?.depthAt?.(at, view, frame);
      if (depth) return depth;
    }
    return '';
  }

  // --- changes by the user ---

  /** @param {Layer} layer @param {Partial<About>} look */
  look(layer, look) {
    Object.assign(layer, look);
    this._keep();
  }

  /** @param {Layer} layer @param {1 | -1} by up or down */
  move(layer, by) {
    const from = this.layers.indexOf(layer);
    const to = from + by;
    if (to < 0 || to >= this.layers.length) return;
    this.layers.splice(from, 1);
    this.layers.splice(to, 0, layer);
    this._keep();
  }

  _keep() {
    this._redraw();
    clearTimeout(this._timer);
    this._timer = setTimeout(() => {
      const looks = this.layers.map(({ name, on, opacity }) => ({ name, on, opacity }));
      void ask('/api/charts', this._token, looks).catch(() => {});
    }, KEEP_MS);
  }

  /** @param {readonly File[]} files */
  async open(files) {
    this.problem = '';
    const first = (/** @type {File} */ file) => Number(!PLACES.test(file.name));
    for (const file of [...files].sort((a, b) => first(a) - first(b))) {
      try {
        await this._bring(file);
      } catch (error) {
        this.problem = String(error instanceof Error ? error.message : error);
      }
    }
    await this._ask();
  }

  /** @param {File} file */
  async _bring(file) {
    const said = await want(`/api/charts/${encodeURIComponent(file.name)}`, this._token, file);
    this.layers = this.layers.filter((layer) => layer.name !== said.name);
  }
}

/** Tint it, so that a bright scan does not dazzle at night. @param {Pen} pen @param {View} view
 * @param {string} tint */
function tinted(pen, view, tint) {
  pen.save();
  pen.globalCompositeOperation = 'multiply';
  pen.fillStyle = tint;
  pen.fillRect(0, 0, view.width, view.height);
  pen.restore();
}
