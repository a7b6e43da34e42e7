// @ts-check
/**
 * Connections to the console's server: each reopens itself, and a hanging one is dropped.
 *
 * Nothing waits here to be sent: if a message cannot leave now, the caller may repeat it.
 */

export const AGAIN_MS = 1000;
const OPENING_MS = 3000;
export const HUNG = 'hung'; // reason for dropping a connection without messages in time
const REFUSED = 1008; // the server's code for a malformed message

/** @typedef {{opened?: () => void, closed?: (why: string) => void,
 *   heard: (message: any) => void}} Ears */

export class Line {
  /** @param {string} path with its query @param {string} token @param {Ears} ears
   * @param {number} [hung] ms without a message after which it is dropped; 0: never */
  constructor(path, token, ears, hung = 0) {
    this._path = path;
    this._token = token;
    this._ears = ears;
    this._hung = hung;
    this._over = false;
    /** @type {WebSocket | null} */
    this._socket = null;
    this._timer = 0;
    this._open();
  }

  get isOpen() {
    return this._socket?.readyState === WebSocket.OPEN;
  }

  /** Return whether it was sent. @param {object} message */
  send(message) {
    if (!this.isOpen) return false;
    this._socket?.send(JSON.stringify(message));
    return true;
  }

  /** A connection that is being opened is closed after that; earlier, the browser reports an error. */
  close() {
    this._over = true;
    clearTimeout(this._timer);
    const socket = this._socket;
    if (socket?.readyState !== WebSocket.CONNECTING) return this._leave();
    this._socket = socket.onmessage = socket.onclose = null;
    socket.onopen = () => socket.close();
  }

  _open() {
    const url = new URL(this._path, location.href);
    url.protocol = url.protocol.replace('http', 'ws');
    const socket = new WebSocket(url, ['auvmission', `token.${this._token}`]);
    this._socket = socket;
    this._expect(OPENING_MS);
    socket.onopen = () => {
      this._expect(this._hung);
      this._ears.opened?.();
    };
    socket.onmessage = (event) => {
      this._expect(this._hung);
      this._ears.heard(JSON.parse(event.data));
    };
    socket.onclose = (event) => this._gone(event.code === REFUSED ? event.reason : '');
  }

  /** Expect a message within ``ms``. @param {number} ms */
  _expect(ms) {
    clearTimeout(this._timer);
    if (ms > 0) this._timer = setTimeout(() => this._gone(HUNG), ms);
  }

  /** Report the loss. One that is still being opened is waited for: else the browser reports an error.
   * @param {string} why */
  _gone(why) {
    const opening = why === HUNG && this._socket?.readyState === WebSocket.CONNECTING;
    if (!opening) this._leave();
    this._ears.closed?.(why);
    clearTimeout(this._timer);
    if (!opening && !this._over) this._timer = setTimeout(() => this._open(), AGAIN_MS);
  }

  /** Close it without waiting for the other end, which may never answer. */
  _leave() {
    const socket = this._socket;
    if (socket === null) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    this._socket = null;
  }
}

/** Move the token from the address into this tab's storage. @returns {string} "": none */
export function takeToken() {
  const given = location.hash.slice(1);
  if (given) {
    sessionStorage.setItem('token', given);
    history.replaceState(null, '', location.pathname + location.search);
  }
  return given || (sessionStorage.getItem('token') ?? '');
}

export class Refused extends Error {
  /** @param {number} status @param {string} says */
  constructor(status, says) {
    super(says);
    this.status = status;
  }
}

/** Load data other than JSON: a picture, depths. @param {string} path @param {string} token
 * @returns {Promise<Response>} Raises Refused. */
export async function load(path, token) {
  const answer = await fetch(path, { headers: { Authorization: `Bearer ${token}` } });
  if (!answer.ok) throw new Refused(answer.status, answer.statusText);
  return answer;
}

/** @param {string} path @param {string} token @param {object} [body] posted; a file as it is
 * @returns {Promise<any>} Raises Refused, with what the server says. */
export async function ask(path, token, body) {
  const headers = new Headers({ Authorization: `Bearer ${token}` });
  const isFile = body instanceof Blob;
  if (body && !isFile) headers.set('Content-Type', 'application/json');
  const answer = await fetch(path, body === undefined ? { headers }
    : { method: 'POST', headers, body: isFile ? body : JSON.stringify(body) });
  const said = await answer.json().catch(() => null);
  if (!answer.ok) throw new Refused(answer.status, said?.says ?? answer.statusText);
  return said;
}

/** The same for requests that may be refused with words, which is no fault. @param {string} path
 * @param {string} token @param {object} body @returns {Promise<any>} Raises Refused. */
export async function want(path, token, body) {
  const said = await ask(path, token, body);
  if (typeof said.says === 'string') throw new Refused(200, said.says);
  return said;
}
