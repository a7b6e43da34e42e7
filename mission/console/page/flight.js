// @ts-check
/**
 * One flight that the server is asked for: a connection that is lost, or does not open in time, is
 * opened again and asked again, until there is an answer or the server refuses it.
 */

import { HUNG, Line } from './wire.js';

/** @param {string} token @param {object} job @param {{heard: (said: any) => void,
 *   refused: (why: string) => void}} ears @returns {Line} its end is the flight's */
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
