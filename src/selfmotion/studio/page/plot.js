// A diagram: scales, ticks, grid and a crosshair in an SVG that fills its place; what is drawn in it comes from others.

import { shown } from "selfmotion/numbers";
import { svg } from "selfmotion/svg";

const MARGIN = { left: 46, right: 12, top: 20, bottom: 34 };

// About so many round numbers, two at least.
function ticksBetween(low, high, about) {
  const rough = (high - low) / Math.max(about, 2);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5].find((factor) => factor * power >= rough) ?? 10);
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) ticks.push(k * step);
  return ticks.length > 1 || about > 8 ? ticks : ticksBetween(low, high, 1.6 * Math.max(about, 2));
}

let counter = 0;

export class Plot {
  constructor(place, { label, xName = "path parameter r", yName = "", hover = null }) {
    this.xName = xName;
    this.yName = yName;
    this.domain = { x: [0, 1], y: [0, 1] };
    this.layers = [];
    const clip = `clip-${(counter += 1)}`;
    this.clip = svg("rect");
    this.axes = svg("g", { class: "axes" });
    this.inside = svg("g", { "clip-path": `url(#${clip})` });
    this.above = svg("g");
    this.cross = svg("g", { class: "cross", "clip-path": `url(#${clip})`, "aria-hidden": "true" });
    this.title = svg("text", { class: "plot-title" });
    this.root = svg(
      "svg", { class: "plot", role: "group", "aria-label": label },
      svg("defs", {}, svg("clipPath", { id: clip }, this.clip)), this.axes, this.inside, this.cross, this.above, this.title,
    );
    place.append(this.root);
    if (hover) this.#hover(hover);
    this.observer = new ResizeObserver(() => this.redraw());
    this.observer.observe(this.root);
  }

  // Draw anew whenever the size or the scales change.
  draws(layer) { this.layers.push(layer); return this; }

  scaled(x, y) {
    this.domain = { x, y: y[1] > y[0] ? y : [y[0] - 1, y[1] + 1] };
    return this;
  }

  get inner() {
    const { width, height } = this.size;
    return { left: MARGIN.left, right: width - MARGIN.right, top: MARGIN.top, bottom: height - MARGIN.bottom };
  }

  x(value) {
    const { left, right } = this.inner, [low, high] = this.domain.x;
    return left + ((value - low) / (high - low)) * (right - left);
  }

  y(value) {
    const { top, bottom } = this.inner, [low, high] = this.domain.y;
    return bottom - ((value - low) / (high - low)) * (bottom - top);
  }

  // What lies under a pointer, in the units of the axes.
  under(event) {
    const box = this.root.getBoundingClientRect(), { left, right, top, bottom } = this.inner;
    const across = (event.clientX - box.left - left) / (right - left);
    const up = (bottom - (event.clientY - box.top)) / (bottom - top);
    const { x, y } = this.domain;
    return {
      x: x[0] + across * (x[1] - x[0]), y: y[0] + up * (y[1] - y[0]),
      inside: across >= 0 && across <= 1 && up >= 0 && up <= 1,
    };
  }

  redraw() {
    const box = this.root.getBoundingClientRect();
    if (box.width < 80 || box.height < 60) return;
    this.size = { width: box.width, height: box.height };
    this.root.setAttribute("viewBox", `0 0 ${box.width} ${box.height}`);
    this.#drawAxes();
    this.inside.replaceChildren();
    this.above.replaceChildren();
    for (const layer of this.layers) layer(this);
  }

  #drawAxes() {
    const { left, right, top, bottom } = this.inner;
    for (const [name, value] of Object.entries({ x: left, y: top, width: right - left, height: bottom - top })) {
      this.clip.setAttribute(name, value);
    }
    const marks = [svg("rect", { class: "frame", x: left, y: top, width: right - left, height: bottom - top })];
    for (const value of ticksBetween(...this.domain.x, (right - left) / 70)) {
      marks.push(svg("path", { class: "grid", d: `M${this.x(value)} ${top}V${bottom}` }));
      marks.push(svg("text", { class: "tick", x: this.x(value), y: bottom + 13, "text-anchor": "middle" }, shown(value)));
    }
    for (const value of ticksBetween(...this.domain.y, (bottom - top) / 36)) {
      marks.push(svg("path", { class: "grid", d: `M${left} ${this.y(value)}H${right}` }));
      marks.push(svg("text", { class: "tick", x: left - 5, y: this.y(value) + 3.5, "text-anchor": "end" }, shown(value)));
    }
    const middle = (top + bottom) / 2;
    marks.push(svg("text", { class: "name", x: (left + right) / 2, y: bottom + 27, "text-anchor": "middle" }, this.xName));
    marks.push(svg(
      "text", { class: "name", x: 11, y: middle, "text-anchor": "middle", transform: `rotate(-90 11 ${middle})` },
      this.yName.length * 5.6 > bottom - top + 24 ? this.yShort ?? this.yName : this.yName,
    ));
    this.axes.replaceChildren(...marks);
    this.title.setAttribute("x", left);
    this.title.setAttribute("y", 13);
  }

  crosshair(x, y = null) {
    const { left, right, top, bottom } = this.size ? this.inner : {};
    if (x === null || !this.size) { this.cross.replaceChildren(); return; }
    this.cross.replaceChildren(
      svg("path", { d: `M${this.x(x)} ${top}V${bottom}` }),
      ...(y === null ? [] : [svg("path", { d: `M${left} ${this.y(y)}H${right}` })]),
    );
  }

  #hover(hover) {
    this.root.addEventListener("pointermove", (event) => {
      const at = this.size && this.under(event);
      hover(at && at.inside ? at : null);
    });
    this.root.addEventListener("pointerleave", () => hover(null));
  }
}
