// @ts-check
/**
 * Charts that are one picture: a scan with its corners, and a grid of depths in colours.
 *
 * The plane of the chart is linear in latitude and longitude, so a picture that is linear too is
 * placed exactly.
 */

import { length } from './format.js';

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./geo.js').Frame} Frame
 * @typedef {import('./view.js').View} View
 * @typedef {import('./charts.js').Inks} Inks
 * @typedef {CanvasRenderingContext2D} Pen
 * @typedef {[number, number, number, number, number, number]} Affine longitude of the upper left
 *   corner, its change per pixel to the right, and down; then latitude */

export class Picture {
  /** @param {CanvasImageSource} picture @param {{width: number, height: number,
   *   affine: Affine}} about */
  constructor(picture, about) {
    this._picture = picture;
    this._about = about;
  }

  /** @param {Pen} pen @param {View} view @param {Frame} frame */
  draw(pen, view, frame) {
    const { width, height, affine } = this._about;
    pen.save();
    pen.transform(...matrix(affine, width, height, (lat, lon) => view.toScreen(frame.toLocal(lat, lon))));
    pen.imageSmoothingEnabled = view.scale < 20;
    pen.drawImage(this._picture, 0, 0, width, height);
    pen.restore();
  }
}

/** The transform from pixels of the picture to the screen's. @param {Affine} affine
 * @param {number} width @param {number} height @param {(lat: number, lon: number) => Pair} place
 * @returns {[number, number, number, number, number, number]} */
export function matrix([lon, lonX, lonY, lat, latX, latY], width, height, place) {
  const [x, y] = place(lat, lon);
  const [rightX, rightY] = place(lat + latX * width, lon + lonX * width);
  const [downX, downY] = place(lat + latY * height, lon + lonY * height);
  return [(rightX - x) / width, (rightY - y) / width, (downX - x) / height, (downY - y) / height, x, y];
}

export class Depths {
  /** @param {Float32Array} depths m, rows from the north; NaN: not known
   * @param {{columns: number, rows: number, least: number, greatest: number,
   *   bounds: [number, number, number, number]}} about */
  constructor(depths, about) {
    this._depths = depths;
    this._about = about;
    this._canvas = document.createElement('canvas');
    this._painted = '';
  }

  /** @param {Pen} pen @param {View} view @param {Frame} frame @param {Inks} inks */
  draw(pen, view, frame, inks) {
    const { columns, rows, bounds: [west, south, east, north] } = this._about;
    this._paint(inks);
    /** @type {Affine} */
    const affine = [west, (east - west) / columns, 0, north, 0, (south - north) / rows];
    new Picture(this._canvas, { width: columns, height: rows, affine }).draw(pen, view, frame);
  }

  /** In the colours of the theme. @param {Inks} inks */
  _paint({ shallow, deep }) {
    const of = `${shallow} ${deep}`;
    if (of === this._painted) return;
    this._painted = of;
    const { columns, rows, least, greatest } = this._about;
    Object.assign(this._canvas, { width: columns, height: rows });
    const pen = this._canvas.getContext('2d');
    if (pen === null) return;
    const picture = pen.createImageData(columns, rows);
    const words = new Uint32Array(picture.data.buffer);
    const colours = Array.from({ length: 256 }, (_, i) => pixel(blend(shallow, deep, i / 255)));
    this._depths.forEach((depth, i) => {
      if (depth > 0) words[i] = colours[Math.round(255 * share(depth, least, greatest))] ?? 0;
    });
    pen.putImageData(picture, 0, 0);
  }

  /** The depth of the cell around the point. @param {Pair} at east, north @param {View} _
   * @param {Frame} frame */
  depthAt(at, _, frame) {
    const depth = cell(this._depths, this._about, ...frame.toEarth(...at));
    return depth === null ? '' : length(depth);
  }
}

/** @param {Float32Array} depths @param {{columns: number, rows: number,
 *   bounds: [number, number, number, number]}} about @param {number} lat @param {number} lon
 * @returns {number | null} m; null: outside, or not known */
export function cell(depths, { columns, rows, bounds: [west, south, east, north] }, lat, lon) {
  const x = Math.floor(((lon - west) / (east - west)) * columns);
  const y = Math.floor(((north - lat) / (north - south)) * rows);
  if (x < 0 || y < 0 || x >= columns || y >= rows) return null;
  const depth = depths[y * columns + x] ?? NaN;
  return Number.isNaN(depth) ? null : depth;
}

/** Use half of the colours for the shallower quarter of the depths. @param {number} depth
 * @param {number} least @param {number} greatest @returns {number} from 0 to 1 */
export function share(depth, least, greatest) {
  const from = Math.max(0, least);
  const part = greatest > from ? (depth - from) / (greatest - from) : 0;
  return Math.sqrt(Math.max(0, Math.min(1, part)));
}

/** @param {string} from @param {string} to #rrggbb @param {number} part @returns {number[]} */
export function blend(from, to, part) {
  const of = (/** @type {string} */ hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  const [a, b] = [of(from), of(to)];
  return a.map((value, i) => Math.round(value + ((b[i] ?? 0) - value) * part));
}

/** An opaque pixel in memory order. @param {number[]} rgb */
function pixel([r = 0, g = 0, b = 0]) {
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
}
