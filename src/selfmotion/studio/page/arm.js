// The arm in the plane, on its path: posture, ghosts, reach, and what can be dragged of path and arm.

import { jointName } from "selfmotion/looks";
import { clamp, rowAt, shown } from "selfmotion/numbers";
import { gripsOf, movedBy, planeShape } from "selfmotion/obstacles";
import { held } from "selfmotion/pointer";
import { html, lineThrough, svg } from "selfmotion/svg";

const GHOSTS = 13;
const ARC = 34; // radius of a joint's limits [px]

export class ArmView {
  // `acts`: {path(k, point, settled), link(k, length, settled), limit(joint, side, value, settled), obstacle(k, change, settled),
  // freehand(points)}; what
  // is new is a value, or a function of what is there, for keys that come faster than pictures.
  constructor(place, acts = {}) {
    this.acts = acts;
    this.mode = "path";
    this.ghosts = true;
    this.root = svg("svg", { class: "arm-view", role: "group", "aria-label": "the arm on its path" });
    this.back = svg("g");
    this.arm = svg("g", { class: "arm", "aria-hidden": "true" });
    this.front = svg("g");
    this.root.append(this.back, this.arm, this.front);
    this.readout = html("output", { class: "readout" });
    place.replaceChildren(this.root, this.readout);
    new ResizeObserver(() => this.redraw(true)).observe(this.root);
    this.root.addEventListener("pointerdown", (event) => this.#carry(event) || this.#freehand(event));
    this.root.addEventListener("pointermove", (event) => {
      const at = this.scene && this.#under(event);
      this.readout.textContent = at ? `x = ${shown(at[0], 5)}, y = ${shown(at[1], 5)}${this.#unit}` : "";
    });
  }

  show(scene, motion, { refit = true } = {}) {
    this.scene = scene;
    this.motion = motion;
    this.redraw(refit && !this.dragged);
  }

  mark(r) {
    this.r = r;
    this.#drawPosture();
  }

  get #unit() { return this.scene.length_unit ? ` ${this.scene.length_unit}` : ""; }

  #step(long) { return (long ? 0.05 : 0.005) * (this.scene.reach?.outer ?? 1); }

  redraw(refit = false) {
    const box = this.root.getBoundingClientRect();
    if (!this.scene || box.width < 40) return;
    this.root.setAttribute("viewBox", `0 0 ${box.width} ${box.height}`);
    this.size = [box.width, box.height];
    if (refit || !this.fit) this.#refit();
    this.#drawBack();
    this.#drawPosture();
    this.#drawHandles();
  }

  #refit() {
    const { path, reach } = this.scene, x = [], y = [];
    for (let k = 0; k < path.x.shape[0]; k += 1) { x.push(path.x[2 * k]); y.push(path.x[2 * k + 1]); }
    for (const [a, b] of path.handles ?? []) { x.push(a); y.push(b); }
    if (this.motion) {
      const { points } = this.motion, every = Math.max(1, Math.floor(points.shape[0] / 60)) * points.shape[1] * 2;
      for (let start = 0; start < points.length; start += every) {
        for (let k = 0; k < points.shape[1]; k += 1) {
          if (Number.isFinite(points[start + 2 * k])) { x.push(points[start + 2 * k]); y.push(points[start + 2 * k + 1]); }
        }
      }
    }
    for (const { kind, center, radius, corners } of this.scene.obstacles ?? []) {
      const around = kind === "circle" ? [-radius, radius].map((by) => center.map((value) => value + by)) : corners ?? [];
      for (const [a, b] of around) if (Math.hypot(a, b) < 1.3 * (reach?.outer ?? Infinity)) { x.push(a); y.push(b); }
    }
    const whole = this.wholeReach && reach ? reach.outer : 0;
    x.push(reach ? reach.center[0] - whole : 0, reach ? reach.center[0] + whole : 0);
    y.push(reach ? reach.center[1] - whole : 0, reach ? reach.center[1] + whole : 0);
    const least = [Math.min(...x), Math.min(...y)], most = [Math.max(...x), Math.max(...y)];
    const [width, height] = this.size;
    const room = this.mode === "arm" ? 2 * ARC + 24 : 56; // the limits' arcs must be in reach
    const scale = Math.min((width - room) / (most[0] - least[0] || 1), (height - room - 8) / (most[1] - least[1] || 1));
    this.fit = { scale, x: width / 2 - (scale * (least[0] + most[0])) / 2, y: height / 2 + (scale * (least[1] + most[1])) / 2 };
  }

  #x(value) { return this.fit.x + this.fit.scale * value; }
  #y(value) { return this.fit.y - this.fit.scale * value; }

