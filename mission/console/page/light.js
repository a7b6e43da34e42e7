// @ts-check
/**
 * Theme and language, stored on this computer.
 */

import { setLanguage, word } from './words.js';

/** @typedef {import('./words.js').Language} Language */

const THEMES = ['dark', 'sun', 'red'];
const LANGUAGES = /** @type {const} */ ({ en: 'en', zh: 'zh-Hans' });

/** Write the page's own texts in the chosen language. */
export function translate() {
  for (const at of document.querySelectorAll('[data-word]')) {
    at.textContent = word(at.getAttribute('data-word') ?? '');
  }
  for (const at of document.querySelectorAll('[data-label]')) {
    const text = word(at.getAttribute('data-label') ?? '');
    at.setAttribute('aria-label', text);
    if (at instanceof HTMLButtonElement) at.title = text;
  }
}

/** @param {HTMLElement} theme @param {HTMLElement} language @param {() => void} redraw */
export function keepLight(theme, language, redraw) {
  if (!(theme instanceof HTMLSelectElement)) throw new TypeError('no choice of a light');
  const light = (/** @type {string} */ name) => {
    document.documentElement.dataset['theme'] = theme.value = THEMES.includes(name) ? name : 'dark';
    localStorage.setItem('theme', theme.value);
    redraw();
  };
  const speak = (/** @type {Language} */ name) => {
    setLanguage(name);
    document.documentElement.lang = LANGUAGES[name];
    localStorage.setItem('language', name);
    translate();
    redraw();
  };
  theme.addEventListener('change', () => light(theme.value));
  language.addEventListener('click', () =>
    speak(document.documentElement.lang === 'en' ? 'zh' : 'en'));
  const kept = localStorage.getItem('language');
  speak(kept === 'zh' || (kept === null && navigator.language.startsWith('zh')) ? 'zh' : 'en');
  light(localStorage.getItem('theme') ?? 'dark');
}
