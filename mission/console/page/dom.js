// @ts-check
/**
 * Elements without HTML in strings: texts of vehicles and missions always stay text.
 */

/** @typedef {Node | string | null | undefined} Child */

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string | boolean | ((event: any) => void)>} [has] attributes;
 *   ``onNAME``: a listener
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function el(tag, has = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(has)) {
    if (typeof value === 'function') made.addEventListener(name.slice(2), value);
    else if (typeof value === 'string') made.setAttribute(name, value);
    else made.toggleAttribute(name, value);
  }
  made.append(...children.filter((c) => c !== null && c !== undefined));
  return made;
}

/** Write only changes, so that a screen reader reads nothing twice. @param {Element} at
 * @param {string} text */
export function say(at, text) {
  if (at.textContent !== text) at.textContent = text;
}

/** @param {Element} at @param {string} name @param {string | null} value null: remove it */
export function mark(at, name, value) {
  if (value === null) at.removeAttribute(name);
  else if (at.getAttribute(name) !== value) at.setAttribute(name, value);
}

/** @param {string} id @returns {HTMLElement} Throws an Error if there is none. */
export function byId(id) {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`no element #${id}`);
  return found;
}

/** Is the user typing text, so that a letter is no command? @param {EventTarget | null} target */
export function isWriting(target) {
  if (!(target instanceof HTMLElement)) return false;
  const texts = ['text', 'search', 'url', 'email', 'password', ''];
  if (target instanceof HTMLInputElement) return texts.includes(target.type);
  return target instanceof HTMLTextAreaElement || target.isContentEditable;
}
