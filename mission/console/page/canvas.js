// @ts-check
/**
 * Drawing that is sharp on every screen, in the colours of the chosen theme.
 */

/** Make the canvas as large as its box. @param {HTMLCanvasElement} canvas
 * @returns {{pen: CanvasRenderingContext2D, width: number, height: number} | null} CSS px; null:
 *   not shown */
export function sheet(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const pen = canvas.getContext('2d');
  if (!width || !height || pen === null) return null;
  const dots = window.devicePixelRatio || 1;
  const [wide, high] = [Math.round(width * dots), Math.round(height * dots)];
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  pen.setTransform(dots, 0, 0, dots, 0, 0);
  return { pen, width, height };
}

/** Colours of the theme, by name. @template {string} N @param {Record<N, string>} names
 * name here: variable of the theme @returns {Record<N, string>} */
export function inksOf(names) {
  const style = getComputedStyle(document.documentElement);
  const found = Object.entries(names).map(([ours, theirs]) =>
    [ours, style.getPropertyValue(`--${theirs}`).trim()]);
  return Object.fromEntries(found);
}