  #under(event) {
    const box = this.root.getBoundingClientRect();
    return [(event.clientX - box.left - this.fit.x) / this.fit.scale, (this.fit.y - (event.clientY - box.top)) / this.fit.scale];
  }

  #drawBack() {
    const { path, reach, blocked } = this.scene, parts = [], [width, height] = this.size;
    if (reach) {
      const [a, b] = [this.#x(reach.center[0]), this.#y(reach.center[1])];
      const ring = (radius) => `M${a - radius} ${b}a${radius} ${radius} 0 1 0 ${2 * radius} 0a${radius} ${radius} 0 1 0 ${-2 * radius} 0Z`;
      const { scale } = this.fit;
      parts.push(svg("path", { class: "reach", "fill-rule": "evenodd", d: ring(reach.outer * scale) + ring(reach.inner * scale) }));
      const taken = [];
      for (const circle of reach.circles) {
        if (!(circle.radius > 0)) continue;
        const radius = circle.radius * scale;
        parts.push(svg("circle", { class: "radius", cx: a, cy: b, r: radius }, svg("title", {}, circle.name)));
        // The name stands where the circle first comes into view, going round from the path's side.
        for (let turn = 0; turn < 48; turn += 1) {
          const angle = ((turn % 2 ? 1 : -1) * Math.ceil(turn / 2) * Math.PI) / 24 + Math.PI / 4;
          const [x, y] = [a + radius * Math.cos(angle), b - radius * Math.sin(angle)];
          const wide = 5.6 * circle.name.length;
          if (x < wide / 2 + 4 || x > width - wide / 2 - 4 || y < 16 || y > height - 26) continue;
          if (taken.some(([p, q]) => Math.abs(p - x) < wide && Math.abs(q - y) < 14)) continue;
          taken.push([x, y]);
          parts.push(svg("text", { class: "radius-name", x, y: y - 3, "text-anchor": "middle" }, circle.name));
          break;
        }
      }
    }
    const look = { x: (value) => this.#x(value), y: (value) => this.#y(value), scale: this.fit.scale, far: 4 * (reach?.outer ?? 1), clearance: this.scene.clearance, aside: this.mode === "obstacles" };
    (this.scene.obstacles ?? []).forEach((obstacle, k) => parts.push(planeShape(obstacle, k, look)));
    const count = path.x.shape[0];
    const d = (from, to) => lineThrough(to - from + 1, (k) => this.#x(path.x[2 * (from + k)]), (k) => this.#y(path.x[2 * (from + k) + 1]));
    parts.push(svg("path", { class: "path", d: d(0, count - 1) }));
    for (const part of blocked) {
      const from = path.r.findIndex((r) => r >= part.r[0] - 1e-9), to = path.r.findLastIndex((r) => r <= part.r[1] + 1e-9);
      if (to >= from && from >= 0) {
        parts.push(svg("path", { class: "path blocked", d: d(Math.max(from - 1, 0), Math.min(to + 1, count - 1)) }, svg("title", {}, part.text)));
      }
    }
    parts.push(svg("circle", { class: "path-start", cx: this.#x(path.x[0]), cy: this.#y(path.x[1]), r: 4 }, svg("title", {}, "the path starts here")));
    if (this.ghosts && this.motion) {
      for (let k = 0; k < GHOSTS; k += 1) {
        const points = this.#posture(k / (GHOSTS - 1));
        parts.push(svg("path", { class: "ghost", d: this.#through(points) }));
      }
    }
    this.back.replaceChildren(...parts);
  }

  #posture(r) {
    const { points, r: places } = this.motion;
    return rowAt(places, asRows(points), this.#nearest(r), true);
  }

  // Where there is no posture: the nearest place with one, so that the arm can still be taken hold of.
  #nearest(r) {
    const { points, r: places } = this.motion, rows = asRows(points), there = (k) => Number.isFinite(rows[k * rows.shape[1]]);
    if (Number.isFinite(rowAt(places, rows, r, true)[0])) return r;
    let best = null;
    for (let k = 0; k < places.length; k += 1) {
      if (there(k) && (best === null || Math.abs(places[k] - r) < Math.abs(best - r))) best = places[k];
    }
    return best ?? r;
  }

  #through(points) {
    return lineThrough(points.length / 2, (k) => this.#x(points[2 * k]), (k) => this.#y(points[2 * k + 1]));
  }

  #drawPosture() {
    if (!this.fit || !this.motion) { this.arm.replaceChildren(); return; }
    const points = this.#posture(this.r ?? 0), d = this.#through(points), joints = [];
    if (!Number.isFinite(points[0])) { this.arm.replaceChildren(); return; }
    for (let k = 0; k < points.length / 2 - 1; k += 1) {
      joints.push(svg("circle", { class: k ? "joint" : "joint base", cx: this.#x(points[2 * k]), cy: this.#y(points[2 * k + 1]), r: k ? 5 : 7 }));
    }
    const end = points.length - 2;
    const wide = (this.scene.thickness ?? []).map((width, k) => (width > 0 ? svg("path", {
      class: "thickness", "stroke-width": width * this.fit.scale,
      d: `M${this.#x(points[2 * k])} ${this.#y(points[2 * k + 1])}L${this.#x(points[2 * k + 2])} ${this.#y(points[2 * k + 3])}`,
    }) : null));
    const tool = svg("circle", { class: "tool", cx: this.#x(points[end]), cy: this.#y(points[end + 1]), r: 4.5 });
    this.arm.replaceChildren(...wide.filter(Boolean), svg("path", { class: "links", d }), svg("path", { class: "links-core", d }), ...joints, tool);
    if (this.mode === "arm") this.#drawHandles();
  }

  #drawHandles() {
    const focused = document.activeElement?.dataset?.handle;
    const made = { path: () => this.#pathHandles(), arm: () => this.#armHandles(), obstacles: () => this.#obstacleHandles() }[this.mode]?.() ?? [];
    if (!this.dragged) {
      this.front.replaceChildren(...made);
      if (focused) this.front.querySelector(`[data-handle="${focused}"]`)?.focus({ preventScroll: true });
      return;
    }
    // The handle in the hand must stay the same element: only its place changes.
    for (const fresh of made) {
      const old = this.front.querySelector(`[data-handle="${fresh.dataset?.handle}"]`);
      if (!old) continue;
      for (const name of ["cx", "cy", "d", "transform"]) if (fresh.hasAttribute(name)) old.setAttribute(name, fresh.getAttribute(name));
    }
  }

  // `move` takes the place that a drag has got to, `push` the direction of an arrow key and whether it is a long step.
  #handle(name, label, x, y, move, push, shape = "circle") {
    const attributes = shape === "circle" ? { cx: this.#x(x), cy: this.#y(y), r: 6 } : { d: "M0 -7L7 0L0 7L-7 0Z", transform: `translate(${this.#x(x)} ${this.#y(y)})` };
    const key = (event) => {
      const way = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowRight: [1, 0], ArrowLeft: [-1, 0] }[event.key];
      if (!way) return;
      event.preventDefault();
      push(way, event.shiftKey);
    };
    return svg(shape, {
      class: "handle", ...attributes, tabindex: 0, role: "button", "data-handle": name, "aria-label": `${label}; arrow keys move it`,
      onkeydown: key, onpointerdown: (event) => this.#drag(event, move),
    }, svg("title", {}, label));
  }

  #drag(event, move) {
    event.preventDefault();
    event.stopPropagation();
    event.target.focus({ preventScroll: true });
    this.dragged = true;
    let last = null;
    const moving = (moved) => { last = this.#under(moved); move(last, false); };
    held(moving, () => {
      this.dragged = false;
      if (last) move(last, true);
    });
  }

  #obstacleHandles() {
    if (!this.acts.obstacle) return [];
    return (this.scene.obstacles ?? []).flatMap((obstacle, k) => gripsOf(obstacle, k).map(({ name, label, at, to }) => this.#handle(
      name, label, ...at, (place, settled) => this.acts.obstacle(k, (entry) => to(entry, place), settled),
      (way, long) => this.acts.obstacle(k, (entry) => {
        const here = gripsOf({ ...obstacle, ...(entry.polygon ? { corners: entry.polygon } : entry[obstacle.kind]) }, k).find((grip) => grip.name === name).at;
        return to(entry, [0, 1].map((axis) => here[axis] + way[axis] * this.#step(long)));
      }, true),
    )));
  }

  // An obstacle in the hand: moved as a whole, from where it was.
  #carry(event) {
    const k = event.target.dataset?.obstacle;
    if (k === undefined || event.button !== 0 || this.mode === "draw" || !this.acts.obstacle) return false;
    event.preventDefault();
    this.dragged = true;
    const from = this.#under(event);
    let was = null, last = null;
    const put = (settled) => this.acts.obstacle(Number(k), (entry) => {
      was ??= entry;
      return movedBy(was, [last[0] - from[0], last[1] - from[1]]);
    }, settled);
    held((moved) => { last = this.#under(moved); put(false); }, () => {
      this.dragged = false;
      if (last) put(true);
    });
    return true;
  }

  #pathHandles() {
    const points = this.scene.path.handles;
    if (!points || !this.acts.path) return [];
    const d = lineThrough(points.length, (k) => this.#x(points[k][0]), (k) => this.#y(points[k][1]));
    return [
      svg("path", { class: "control", d }),
      ...points.map(([x, y], k) => this.#handle(`path-${k}`, `path point ${k + 1}`, x, y, (at, settled) => this.acts.path(k, at, settled),
        (way, long) => this.acts.path(k, (old) => [0, 1].map((axis) => old[axis] + way[axis] * this.#step(long)), true))),
    ];
  }

  #armHandles() {
    const { scene, motion } = this, made = [];
    if (!motion || !scene.links || !this.acts.link) return made;
    const points = this.#posture(this.r ?? 0), place = (k) => [points[2 * k], points[2 * k + 1]];
    if (!Number.isFinite(points[0]) || points.length !== 2 * scene.n + 2) return made;
    const angles = rowAt(motion.r, motion.q, this.#nearest(this.r ?? 0), true);
    scene.links.forEach((length, k) => {
      const [a, b] = [place(k), place(k + 1)], half = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
      const along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
      const move = (at, settled) => {
        const moved = (at[0] - half[0]) * along[0] + (at[1] - half[1]) * along[1];
        this.acts.link(k, Math.max(length + 2 * moved, 1e-3 * length), settled);
      };
      const push = (way, long) => this.acts.link(k, (old) => Math.max(old + (way[0] + way[1]) * this.#step(long), 1e-3 * old), true);
      made.push(this.#handle(`link-${k}`, `length of link ${k + 1}: ${shown(length, 5)}`, ...half, move, push, "path"));
    });
    let before = 0;
    scene.limits.forEach((limit, k) => {
      const [a, b] = place(k), [x, y] = [this.#x(a), this.#y(b)];
      const lower = limit?.[0] ?? null, upper = limit?.[1] ?? null;
      if (lower !== null && upper !== null) {
        const at = (angle) => [x + ARC * Math.cos(before + angle), y - ARC * Math.sin(before + angle)];
        const span = Math.min(upper - lower, 2 * Math.PI - 1e-3);
        const [p, q] = [at(lower), at(lower + span)];
        made.push(svg("path", { class: `limit-arc joint-${k % 8}`, d: `M${x} ${y}L${p}A${ARC} ${ARC} 0 ${span > Math.PI ? 1 : 0} 0 ${q}Z` }));
        const from = before;
        [["lower", lower, 0], ["upper", upper, 1]].forEach(([side, value, number]) => {
          const [px, py] = at(value), where = [(px - this.fit.x) / this.fit.scale, (this.fit.y - py) / this.fit.scale];
          const move = (to, settled) => {
            let angle = Math.atan2(to[1] - b, to[0] - a) - from;
            angle += 2 * Math.PI * Math.round((value - angle) / (2 * Math.PI));
            this.acts.limit(k, number, number ? Math.max(angle, lower + 0.01) : Math.min(angle, upper - 0.01), settled);
          };
          const push = (way, long) => this.acts.limit(k, number, (old) => {
            const next = old + (way[0] + way[1]) * (long ? 0.1 : 0.01);
            return number ? Math.max(next, lower + 0.01) : Math.min(next, upper - 0.01);
          }, true);
          made.push(this.#handle(`limit-${k}-${side}`, `${side} limit of ${jointName(scene, k)}: ${shown(value, 5)} rad`, ...where, move, push));
        });
      }
      before += angles[k];
    });
    return made;
  }

  #freehand(event) {
    if (this.mode !== "draw" || event.button !== 0) return;
    event.preventDefault();
    const points = [], trace = svg("path", { class: "trace" });
    this.front.append(trace);
    const move = (moved) => {
      points.push(this.#under(moved));
      trace.setAttribute("d", lineThrough(points.length, (k) => this.#x(points[k][0]), (k) => this.#y(points[k][1])));
    };
    held(move, () => {
      trace.remove();
      const few = simplified(points, 2 / this.fit.scale);
      if (few.length > 1) this.acts.freehand?.(few);
    });
    move(event);
  }
}

// Joint positions of all postures as rows of one posture each.
export function asRows(points) {
  const rows = points.subarray(0);
  rows.shape = [points.shape[0], points.shape[1] * points.shape[2]];
  return rows;
}

// Fewer points that stay within `tolerance` of all of them (Douglas and Peucker).
export function simplified(points, tolerance) {
  if (points.length < 3) return points;
  const [a, b] = [points[0], points.at(-1)], length = Math.hypot(b[0] - a[0], b[1] - a[1]);
  let far = 0, most = -1;
  for (let k = 1; k < points.length - 1; k += 1) {
    const [x, y] = [points[k][0] - a[0], points[k][1] - a[1]];
    const part = length ? clamp((x * (b[0] - a[0]) + y * (b[1] - a[1])) / length ** 2, 0, 1) : 0;
    const away = Math.hypot(x - part * (b[0] - a[0]), y - part * (b[1] - a[1]));
    if (away > most) [far, most] = [k, away];
  }
  if (most <= tolerance) return [a, b];
  return [...simplified(points.slice(0, far + 1), tolerance).slice(0, -1), ...simplified(points.slice(far), tolerance)];
}
