// @ts-check
/**
 * One flight requested from the server. If the connection is lost, or does not open in time, it is
 * opened again and the request repeated, until the server answers or refuses it.
 */

import { HUNG, Line } from './wire.js';

/** @param {string} token @param {object} job @param {{heard: (said: any) => void,
 *   refused: (why: string) => void}} ears @returns {Line} closing it ends the flight */
export function asked(token, job, ears) {
  const line = new Line('/ws/ghost?', token, {
    opened: () => line.send(job),
    heard: ears.heard,
    closed: (why) => {
      if (why !== '' && why !== HUNG) ears.refused(why);
    },
  });
  return line;
}
