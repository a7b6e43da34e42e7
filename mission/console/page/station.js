// @ts-check
/**
 * One vehicle with its connections: received frames update its state, commands leave by them.
 *
 * A frame is acknowledged after it was shown, so that frames never queue up in front of the screen.
 * A hidden page acknowledges at once.
 */

import { Intents } from './intents.js';
import { HUNG_MS, Vehicle, isLive, update } from './state.js';
import { HUNG, Line, ask } from './wire.js';

/** @typedef {import('./state.js').Setup} Setup
 * @typedef {import('./state.js').Stale} Stale
 * @typedef {{t: number, level: 2 | 3 | 4, of: string, says: string}} Event
 * @typedef {{stations: Station[], chosen: Station, stale: Stale, token: string,
 *   redraw: () => void, compared: import('./compare.js').Compared}} Page */

const NOWHERE = { send: () => false, isOpen: false, close: () => {} };

export class Station {
  /** @param {Setup} setup @param {string} token @param {() => void} changed */
  constructor(setup, token, changed) {
    this.vehicle = new Vehicle(setup);
    this._token = token;
    this._changed = changed;
    this._unshown = 0; // the frame that is not acknowledged
    this.problem = ''; // of a connection, in the server's words
    const at = `vehicle=${encodeURIComponent(setup.id)}`;
    const live = isLive(this.vehicle);
    this.intents = this._intents(at, live);
    /** @type {Event[]} of a recording */
    this.happened = [];
    /** @type {import('./compare.js').Hindsight | null} */
    this.hindsight = null;
    this._hasAsked = false;
    this.frames = new Line(`/ws/frames?${at}`, token, {
      heard: (frame) => this._heard(frame),
      closed: (why) => this._closed(why),
    }, HUNG_MS);
    this.review = setup.source === 'recording'
      ? new Line(`/ws/review?${at}`, token, { heard: () => {} }) : NOWHERE;
    if (setup.source === 'recording') this._askEvents();
    else void this._askDoctor();
  }

  /** @param {string} at @param {boolean} live */
  _intents(at, live) {
    if (!live) return new Intents({ orders: NOWHERE, commands: NOWHERE }, now, wall);
    const heard = (/** @type {any} */ answer) => {
      this.intents.heard(answer);
      this._changed();
    };
    this.orders = new Line(`/ws/orders?${at}`, this._token, {
      heard, opened: () => this.intents.opened(),
    });
    this.commands = new Line(`/ws/commands?${at}`, this._token, {
      heard, closed: () => this.intents.lost(),
    });
    return new Intents({ orders: this.orders, commands: this.commands }, now, wall);
  }

  /** @param {import('./state.js').Frame} frame */
  _heard(frame) {
    this.problem = '';
    const before = this.vehicle.state['plan'];
    update(this.vehicle, frame, now());
    const on = this.vehicle.state['plan'] ?? '';
    if (on !== (before ?? '') || (frame.n === 1 && on !== (this.vehicle.plan?.digest ?? ''))) this._askPlan();
    this._unshown = frame.n;
    if (document.hidden) this.shown();
    this._changed();
  }

  /** The last frame is on the screen, or the page is hidden. */
  shown() {
    if (this._unshown) this.frames.send({ ack: this._unshown });
    this._unshown = 0;
  }

  /** @param {string} why */
  _closed(why) {
    this.problem = why === HUNG ? '' : why;
    this._unshown = 0;
    this._changed();
  }

  async _askPlan() {
    const wanted = this.vehicle.state['plan'];
    const id = encodeURIComponent(this.vehicle.setup.id);
    try {
      const plan = await ask(`/api/vehicles/${id}/plan`, this._token);
      if (wanted === this.vehicle.state['plan']) this.vehicle.plan = plan.digest ? plan : null;
    } catch {
      this.vehicle.plan = null; // the next change, or the next snapshot, asks again
    }
    if (this.vehicle.still?.digest !== this.vehicle.plan?.digest) this.vehicle.still = null;
    void this._askDoctor(); // for the vehicle that the plan names
    this._changed();
    if (this.vehicle.plan && !this.vehicle.still) void this._askStill(this.vehicle.plan.digest);
  }

  async _askDoctor() {
    const id = encodeURIComponent(this.vehicle.setup.id);
    this.vehicle.doctor = await ask(`/api/vehicles/${id}/doctor`, this._token).catch(() => []);
    this._changed();
  }

  /** Ask for the plan's track in still water; the server computes it first. @param {string} digest */
  async _askStill(digest) {
    const id = encodeURIComponent(this.vehicle.setup.id);
    const still = await ask(`/api/vehicles/${id}/planned`, this._token).catch(() => null);
    if (still?.digest === digest && digest === this.vehicle.plan?.digest) this.vehicle.still = still;
    this._changed();
  }

  /** Ask once for a recording's hindsight; for a long one it takes time. */
  async askHindsight() {
    if (this._hasAsked) return;
    this._hasAsked = true;
    const id = encodeURIComponent(this.vehicle.setup.id);
    this.hindsight = await ask(`/api/vehicles/${id}/hindsight`, this._token).catch((error) => {
      this._hasAsked = false;
      return { begin: null, wall: 0, then: [], now: [], apart: null, problem: String(error.message) };
    });
    this._changed();
  }

  async _askEvents() {
    const id = encodeURIComponent(this.vehicle.setup.id);
    this.happened = await ask(`/api/vehicles/${id}/events`, this._token).catch(() => []);
    this._changed();
  }
}

function now() {
  return performance.now();
}

function wall() {
  return Date.now() / 1000;
}
