// @ts-check
/**
 * The list of the charts: which are on, their order and opacity; files are also opened here.
 *
 * The highest layer is first.
 */

import { el, mark, say } from './dom.js';
import { word } from './words.js';

/** @typedef {import('./charts.js').Charts} Charts
 * @typedef {import('./charts.js').Layer} Layer */

const FILES = '.geojson,.json,.asc,.xyz,.csv,.mbtiles,.pmtiles,.png,.jpg,.jpeg,.webp,.pgw,.jgw,.wld';

export class LayerBox {
  /** @param {(id: string) => HTMLElement} at @param {Charts} charts @param {() => void} redraw */
  constructor(at, charts, redraw) {
    this._charts = charts;
    this._button = at('layers');
    this._root = at('chart-layers');
    this._title = el('h2');
    this._problem = el('p', { class: 'problem', role: 'alert' });
    this._list = el('ul');
    this._file = el('input', { type: 'file', multiple: true, accept: FILES, class: 'unseen', tabindex: '-1' });
    this._open = el('button', { type: 'button', onclick: () => this._file.click() });
    this._root.replaceChildren(this._title, this._problem, this._list, this._open, this._file);
    this._shown = '';
    this._button.addEventListener('click', () => {
      this._root.hidden = !this._root.hidden;
      redraw();
    });
    this._file.addEventListener('change', () => {
      void charts.open([...(this._file.files ?? [])]);
      this._file.value = '';
    });
    this._root.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') this._button.click();
    });
    this._dropped(at('chart'));
  }

  /** @param {HTMLElement} room */
  _dropped(room) {
    room.addEventListener('dragover', (event) => event.preventDefault());
    room.addEventListener('drop', (event) => {
      event.preventDefault();
      this._root.hidden = false;
      void this._charts.open([...(event.dataTransfer?.files ?? [])]);
    });
  }

  show() {
    mark(this._button, 'aria-expanded', String(!this._root.hidden));
    if (this._root.hidden) return;
    const { layers, problem } = this._charts;
    say(this._title, word('charts'));
    say(this._open, word('open_chart'));
    this._file.setAttribute('aria-label', word('open_chart'));
    say(this._problem, problem);
    const about = layers.map((l) => [l.name, l.on, l.note, l.problem]);
    const shown = JSON.stringify([about, word('charts')]);
    if (shown === this._shown) return;
    this._shown = shown;
    const focused = this._list.contains(document.activeElement)
      ? document.activeElement?.getAttribute('data-of') : null;
    const rows = layers.map((layer) => this._row(layer)).reverse();
    this._list.replaceChildren(...(rows.length ? rows : [el('li', { class: 'empty' }, word('no_charts'))]));
    const again = [...this._list.querySelectorAll('[data-of]')].find((e) => e.getAttribute('data-of') === focused);
    if (again instanceof HTMLElement) again.focus();
  }

  /** @param {Layer} layer */
  _row(layer) {
    const { name } = layer;
    const box = el('input', { type: 'checkbox', 'data-of': `on ${name}`,
      onchange: () => this._charts.look(layer, { on: box.checked }) });
    box.checked = layer.on;
    const strong = el('input', { type: 'range', min: '0', max: '1', step: '0.05', 'data-of': `opacity ${name}`,
      'aria-label': `${word('opacity')} ${name}`,
      oninput: () => this._charts.look(layer, { opacity: strong.valueAsNumber }) });
    strong.value = String(layer.opacity);
    const move = (/** @type {1 | -1} */ by, /** @type {string} */ sign, /** @type {string} */ says) =>
      el('button', { type: 'button', 'aria-label': `${says} ${name}`, title: says, 'data-of': `${by} ${name}`,
        onclick: () => this._charts.move(layer, by) }, sign);
    return el('li', {}, el('label', { class: 'point' }, box, el('span', {}, name)),
      el('span', { class: layer.problem ? 'problem' : 'note' }, layer.problem || layer.note),
      el('span', { class: 'how' }, strong, move(1, '↑', word('higher')), move(-1, '↓', word('lower'))));
  }
}
