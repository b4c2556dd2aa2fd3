// The arm in space, on its path, as seen from a point that can be moved round it.

import { asRows } from "selfmotion/arm";
import { clamp, rowAt, shown } from "selfmotion/numbers";
import { obstacleLook, obstacleName, spaceLines } from "selfmotion/obstacles";
import { held } from "selfmotion/pointer";
import { html, lineThrough, svg } from "selfmotion/svg";

const GHOSTS = 9;
const TURN = 0.12; // that an arrow key turns the view by [rad]

export class SpaceView {
  constructor(place) {
    this.yaw = -0.9;
    this.pitch = 0.42;
    this.ghosts = true;
    this.root = svg("svg", {
      class: "arm-view space", tabindex: 0, role: "application",
      "aria-label": "the arm on its path, in space; drag or use the arrow keys to look from another side",
    });
    this.readout = html("output", { class: "readout" });
    place.replaceChildren(this.root, this.readout);
    new ResizeObserver(() => this.redraw()).observe(this.root);
    this.root.addEventListener("pointerdown", (event) => this.#orbit(event));
    this.root.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!way) return;
      event.preventDefault();
      this.#turn(way[0] * TURN, way[1] * TURN);
    });
  }

  show(scene, motion) {
    Object.assign(this, { scene, motion });
    this.#measure();
    this.redraw();
  }

  mark(r) {
    this.r = r;
    this.redraw();
  }

  #turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = clamp(this.pitch + pitch, -1.5, 1.5);
    this.redraw();
  }

  #orbit(event) {
    if (event.button !== 0) return;
    event.preventDefault();
    this.root.focus({ preventScroll: true });
    let [x, y] = [event.clientX, event.clientY];
    const move = (moved) => {
      this.#turn(0.008 * (moved.clientX - x), 0.008 * (moved.clientY - y));
      [x, y] = [moved.clientX, moved.clientY];
    };
    held(move, () => {});
  }

  // The ball that holds all that is drawn, so that the picture keeps its size when it is turned.
  #measure() {
    const least = [0, 0, 0], most = [0, 0, 0];
    const take = (array, at) => {
      for (let axis = 0; axis < 3; axis += 1) {
        const value = array[at + axis];
        if (value < least[axis]) least[axis] = value;
        if (value > most[axis]) most[axis] = value;
      }
    };
    for (const obstacle of this.scene.obstacles ?? []) {
      if (obstacle.kind !== "half_space") for (const line of spaceLines(obstacle)) for (const point of line) take(point, 0);
    }
    for (let k = 0; k < this.scene.path.x.length; k += 3) take(this.scene.path.x, k);
    for (let k = 0; k < (this.motion?.points.length ?? 0); k += 3) take(this.motion.points, k);
    this.middle = least.map((low, axis) => (low + most[axis]) / 2);
    this.radius = 0.5 * Math.hypot(...least.map((low, axis) => most[axis] - low)) || 1;
  }

  // A point on the page, and how near it is to the eye.
  #seen([x, y, z]) {
    const [a, b, c] = [x - this.middle[0], y - this.middle[1], z - this.middle[2]];
    const across = -Math.sin(this.yaw) * a + Math.cos(this.yaw) * b, away = Math.cos(this.yaw) * a + Math.sin(this.yaw) * b;
    const up = Math.cos(this.pitch) * c - Math.sin(this.pitch) * away, near = Math.sin(this.pitch) * c + Math.cos(this.pitch) * away;
    const [width, height] = this.size, scale = (0.54 * Math.min(width, height - 20)) / this.radius;
    return [width / 2 + scale * across, height / 2 - scale * up, near / this.radius];
  }

  #line(points, attributes) {
    const seen = points.map((point) => this.#seen(point));
    return svg("path", { ...attributes, d: lineThrough(seen.length, (k) => seen[k][0], (k) => seen[k][1]) });
  }

  redraw() {
    const box = this.root.getBoundingClientRect();
    if (!this.scene || box.width < 40) return;
    this.root.setAttribute("viewBox", `0 0 ${box.width} ${box.height}`);
    this.size = [box.width, box.height];
    const { path } = this.scene, parts = [this.#floor()];
    const at = (k) => [path.x[3 * k], path.x[3 * k + 1], path.x[3 * k + 2]];
    (this.scene.obstacles ?? []).forEach((obstacle, k) => {
      const lines = spaceLines(obstacle).map((line) => this.#line(line, { class: "obstacle wire" }));
      parts.push(svg("g", { class: obstacleLook(k) }, svg("title", {}, obstacleName(obstacle, k)), ...lines));
    });
    parts.push(this.#line(Array.from({ length: path.x.shape[0] }, (_, k) => at(k)), { class: "path" }));
    if (this.motion) {
      const rows = asRows(this.motion.points);
      const posture = (r) => {
        const flat = rowAt(this.motion.r, rows, r, true);
        return Array.from({ length: flat.length / 3 }, (_, k) => [flat[3 * k], flat[3 * k + 1], flat[3 * k + 2]]);
      };
      const stand = (points) => (points[0][2] > 0.01 ? [[points[0][0], points[0][1], 0], ...points] : points); // on the floor
      if (this.ghosts) for (let k = 0; k < GHOSTS; k += 1) parts.push(this.#line(posture(k / (GHOSTS - 1)), { class: "ghost" }));
      const now = posture(this.r ?? 0);
      if (Number.isFinite(now[0][0])) parts.push(...this.#arm(stand(now)));
    }
    this.root.replaceChildren(...parts);
    const tool = this.motion && rowAt(this.motion.r, asRows(this.motion.points), this.r ?? 0, true).slice(-3);
    this.readout.textContent = tool ? `tool at ${Array.from(tool, (value) => shown(value, 4)).join(", ")} m` : "";
  }

  #floor() {
    const lines = svg("g", { class: "floor" }), size = Math.ceil(this.radius * 4) / 4;
    for (let k = -4; k <= 4; k += 1) {
      const at = (k / 4) * size;
      lines.append(this.#line([[at, -size, 0], [at, size, 0]], {}), this.#line([[-size, at, 0], [size, at, 0]], {}));
    }
    for (const [axis, name] of ["x", "y", "z"].entries()) {
      const end = [0, 0, 0];
      end[axis] = 0.25 * size;
      const [x, y] = this.#seen(end.map((value) => 1.15 * value));
      lines.append(this.#line([[0, 0, 0], end], { class: `axis axis-${name}` }), svg("text", { x, y: y + 4, "text-anchor": "middle" }, name));
    }
    return lines;
  }

  // Links from far to near: nearer ones cover those behind them, and are wider.
  #arm(points) {
    const links = [];
    for (let k = 0; k + 1 < points.length; k += 1) {
      const [a, b] = [this.#seen(points[k]), this.#seen(points[k + 1])], near = (a[2] + b[2]) / 2;
      if (Math.hypot(a[0] - b[0], a[1] - b[1]) < 0.5) continue;
      links.push({ near, a, b });
    }
    links.sort((one, other) => one.near - other.near);
    const drawn = links.flatMap(({ near, a, b }) => {
      const d = `M${a[0]} ${a[1]}L${b[0]} ${b[1]}`, wide = 9 + 3 * near;
      return [svg("path", { class: "links", d, "stroke-width": wide }), svg("path", { class: "links-core", d, "stroke-width": wide - 4 })];
    });
    const [x, y] = this.#seen(points.at(-1));
    return [...drawn, svg("circle", { class: "tool", cx: x, cy: y, r: 5 })];
  }
}
