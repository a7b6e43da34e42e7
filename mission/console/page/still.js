// @ts-check
/**
 * The track in still water of the text that is being written: flown by the server, a while after
 * the last change, the newest alone.
 */

import { asked } from './flight.js';

const REST_MS = 700; // of the text, before it is flown

export class StillWater {
  /** @param {() => string} token @param {(said: any) => void} found null: there is none */
  constructor(token, found) {
    this._token = token;
    this._found = found;
    this._timer = 0;
    /** @type {import('./wire.js').Line | null} */
    this._line = null;
  }

  /** The text is another. */
  forget() {
    clearTimeout(this._timer);
    this._line?.close(); // ends what is flown for it
    this._line = null;
    this._found(null);
  }

  /** @param {{text: string, source: string}} plan that is proved */
  want(plan) {
    this.forget();
    this._found({ is: 'flown' });
    this._timer = setTimeout(() => this._ask(plan), REST_MS);
  }

  /** No vehicle would take the text. @param {string} why */
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
