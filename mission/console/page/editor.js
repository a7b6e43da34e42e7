// @ts-check
/**
 * The text editor: a plain text area with line numbers, underlined errors, and completion. The marks
 * under the text are drawn separately and are never HTML.
 *
 * Every change, typed or not, is a step of one history.
 */

import { completions, helpOn, prefixAt, wordAt, written } from './completing.js';
import { el, mark, say } from './dom.js';
import { History } from './history.js';
import { lineAt, linesOf, rangeOf } from './texts.js';
import { word } from './words.js';

/** @typedef {import('./texts.js').Span} Span
 * @typedef {import('./completing.js').Word} Word
 * @typedef {{line: number, column: number, length: number, message: string, hint: string}} Fault */

const TAB = 8; // columns
const LINE_PX = 22; // as in the style sheet

export class Editor {
  /** @type {readonly Word[]} */
  words = [];
  /** @type {readonly string[]} */
  names = [];
  isYaml = true;

  /** @param {() => void} changed @param {() => void} moved the caret */
  constructor(changed, moved) {
    this._changed = changed;
    this._caretMoved = moved;
    this.area = el('textarea', { class: 'code', wrap: 'off', spellcheck: 'false',
      autocapitalize: 'off', autocomplete: 'off', 'aria-autocomplete': 'list',
      'aria-controls': 'completions', 'aria-describedby': 'editor-says' });
    this._numbers = el('div', { class: 'numbers', 'aria-hidden': 'true' });
    this._marks = el('div', { class: 'marks', 'aria-hidden': 'true' });
    this._list = el('ul', { id: 'completions', role: 'listbox', class: 'completions', hidden: true });
    this._says = el('p', { id: 'editor-says', class: 'editor-says', role: 'status' });
    this._tip = el('div', { class: 'tip', role: 'tooltip', hidden: true });
    this.root = el('div', { class: 'editor' }, el('div', { class: 'paper' }, this._numbers,
      el('div', { class: 'sheet' }, this._marks, this.area, this._list, this._tip)), this._says);
    this.history = new History({ text: '', at: 0 });
    /** @type {readonly Fault[]} */
    this._faults = [];
    /** @type {Span[]} of the place chosen on the chart */
    this._chosen = [];
    /** @type {Word[]} */
    this._offered = [];
    this._pick = -1;
    this._starts = [0];
    this._pen = document.createElement('canvas').getContext('2d');
    this._listen();
  }

  get text() {
    return this.area.value;
  }

  /** Replace the text in one step; the caret stays where it was, or goes to ``at``.
   * @param {string} text @param {number} [at]
   * @param {import('./history.js').Origin} [of] if it has another */
  put(text, at, of) {
    const caret = Math.min(at ?? this.area.selectionStart, text.length);
    this.history.add(of ? { text, at: caret, of } : { text, at: caret });
    this._show(this.history.now);
  }

  undo() {
    this._show(this.history.undo());
  }

  redo() {
    this._show(this.history.redo());
  }

  /** @param {import('./history.js').Step} step */
  _show(step) {
    const { scrollTop, scrollLeft } = this.area;
    if (this.area.value !== step.text) this.area.value = step.text;
    this.area.setSelectionRange(step.at, step.at);
    Object.assign(this.area, { scrollTop, scrollLeft });
    this._offer([]);
    this._textChanged();
  }

  /** Show the check's findings in this text. @param {readonly Fault[]} faults */
  judge(faults) {
    const last = this._starts.length; // something missing is marked after it
    this._faults = faults.map((one) => (one.line > last
      ? { ...one, line: last, column: this._lineText(last).length + 1 } : one));
    this._drawMarks();
    this._tell();
  }

  /** Mark the numbers of the chosen place. @param {Span[]} spans @param {boolean} [reveal] */
  choose(spans, reveal = false) {
    this._chosen = spans;
    const first = spans[0];
    if (reveal && first) this.reveal(first);
    this._drawMarks();
  }

  /** @param {Span} span */
  reveal(span) {
    const [begin, end] = rangeOf(this.text, this._starts, span);
    this.area.setSelectionRange(begin, end);
    const top = (span[0] - 1) * LINE_PX;
    const { scrollTop, clientHeight } = this.area;
    if (top < scrollTop || top > scrollTop + clientHeight - 2 * LINE_PX) {
      this.area.scrollTop = Math.max(0, top - clientHeight / 2);
    }
  }

  /** The caret's line, from 1. */
  get line() {
    return lineAt(this._starts, this.area.selectionStart);
  }

  show() {
    mark(this.area, 'aria-label', word('plan_text'));
    mark(this.area, 'placeholder', word('plan_begin'));
    this._drawMarks();
  }

  // --- events ---

