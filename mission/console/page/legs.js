// @ts-check
/**
 * The mission's graph, with the active leg and its groups highlighted.
 *
 * The picture is parsed as XML and rebuilt from the few elements and attributes that drawings have:
 * nothing in it can run or load anything. Its colours become those of the theme.
 */

import { el, mark, say } from './dom.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const LARGER = 1.5; // magnification, if there is space
const SVG = 'http://www.w3.org/2000/svg';
const ELEMENTS = new Set(['svg', 'g', 'rect', 'path', 'text', 'tspan', 'line', 'circle', 'ellipse',
  'polygon', 'polyline', 'title', 'desc']);
const ATTRIBUTES = new Set(['width', 'height', 'viewBox', 'x', 'y', 'x1', 'y1', 'x2', 'y2', 'cx', 'cy',
  'r', 'rx', 'ry', 'd', 'points', 'transform', 'fill', 'stroke', 'stroke-width', 'stroke-dasharray',
  'font-size', 'font-weight', 'font-style', 'font-family', 'text-anchor', 'opacity', 'data-path']);

/** Colours of the drawing, by their meaning here. @type {Readonly<Record<string, string>>} */
const INKS = {
  '#10243e': 'ink', '#33475b': 'ink', '#64748b': 'soft', '#475569': 'soft', '#7891ad': 'soft',
  '#2563a8': 'accent', '#b45309': 'careful', '#a16207': 'careful', '#b91c1c': 'bad',
  '#059669': 'good', '#8fb0d3': 'control', '#f0b4b4': 'bad', '#ffffff': 'panel',
  '#eef4fb': 'panel', '#dfeaf7': 'raised', '#cfdff2': 'raised', '#bed4ec': 'raised',
  '#e2e8f0': 'edge', '#f8fafc': 'panel', '#fef2f2': 'panel', '#fefce8': 'panel',
  '#fff7f7': 'panel', '#ecfdf5': 'panel', '#d1fae5': 'raised',
};

export class Legs {
  /** @param {HTMLElement} root */
  constructor(root) {
    this._root = root;
    this._says = el('p', { class: 'empty' });
    this._shown = '';
    this._leg = '';
  }

  /** @param {Page} page */
  show(page) {
    const { vehicle } = page.chosen;
    const { plan, state } = vehicle;
    const svg = plan?.svg ?? '';
    if (svg !== this._shown || this._root.childElementCount === 0) this._draw(svg);
    if (!svg) say(this._says, plan?.problem || word(state['mission'] ? 'no_picture' : 'no_mission'));
    if (this._leg !== (state['leg'] ?? '')) this._light(state['leg'] ?? '');
  }

  /** @param {string} svg */
  _draw(svg) {
    this._shown = svg;
    this._leg = '';
    const drawing = svg ? picture(svg) : null;
    this._root.replaceChildren(drawing ?? this._says);
  }

  /** @param {string} leg its path */
  _light(leg) {
    this._leg = leg;
    const parts = [...this._root.querySelectorAll('[data-path]')];
    for (const part of parts) {
      const path = part.getAttribute('data-path') ?? '';
      mark(part, 'data-active', leg === path || leg.startsWith(`${path}/`) ? '' : null);
    }
    parts.findLast((p) => p.getAttribute('data-path') === leg)
      ?.scrollIntoView({ block: 'nearest', inline: 'nearest' });
  }
}

/** @param {string} text @returns {Element | null} null: not a drawing */
export function picture(text) {
  const read = new DOMParser().parseFromString(text, 'image/svg+xml').documentElement;
  if (read.localName !== 'svg' || read.namespaceURI !== SVG) return null;
  const made = /** @type {SVGElement} */ (copy(read));
  const width = parseFloat(read.getAttribute('width') ?? '') || 600;
  made.style.width = `max(${width}px, min(100%, ${width * LARGER}px))`;
  return made;
}

/** @param {Element} from @returns {Element} */
function copy(from) {
  const made = document.createElementNS(SVG, from.localName);
  for (const { name, value } of from.attributes) if (ATTRIBUTES.has(name)) put(made, name, value);
  for (const child of from.childNodes) {
    if (child instanceof Element) {
      if (child.namespaceURI === SVG && ELEMENTS.has(child.localName)) made.append(copy(child));
    } else if (child.nodeType === Node.TEXT_NODE) made.append(child.textContent ?? '');
  }
  return made;
}

/** @param {Element} made @param {string} name @param {string} value */
function put(made, name, value) {
  const isColour = name === 'fill' || name === 'stroke';
  if (isColour && value.includes('(')) return; // url(...)
  made.setAttribute(name, value);
  const ink = isColour ? INKS[value.toLowerCase()] : undefined;
  if (ink) /** @type {SVGElement} */ (made).style.setProperty(name, `var(--${ink})`);
}
