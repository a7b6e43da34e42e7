// @ts-check
/**
 * A chart moved by pointer, wheel and keys; objects on it may be dragged instead.
 *
 * Positions are CSS pixels of the canvas.
 */

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./view.js').View} View
 * @typedef {{drag: (to: Pair) => void, drop: (to: Pair | null) => void}} Taken
 *   ``drop`` gets null if it is cancelled
 * @typedef {{redraw: () => void, moved?: () => void, fit: () => void,
 *   take?: (at: Pair, isTouch: boolean) => Taken | null, keys?: Record<string, () => void>}} Hooks
 *   ``moved``: by the user; ``take``: the object under the finger; ``keys``: besides those that move it */

const STEP_PX = 60; // step of an arrow key
export const NEARER = 1.4;

export class Panning {
  /** @param {HTMLCanvasElement} canvas @param {View} view @param {Hooks} hooks */
  constructor(canvas, view, hooks) {
    this._canvas = canvas;
    this._view = view;
    this._hooks = hooks;
    /** @type {Map<number, Pair>} fingers on the canvas */
    this._fingers = new Map();
    /** @type {Pair | null} */
    this.pointer = null;
    /** @type {Taken | null} */
    this._taken = null;
    this._takenAt = ''; // position of the canvas then
    this._listen();
  }

  _listen() {
    const canvas = this._canvas;
    canvas.addEventListener('keydown', (event) => this._key(event));
    canvas.addEventListener('wheel', (event) => this._wheel(event), { passive: false });
    canvas.addEventListener('pointerdown', (event) => this._down(event));
    canvas.addEventListener('pointermove', (event) => this._drag(event));
    for (const name of ['pointerup', 'pointercancel', 'pointerleave']) {
      canvas.addEventListener(name, (event) => this._up(/** @type {PointerEvent} */ (event)));
    }
    new ResizeObserver(() => this._hooks.redraw()).observe(canvas);
  }

  /** @param {() => void} act */
  moved(act) {
    act();
    this._hooks.redraw();
  }

  /** @param {KeyboardEvent} event */
  _key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const name = event.shiftKey && event.key.length > 1 ? `Shift+${event.key}` : event.key;
    const far = STEP_PX;
    /** @type {Record<string, () => void>} */
    const acts = {
      ArrowLeft: () => this._pan(far, 0),
      ArrowRight: () => this._pan(-far, 0),
      ArrowUp: () => this._pan(0, far),
      ArrowDown: () => this._pan(0, -far),
      '+': () => this._view.zoom(NEARER),
      '=': () => this._view.zoom(NEARER),
      '-': () => this._view.zoom(1 / NEARER),
      0: () => this._hooks.fit(),
      ...this._hooks.keys,
    };
    const act = acts[name];
    if (act === undefined) return;
    event.preventDefault();
    this.moved(act);
  }

  /** @param {number} x @param {number} y */
  _pan(x, y) {
    this._hooks.moved?.();
    this._view.pan(x, y);
  }

  /** @param {WheelEvent} event */
  _wheel(event) {
    event.preventDefault();
    const factor = Math.exp(-event.deltaY * (event.ctrlKey ? 0.01 : 0.0015));
    this.moved(() => this._view.zoom(factor, [event.offsetX, event.offsetY]));
  }

  /** @param {PointerEvent} event */
  _down(event) {
    this._canvas.setPointerCapture(event.pointerId);
    /** @type {Pair} */
    const at = [event.offsetX, event.offsetY];
    this._fingers.set(event.pointerId, at);
    this._leave(null); // two fingers move the chart, not the object
    if (this._fingers.size === 1) this._taken = this._hooks.take?.(at, event.pointerType === 'touch') ?? null;
    this._takenAt = this._lies();
  }

  /** Position on the page, and size. */
  _lies() {
    const { x, y, width, height } = this._canvas.getBoundingClientRect();
    return `${x} ${y} ${width} ${height}`;
  }

  /** Did the page move under the finger, e.g. by an alarm? The object would land elsewhere. */
  _hasSlid() {
    return this._lies() !== this._takenAt;
  }

  /** One finger moves the chart, two zoom it. @param {PointerEvent} event */
  _drag(event) {
    /** @type {Pair} */
    const to = [event.offsetX, event.offsetY];
    this.pointer = to;
    const before = this._fingers.get(event.pointerId);
    if (before === undefined) return this._hooks.redraw();
    if (this._taken && this._hasSlid()) {
      this._fingers.clear();
      this.cancel();
      return this._hooks.redraw();
    }
    const other = [...this._fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other !== undefined) {
      const far = (/** @type {Pair} */ p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      this._view.zoom(far(to) / Math.max(1, far(before)), other);
    } else if (this._taken) this._taken.drag(to);
    else this._pan(to[0] - before[0], to[1] - before[1]);
    this._fingers.set(event.pointerId, to);
    this._hooks.redraw();
  }

  /** @param {PointerEvent} event */
  _up(event) {
    this._fingers.delete(event.pointerId);
    if (event.type === 'pointerleave' || event.pointerType === 'touch') this.pointer = null;
    const isWhole = event.type === 'pointerup' && !this._hasSlid();
    this._leave(isWhole ? [event.offsetX, event.offsetY] : null);
    this._hooks.redraw();
  }

  /** @param {Pair | null} at */
  _leave(at) {
    const taken = this._taken;
    this._taken = null;
    taken?.drop(at);
  }

  /** The dragged object goes back. */
  cancel() {
    this._leave(null);
  }
}
