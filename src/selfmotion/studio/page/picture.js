// All diagrams of a place as one SVG, with the colours that are seen.

const LOOKS = [
  "fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-opacity", "font-size", "font-family", "font-weight",
  "opacity", "paint-order", "visibility",
];

export function pictureOf(place) {
  const boxes = [...place.querySelectorAll("svg.plot")], all = boxes.map((box) => box.getBoundingClientRect());
  const [left, top] = [Math.min(...all.map((box) => box.left)), Math.min(...all.map((box) => box.top))];
  const width = Math.max(...all.map((box) => box.right)) - left, height = Math.max(...all.map((box) => box.bottom)) - top;
  const copies = boxes.map((box, k) => {
    const copy = box.cloneNode(true), originals = box.querySelectorAll("*");
    copy.querySelectorAll("*").forEach((element, i) => {
      const style = getComputedStyle(originals[i]);
      for (const name of LOOKS) element.setAttribute(name, style.getPropertyValue(name));
    });
    for (const [name, value] of Object.entries({ x: all[k].left - left, y: all[k].top - top, width: all[k].width, height: all[k].height })) copy.setAttribute(name, value);
    copy.setAttribute("font-family", "sans-serif");
    return new XMLSerializer().serializeToString(copy);
  });
  const back = getComputedStyle(document.body).backgroundColor;
  return new Blob([`<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}"><rect width="100%" height="100%" fill="${back}"/>${copies.join("")}</svg>`], { type: "image/svg+xml" });
}
