// @ts-check
/**
 * Completion at the caret: words of the language, variables of guards, names of legs.
 *
 * The table comes from the server (``/api/words``). This module only selects the part that fits the
 * text before the caret. It never refuses anything: that is the check's task.
 */

/** @typedef {{word: string, says: string, of: string}} Word */

const SHOWN = 12;
const BEFORE = 400; // characters that are read
const NAME = /[A-Za-z_][\w-]*$/;
/** The table around the caret, by the last word that opens one. */
const TABLES = /\b(safety|assume|achieve)\b\s*:?\s*(?:\{[^{}]*|(?:\s+[\w.%/-]+)*\s*)$/;
const GUARD = /(?:\b(?:until|when|on)\b|\band\b|\bor\b|\bnot\b|\()\s*:?\s*\(?\s*$/;
const TARGET = /(?:->|\belse\b\s*:?|\bdo\b\s*:)\s*$/;

/** The word before the caret. @param {string} text @param {number} at */
export function prefixAt(text, at) {
  return NAME.exec(text.slice(Math.max(0, at - 60), at))?.[0] ?? '';
}

/** The word around the place. @param {string} text @param {number} at */
export function wordAt(text, at) {
  const rest = /^[\w-]*/.exec(text.slice(at, at + 60))?.[0] ?? '';
  return prefixAt(text, at) + rest;
}

/** Which parts of the table fit. @param {string} text @param {number} at begin of the word
 * @param {boolean} isYaml */
export function contextAt(text, at, isYaml) {
  const start = text.lastIndexOf('\n', at - 1) + 1;
  const line = text.slice(start, at);
  const before = text.slice(Math.max(0, at - BEFORE), at);
  if (line.includes('#')) return [];
  if (TARGET.test(line)) return ['name'];
  if (GUARD.test(line)) return ['guard'];
  const table = TABLES.exec(line)?.[1];
  if (table) return [table];
  if (!isYaml) return line.trim() === '' ? ['mission', 'leg'] : ['leg'];
  if (line === '') return ['mission'];
  if (/\{[^}]*\bwhen\b[^}]*,\s*$/.test(line)) return ['handler'];
  if (/\bon:\s*\n(?:.*\n)*?\s*-\s*\{?\s*$/.test(before)) return ['handler'];
  return ['leg', 'group'];
}

/** @param {readonly Word[]} words @param {readonly string[]} names of legs @param {string} text
 * @param {number} at the caret @param {boolean} isYaml @param {boolean} all also without a prefix
 * @returns {Word[]} */
export function completions(words, names, text, at, isYaml, all) {
  const prefix = prefixAt(text, at);
  if (!prefix && !all) return [];
  const parts = contextAt(text, at - prefix.length, isYaml);
  const own = parts.includes('name') ? names.map((word) => ({ word, says: '', of: 'name' })) : [];
  const fits = [...own, ...words.filter((one) => parts.includes(one.of))];
  const found = fits.filter((one) => one.word.startsWith(prefix)
    && (all || one.word !== prefix));
  return [...new Map(found.map((one) => [one.word, one])).values()].slice(0, SHOWN);
}

/** The text to insert: a YAML key with its colon, unless there is one. @param {Word} chosen
 * @param {string} text @param {number} at @param {boolean} isYaml */
export function written(chosen, text, at, isYaml) {
  const isKey = isYaml && !['guard', 'name'].includes(chosen.of);
  const rest = text.slice(at, at + 2);
  return isKey && !rest.startsWith(':') ? `${chosen.word}: ` : chosen.word;
}

/** One line of help on a word. @param {readonly Word[]} words @param {string} word */
export function helpOn(words, word) {
  const found = words.filter((one) => one.word === word);
  return [...new Set(found.map((one) => `${one.word}: ${one.says}`))].slice(0, 2).join(' · ');
}
