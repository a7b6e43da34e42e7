// @ts-check
/**
 * Positions in a text, converted from the server's (line and column from 1, in characters) to those
 * of a textarea (offsets in UTF-16 units).
 */

/** @typedef {readonly [number, number, number]} Span line, column, length */

/** Where each line begins. @param {string} text @returns {number[]} */
export function linesOf(text) {
  const starts = [0];
  for (let i = text.indexOf('\n'); i >= 0; i = text.indexOf('\n', i + 1)) starts.push(i + 1);
  return starts;
}

/** The line of an offset, from 1. @param {readonly number[]} starts @param {number} at */
export function lineAt(starts, at) {
  let [low, high] = [0, starts.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if ((starts[middle] ?? Infinity) <= at) low = middle;
    else high = middle;
  }
  return low + 1;
}

/** Begin and end of a span. @param {string} text @param {readonly number[]} starts @param {Span} span
 * @returns {[number, number]} */
export function rangeOf(text, starts, [line, column, length]) {
  const begin = starts[Math.max(0, Math.min(line, starts.length) - 1)] ?? 0;
  const end = (starts[line] ?? text.length + 1) - 1;
  const from = forward(text, begin, column - 1, end);
  return [from, forward(text, from, length, end)];
}

/** The offset ``count`` characters further. @param {string} text @param {number} at @param {number} count
 * @param {number} end */
function forward(text, at, count, end) {
  let to = at;
  for (let i = 0; i < count && to < end; i += 1) {
    to += (text.codePointAt(to) ?? 0) > 0xffff ? 2 : 1;
  }
  return Math.min(to, end);
}