  _listen() {
    const area = this.area;
    area.addEventListener('input', (event) => this._typed(/** @type {InputEvent} */ (event)));
    area.addEventListener('beforeinput', (event) => {
      const type = /** @type {InputEvent} */ (event).inputType;
      if (type !== 'historyUndo' && type !== 'historyRedo') return;
      event.preventDefault();
      if (type === 'historyUndo') this.undo();
      else this.redo();
    });
    area.addEventListener('keydown', (event) => this._key(event));
    area.addEventListener('scroll', () => this._drawMarks());
    area.addEventListener('blur', () => this._offer([]));
    area.addEventListener('mousemove', (event) => this._point(event));
    area.addEventListener('mouseleave', () => {
      this._tip.hidden = true;
    });
    for (const name of ['keyup', 'click', 'focus']) area.addEventListener(name, () => this._caret());
    new ResizeObserver(() => this._drawMarks()).observe(area);
  }

  /** @param {InputEvent} event */
  _typed(event) {
    const isWord = event.inputType === 'insertText' || event.inputType === 'deleteContentBackward';
    this.history.add({ text: this.text, at: this.area.selectionStart },
      isWord ? performance.now() : undefined);
    this._textChanged();
    if (event.inputType === 'insertText' && !event.isComposing) this._complete(false);
    else this._offer([]);
  }

  _textChanged() {
    this._tip.hidden = true;
    this._starts = linesOf(this.text);
    this._changed();
    this._caret();
    this._drawMarks();
  }

  _caret() {
    this._tell();
    this._caretMoved();
  }

  /** @param {KeyboardEvent} event */
  _key(event) {
    const acts = this._acts(event);
    const plain = !event.ctrlKey && !event.altKey && !event.metaKey;
    const act = (event.ctrlKey && event.key === ' ') || plain ? acts[event.key] : undefined;
    if (act === undefined || event.isComposing) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  }

  /** @param {KeyboardEvent} event @returns {Record<string, () => void>} */
  _acts(event) {
    /** @type {Record<string, () => void>} */
    const acts = event.ctrlKey ? { ' ': () => this._complete(true) } : {};
    if (this._offered.length === 0) {
      if (event.key === 'Enter' && !event.ctrlKey) acts['Enter'] = () => this._break();
      return acts;
    }
    const step = (/** @type {number} */ by) => () => {
      const count = this._offered.length;
      this._pick = (this._pick + by + count) % count;
      this._drawOffered();
    };
    const take = () => this._take(this._offered[Math.max(0, this._pick)]);
    Object.assign(acts, { ArrowDown: step(1), ArrowUp: step(-1), Tab: take,
      Escape: () => this._offer([]) });
    acts['Enter'] = this._pick >= 0 ? take : () => this._break();
    return acts;
  }

  /** A new line with the same indent. */
  _break() {
    const at = this.area.selectionStart;
    const start = this._starts[lineAt(this._starts, at) - 1] ?? 0;
    const lead = /^[ \t]*/.exec(this.text.slice(start, at))?.[0] ?? '';
    this._insert(at, this.area.selectionEnd, `\n${lead}`);
  }

  /** @param {number} begin @param {number} end @param {string} text */
  _insert(begin, end, text) {
    this.put(this.text.slice(0, begin) + text + this.text.slice(end), begin + text.length);
  }

  // --- completion ---

  /** @param {boolean} all */
  _complete(all) {
    const at = this.area.selectionStart;
    this._offer(completions(this.words, this.names, this.text, at, this.isYaml, all));
    if (all && this._offered.length) {
      this._pick = 0;
      this._drawOffered();
    }
  }

  /** @param {Word[]} words */
  _offer(words) {
    this._offered = words;
    this._pick = -1;
    this._drawOffered();
  }

  _drawOffered() {
    const list = this._list;
    list.hidden = this._offered.length === 0;
    list.replaceChildren(...this._offered.map((one, i) => el('li', { role: 'option', id: `offer-${i}`,
      'aria-selected': String(i === this._pick),
      onpointerdown: (/** @type {Event} */ event) => {
        event.preventDefault();
        this._take(one);
      } }, el('b', {}, one.word), el('span', {}, one.says))));
    mark(this.area, 'aria-activedescendant', this._pick >= 0 ? `offer-${this._pick}` : null);
    if (list.hidden) return;
    const [x, y] = this._spot(this.area.selectionStart);
    const below = y + LINE_PX;
    const fits = below + list.offsetHeight < this.area.clientHeight || y < list.offsetHeight;
    list.style.left = `${Math.max(0, Math.min(x, this.area.clientWidth - list.offsetWidth - 4))}px`;
    list.style.top = `${fits ? below : y - list.offsetHeight}px`;
    list.children[Math.max(0, this._pick)]?.scrollIntoView({ block: 'nearest' });
  }

