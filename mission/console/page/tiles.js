// @ts-check
/**
 * Charts of tiles (Web Mercator): each is placed by its corners. At zoom 10 and above the error is
 * less than a fifth of a pixel.
 */

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./geo.js').Frame} Frame
 * @typedef {import('./view.js').View} View
 * @typedef {CanvasRenderingContext2D} Pen */

const DEG = Math.PI / 180;
const EQUATOR_M = 2 * Math.PI * 6378137; // circumference
const TILE_PX = 256;
const AT_ONCE = 150; // tiles in one drawing
const KEPT = 400; // pictures
const LOADING = 6;

/** The upper left corner. @param {number} z @param {number} x @param {number} y
 * @returns {Pair} latitude, longitude */
export function cornerOf(z, x, y) {
  const n = 2 ** z;
  return [Math.atan(Math.sinh(Math.PI * (1 - (2 * y) / n))) / DEG, (x / n) * 360 - 180];
}

/** Column and row, with fractions. @param {number} z @param {number} lat
 * @param {number} lon @returns {Pair} */
export function tileAt(z, lat, lon) {
  const n = 2 ** z;
  const flat = Math.asinh(Math.tan(Math.max(-85.05, Math.min(85.05, lat)) * DEG)) / Math.PI;
  return [((lon + 180) / 360) * n, ((1 - flat) / 2) * n];
}

/** The zoom whose pixels are closest to the screen's. @param {number} scale px per metre
 * @param {number} lat @param {number} least @param {number} greatest */
export function zoomFor(scale, lat, least, greatest) {
  const z = Math.round(Math.log2((EQUATOR_M * Math.cos(lat * DEG) * scale) / TILE_PX));
  return Math.max(least, Math.min(greatest, z));
}

export class Tiles {
  /** @param {{least: number, greatest: number}} about
   * @param {(z: number, x: number, y: number) => Promise<ImageBitmap | null>} load
   * @param {() => void} redraw */
  constructor(about, load, redraw) {
    this._about = about;
    this._load = load;
    this._redraw = redraw;
    /** @type {Map<string, ImageBitmap | null>} oldest first; null: there is none */
    this._kept = new Map();
    /** @type {Set<string>} */
    this._loading = new Set();
  }

  /** @param {Pen} pen @param {View} view @param {Frame} frame */
  draw(pen, view, frame) {
    const { least, greatest } = this._about;
    let z = zoomFor(view.scale, frame.lat, least, greatest);
    let seen = inSight(view, frame, z);
    while (seen.length > AT_ONCE && z > least) seen = inSight(view, frame, (z -= 1));
    for (const [x, y] of seen.slice(0, AT_ONCE)) this._tile(pen, view, frame, z, x, y);
  }

  /** Draw a tile; until it is loaded, the part of a larger one. @param {Pen} pen @param {View} view
   * @param {Frame} frame @param {number} z @param {number} x @param {number} y */
  _tile(pen, view, frame, z, x, y) {
    this._want(z, x, y);
    for (let up = 0; up <= 5 && z - up >= 0; up += 1) {
      const picture = this._picture(z - up, x >> up, y >> up);
      if (!picture) continue;
      const part = picture.width / 2 ** up;
      const [left, top] = [(x % 2 ** up) * part, (y % 2 ** up) * part];
      const [x0, y0] = screen(view, frame, cornerOf(z, x, y));
      const [x1, y1] = screen(view, frame, cornerOf(z, x + 1, y + 1));
      pen.drawImage(picture, left, top, part, part, x0, y0, x1 - x0, y1 - y0);
      return;
    }
  }

  /** @param {number} z @param {number} x @param {number} y */
  _picture(z, x, y) {
    const key = `${z}/${x}/${y}`;
    const found = this._kept.get(key);
    if (found) {
      this._kept.delete(key);
      this._kept.set(key, found);
    }
    return found;
  }

  /** @param {number} z @param {number} x @param {number} y */
  async _want(z, x, y) {
    const key = `${z}/${x}/${y}`;
    if (this._kept.has(key) || this._loading.has(key) || this._loading.size >= LOADING) return;
    this._loading.add(key);
    const found = await this._load(z, x, y).catch(() => null);
    this._loading.delete(key);
    this._kept.set(key, found);
    const [oldest] = this._kept.keys();
    if (this._kept.size > KEPT && oldest !== undefined) {
      this._kept.get(oldest)?.close();
      this._kept.delete(oldest);
    }
    this._redraw();
  }
}

/** Whole pixels: no seams. @param {View} view @param {Frame} frame @param {Pair} place
 * @returns {Pair} */
function screen(view, frame, place) {
  const [x, y] = view.toScreen(frame.toLocal(...place));
  return [Math.round(x), Math.round(y)];
}

/** Column and row of all visible tiles, the middle first. @param {View} view
 * @param {Frame} frame @param {number} z @returns {Pair[]} */
function inSight(view, frame, z) {
  const [west, north] = tileAt(z, ...frame.toEarth(...view.toWorld([0, 0])));
  const [east, south] = tileAt(z, ...frame.toEarth(...view.toWorld([view.width, view.height])));
  const last = 2 ** z - 1;
  const [x0, x1] = [Math.max(0, Math.floor(west)), Math.min(last, Math.floor(east))];
  const [y0, y1] = [Math.max(0, Math.floor(north)), Math.min(last, Math.floor(south))];
  /** @type {Pair[]} */
  const found = [];
  const most = 20 * AT_ONCE; // more than that are never needed
  for (let x = x0; x <= x1 && found.length < most; x += 1) {
    for (let y = y0; y <= y1 && found.length < most; y += 1) found.push([x, y]);
  }
  const [mx, my] = [(west + east) / 2 - 0.5, (north + south) / 2 - 0.5];
  const far = (/** @type {Pair} */ [x, y]) => Math.hypot(x - mx, y - my);
  return found.sort((a, b) => far(a) - far(b));
}
