// @ts-check
/**
 * The operator's commands to a vehicle, and their results.
 *
 *     orders     X and W: never too old; the newest is sent again over each new connection until
 *                it is acknowledged
 *     commands   everything else: a command that cannot leave now is not sent, and marked so
 */

/**
 * @typedef {'waiting' | 'unsent' | 'sent' | 'progress' | 'acknowledged' | 'refused'
 *   | 'unanswered' | 'confirmed' | 'unconfirmed' | 'contradicted'} Fate
 * @typedef {{id: number, do: string, what: string, at: number, is: Fate, says: string,
 *   since: number, have?: number, of?: number}} Intent
 *   ``at``: s since 1970 UTC; ``since``: the page's time of the newest answer, ms
 * @typedef {{send: (message: object) => boolean}} Way
 */

export const KEPT = 50;
const OPEN = new Set(['waiting', 'sent', 'unanswered']);

export class Intents {
  /** @param {{orders: Way, commands: Way}} ways @param {() => number} now ms
   * @param {() => number} wall s since 1970 UTC */
  constructor(ways, now, wall) {
    this._ways = ways;
    this._now = now;
    this._wall = wall;
    this._id = Math.floor(wall()); // another page, or this one reloaded, has other ids
    /** @type {Intent[]} newest last */
    this.list = [];
  }

  /** X or W, at once. @param {'stop' | 'surface'} order @param {number} [moved] ms, of the finger */
  order(order, moved) {
    const made = this._make(order, order, moved);
    if (!this._leave(this._ways.orders, made, {})) made.is = 'waiting';
    return made;
  }

  /** @param {string} name @param {string} what in words @param {object} values
   * @param {number} [moved] ms, of the finger */
  command(name, what, values, moved) {
    const made = this._make(name, what, moved);
    if (!this._leave(this._ways.commands, made, values)) made.is = 'unsent';
    return made;
  }

  /** The orders' connection is open, perhaps to another server than before. */
  opened() {
    const order = this.last('stop', 'surface');
    if (order && OPEN.has(order.is)) this._leave(this._ways.orders, order, {});
  }

  /** The commands' connection is lost: the result of pending commands is unknown. */
  lost() {
    for (const intent of this.list) {
      const isOrder = intent.do === 'stop' || intent.do === 'surface';
      if (!isOrder && (intent.is === 'sent' || intent.is === 'progress')) {
        this._set(intent, 'unanswered', '');
      }
    }
  }

  /** @param {{id: number, is: Fate, says: string, have?: number, of?: number}} answer */
  heard(answer) {
    const intent = this.list.find((one) => one.id === answer.id);
    if (intent === undefined) return;
    this._set(intent, answer.is, answer.says);
    if (answer.of !== undefined) Object.assign(intent, { have: answer.have, of: answer.of });
  }

  /** The newest intent of some kinds. @param {...string} names */
  last(...names) {
    return this.list.findLast((one) => names.includes(one.do)) ?? null;
  }

  /** @param {string} name @param {string} what @param {number} [moved] @returns {Intent} */
  _make(name, what, moved) {
    const now = this._now();
    const at = this._wall() - (moved === undefined ? 0 : Math.max(0, now - moved) / 1000);
    this._id += 1;
    /** @type {Intent} */
    const made = { id: this._id, do: name, what, at, is: 'sent', says: '', since: now };
    this.list = [...this.list, made].slice(-KEPT);
    return made;
  }

  /** @param {Way} way @param {Intent} intent @param {object} values */
  _leave(way, intent, values) {
    const left = way.send({ id: intent.id, at: intent.at, do: intent.do, ...values });
    if (left) this._set(intent, 'sent', '');
    return left;
  }

  /** @param {Intent} intent @param {Fate} is @param {string} says */
  _set(intent, is, says) {
    intent.is = is;
    intent.says = says;
    intent.since = this._now();
  }
}
