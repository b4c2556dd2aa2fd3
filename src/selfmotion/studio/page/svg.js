// Elements, and paths through arrays of numbers; what users wrote becomes text, never markup.

const SPACE = "http://www.w3.org/2000/svg";

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child != null));
  return element;
}

export const svg = (name, attributes = {}, ...children) =>
  filled(document.createElementNS(SPACE, name), attributes, children);

export const html = (name, attributes = {}, ...children) => filled(document.createElement(name), attributes, children);

// Text of a path through points; it is interrupted where a number is not finite, and closed if asked to.
export function lineThrough(count, x, y, closed = false) {
  let text = "", pen = "M";
  for (let k = 0; k < count; k += 1) {
    const a = x(k), b = y(k);
    if (!Number.isFinite(a) || !Number.isFinite(b)) { pen = "M"; continue; }
    text += `${pen}${a.toFixed(2)} ${b.toFixed(2)}`;
    pen = "L";
  }
  return closed && text ? `${text}Z` : text;
}
