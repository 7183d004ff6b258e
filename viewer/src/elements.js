// Elements of a page, of HTML and of SVG. What they hold is always text or other elements, so that no name becomes markup.

export const byId = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** @typedef {Node | string | null | undefined | false | any[]} Content lists are flattened; null, undefined and false add nothing */

/** @template {HTMLElement | SVGElement} E @param {E} element @param {Record<string, any>} properties @param {Content[]} children */
function filled(element, properties, children) {
  for (const [key, value] of Object.entries(properties)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (key === "style") element.style.cssText = value;
    else if (typeof value === "boolean") element.toggleAttribute(key, value);
    else element.setAttribute(key, value);
  }
  const all = /** @type {Content[]} */ (children.flat(Infinity));
  element.append(.../** @type {(Node | string)[]} */ (all.filter((child) => child !== null && child !== undefined && child !== false)));
  return element;
}

/** Makes an element. Properties that begin with "on" are listeners of events.
 * @template {keyof HTMLElementTagNameMap} T @param {T} tag @param {Record<string, any>} [properties] @param {Content[]} children @returns {HTMLElementTagNameMap[T]} */
export function make(tag, properties = {}, ...children) {
  return filled(document.createElement(tag), properties, children);
}

/** Makes an element of SVG. @param {string} tag @param {Record<string, any>} [properties] @param {Content[]} children */
export function draw(tag, properties = {}, ...children) {
  return filled(/** @type {SVGElement} */ (document.createElementNS("http://www.w3.org/2000/svg", tag)), properties, children);
}