  /** @param {Word | undefined} chosen */
  _take(chosen) {
    if (chosen === undefined) return;
    const at = this.area.selectionStart;
    const begin = at - prefixAt(this.text, at).length;
    this._insert(begin, at, written(chosen, this.text, at, this.isYaml));
    this.area.focus();
  }

  // --- help ---

  /** Help on the line at the caret, else on the word. */
  _tell() {
    const fault = this._faults.find((one) => one.line === this.line);
    say(this._says, fault ? said(fault) : helpOn(this.words, wordAt(this.text, this.area.selectionStart)));
    mark(this._says, 'data-level', fault ? 'bad' : null);
  }

  /** @param {MouseEvent} event */
  _point(event) {
    const top = event.offsetY + this.area.scrollTop - 8;
    const line = Math.floor(top / LINE_PX) + 1;
    const begin = this._starts[line - 1];
    const x = event.offsetX + this.area.scrollLeft - 8;
    const text = begin === undefined ? '' : this._lineText(line);
    const at = this._columnAt(text, x);
    const fault = this._faults.find((one) => one.line === line && at >= one.column - 2
      && at <= one.column + one.length);
    const help = fault ? said(fault) : at < text.length ? helpOn(this.words, wordAt(text, at)) : '';
    this._tip.hidden = help === '';
    say(this._tip, help);
    if (!help) return;
    const left = Math.min(event.offsetX, this.area.clientWidth - this._tip.offsetWidth - 8);
    this._tip.style.left = `${Math.max(0, left)}px`;
    this._tip.style.top = `${event.offsetY + 20}px`;
  }

  // --- drawing ---

  _drawMarks() {
    const { scrollTop, scrollLeft, clientHeight } = this.area;
    if (!clientHeight) return;
    const first = Math.floor(scrollTop / LINE_PX) + 1;
    const last = Math.min(this._starts.length, first + Math.ceil(clientHeight / LINE_PX) + 1);
    const wrong = new Set(this._faults.map((fault) => fault.line));
    const rows = Array.from({ length: Math.max(0, last - first + 1) }, (_, i) =>
      el('span', wrong.has(first + i) ? { 'data-wrong': '' } : {}, String(first + i)));
    this._numbers.replaceChildren(...rows);
    this._numbers.style.top = `${8 + (first - 1) * LINE_PX - scrollTop}px`;
    const inSight = (/** @type {number} */ line) => line >= first && line <= last;
    const marks = [
      ...this._chosen.filter((span) => inSight(span[0])).map((span) => this._mark(span, 'place')),
      ...this._faults.filter((fault) => inSight(fault.line)).map((fault) =>
        this._mark([fault.line, fault.column, fault.length], 'wrong')),
    ];
    this._marks.replaceChildren(...marks);
    this._marks.style.transform = `translate(${-scrollLeft}px, ${-scrollTop}px)`;
  }

  /** @param {Span} span @param {string} of */
  _mark(span, of) {
    const [begin, end] = rangeOf(this.text, this._starts, span);
    const start = this._starts[span[0] - 1] ?? 0;
    const left = this._width(this.text.slice(start, begin));
    const width = this._width(this.text.slice(start, Math.max(end, begin + 1))) - left;
    const made = el('div', { class: of });
    Object.assign(made.style, { left: `${8 + left}px`, width: `${Math.max(width, 8)}px`,
      top: `${8 + (span[0] - 1) * LINE_PX}px` });
    return made;
  }

  /** @param {number} line */
  _lineText(line) {
    const begin = this._starts[line - 1] ?? 0;
    return this.text.slice(begin, (this._starts[line] ?? this.text.length + 1) - 1);
  }

  /** Width in px of a text at the begin of a line. @param {string} text */
  _width(text) {
    const pen = this._pen;
    if (pen === null) return 0;
    const style = getComputedStyle(this.area);
    pen.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
    const one = pen.measureText('0').width;
    let column = 0;
    let width = 0;
    for (const part of text.split(/(\t)/)) {
      if (part === '\t') {
        const to = TAB * (Math.floor(column / TAB) + 1);
        width += (to - column) * one;
        column = to;
      } else {
        column += part.length;
        width += pen.measureText(part).width;
      }
    }
    return width;
  }

  /** @param {string} text @param {number} x px */
  _columnAt(text, x) {
    const guess = Math.max(0, Math.floor(x / Math.max(1, this._width('0'))));
    return Math.min(guess, text.length);
  }

  /** The position of an offset in the area. @param {number} at @returns {[number, number]} px */
  _spot(at) {
    const line = lineAt(this._starts, at);
    const start = this._starts[line - 1] ?? 0;
    return [8 + this._width(this.text.slice(start, at)) - this.area.scrollLeft,
      8 + (line - 1) * LINE_PX - this.area.scrollTop];
  }
}

/** @param {Fault} fault */
function said(fault) {
  return fault.hint ? `${fault.message} — ${fault.hint}` : fault.message;
}
