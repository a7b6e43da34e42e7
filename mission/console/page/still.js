// @ts-check
/**
 * The track in still water of the text in work: the server computes it a short time after the last
 * change, for the newest text only.
 */

import { asked } from './flight.js';

const REST_MS = 700; // without a change of the text, before it is flown

export class StillWater {
  /** @param {() => string} token @param {(said: any) => void} found null: none */
  constructor(token, found) {
    this._token = token;
    this._found = found;
    this._timer = 0;
    /** @type {import('./wire.js').Line | null} */
    this._line = null;
  }

  /** The text has changed. */
  forget() {
    clearTimeout(this._timer);
    this._line?.close(); // ends its flight
    this._line = null;
    this._found(null);
  }

  /** @param {{text: string, source: string}} plan that passed the check */
  want(plan) {
    this.forget();
    this._found({ is: 'flown' });
    this._timer = setTimeout(() => this._ask(plan), REST_MS);
  }

  /** No vehicle would accept the text. @param {string} why */
  refuse(why) {
    this.forget();
    this._found({ is: 'refused', says: why });
  }

  /** @param {{text: string, source: string}} plan */
  _ask(plan) {
    this._line = asked(this._token(), { do: 'plan', ...plan }, {
      heard: (said) => {
        this._line?.close();
        this._line = null;
        this._found(said);
      },
      refused: () => this.forget(),
    });
  }
}
