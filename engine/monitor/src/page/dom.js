// @ts-check
// Elements. Every text that is shown becomes a text node: names and messages come from the bus and are not trusted.

/** Makes an element with attributes, handlers (`onclick`) and children.
 * @param {string} tag @param {Record<string, any>} [attributes] @param {...any} children */
export function el(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

/** Makes an SVG element. @param {string} tag @param {Record<string, any>} [attributes] @param {...any} children */
export function svg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value != null) element.setAttribute(name, String(value));
  }
  for (const child of children.flat()) {
    if (child != null && child !== false) element.append(child instanceof Node ? child : document.createTextNode(String(child)));
  }
  return element;
}

/** Sets a text, if it has changed. */
export function text(element, value) {
  if (element.textContent !== value) element.textContent = value;
}

/** Sets the class, if it has changed. */
export function className(element, value) {
  if (element.getAttribute("class") !== value) element.setAttribute("class", value);
}

/** Makes the children of an element those of the items, and reuses the ones that are already there.
 * @param {Element} parent @param {any[]} items @param {(item: any) => string} key @param {(item: any) => Element} make
 * @param {(element: any, item: any) => void} update */
export function list(parent, items, key, make, update) {
  const known = parent["known"] ?? (parent["known"] = new Map());
  const names = items.map(key), wanted = new Set(names);
  // at first, so that those that stay need not be moved, which would take the focus from them
  for (const [name, element] of known) {
    if (!wanted.has(name)) { element.remove(); known.delete(name); }
  }
  let place = parent.firstChild;
  for (const [index, item] of items.entries()) {
    const name = names[index];
    if (!wanted.delete(name)) continue;
    let element = known.get(name);
    if (!element) known.set(name, (element = make(item)));
    update(element, item);
    if (element === place) place = place.nextSibling;
    else parent.insertBefore(element, place);
  }
}

/** A panel with a head and a body, which can stand still while the others go on. @param {string} title @param {string} name
 * @param {any[]} head @param {...any} body */
export function panel(title, name, head, ...body) {
  const button = el("button", { type: "button", class: "still", "aria-pressed": "false", "aria-label": `Pause ${title}`, title: "Pauses this panel; the system continues", onclick: () => still(root, button) }, "❚❚");
  const root = el("section", { class: `panel ${name}`, "aria-label": title }, el("div", { class: "head" }, el("h2", {}, title), head, button), body);
  return root;
}

/** Shows a picture of a panel's body in its place, or the body again. */
function still(root, button) {
  const isStill = root.classList.toggle("is-still");
  button.setAttribute("aria-pressed", String(isStill));
  text(button, isStill ? "▶" : "❚❚");
  if (!isStill) {
    for (const it of [...root.children]) if (it.classList.contains("picture")) it.remove();
    return;
  }
  for (const part of [...root.children].slice(1)) {
    const picture = part.cloneNode(true);
    const [from, to] = [part, picture].map((it) => [...(it.tagName === "CANVAS" ? [it] : []), ...it.querySelectorAll("canvas")]);
    to.forEach((canvas, index) => canvas.getContext("2d").drawImage(from[index], 0, 0));
    for (const it of [picture, ...picture.querySelectorAll("[id]")]) it.removeAttribute("id");
    for (const it of picture.querySelectorAll("button, input, select")) it.disabled = true;
    picture.classList.add("picture");
    root.insertBefore(picture, part);
    picture.scrollTop = part.scrollTop;
  }
}

/** Colours by name: asking the browser for one makes it compute the style of the page. @type {Map<string, string>} */
const colours = new Map();

/** A colour of the style sheet. @param {string} name */
export function colour(name) {
  let found = colours.get(name);
  if (found === undefined) colours.set(name, (found = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()));
  return found;
}

/** Called when the theme has changed. */
export function forgetColours() { colours.clear(); }

/** Fits a canvas to its place, and returns its context and its size in CSS pixels. @param {HTMLCanvasElement} canvas */
export function fitted(canvas) {
  const [width, height, ratio] = [canvas.clientWidth, canvas.clientHeight, devicePixelRatio || 1];
  const [columns, rows] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== columns || canvas.height !== rows) [canvas.width, canvas.height] = [columns, rows];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height };
}

/** A number with a fixed number of decimals, or a dash. */
export function fixed(value, decimals = 1) {
  // what is rounded to zero has no sign
  return typeof value === "number" && Number.isFinite(value) ? value.toFixed(decimals).replace(/^-(0(\.0*)?)$/, "$1") : "–";
}

/** A time span in words. @param {number} seconds */
export function span(seconds) {
  if (seconds < 1) return `${Math.round(seconds * 1000)} ms`;
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  return `${Math.floor(seconds / 60)} min ${Math.floor(seconds % 60)} s`;
}
