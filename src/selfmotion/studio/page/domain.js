// The angle domain: what is feasible, what bounds it, and the curves that motions are in it; they can be dragged.

import { causeLook } from "selfmotion/looks";
import { clamp, placeIn, shown, TAU } from "selfmotion/numbers";
import { obstacleLook } from "selfmotion/obstacles";
import { Plot } from "selfmotion/plot";
import { held } from "selfmotion/pointer";
import { placesOf, splineAt } from "selfmotion/spline";
import { html, lineThrough, svg } from "selfmotion/svg";

const STEP = 0.01; // that an arrow key moves the curve by [rad]
const MARKS = { opens: "◁", closes: "▷", splits: "◀", merges: "▶", "component appears": "○", "component dies": "□", singular: "☆" };

export class DomainView {
  #panels = [];
  #r = 0;

  // `acts` is told of hovers and drags: {hover(r), grab(panel), drag({component, r, by}), drop(), draw({branch, component, points})}
  constructor(place, acts = {}) {
    this.place = place;
    this.acts = acts;
    this.drawing = false;
  }

  // domain: what can be; curves: {motion, rival, tube, hand}, each null where there is none.
  show(scene, domain, curves) {
    this.scene = scene;
    this.curves = curves;
    if (domain !== this.domain) {
      this.domain = domain;
      this.#build();
    }
    for (const panel of this.#panels) panel.show(domain.panels[panel.number], curves, scene);
    this.mark(this.#r);
  }

  // Bring the panel that a motion is on into view.
  reveal() {
    const { motion } = this.curves ?? {};
    const panel = motion && this.#panels.find(({ branch }) => motion.branch[0] === branch);
    if (this.#panels.length > 4) panel?.plot.root.scrollIntoView({ block: "nearest" });
  }

  mark(r) {
    this.#r = r;
    for (const panel of this.#panels) panel.mark(r);
  }

  #build() {
    const names = this.domain.panels.map((panel) => `${panel.branch}/${panel.component}/${panel.title}`).join() || this.domain.structure.join();
    if (names === this.names) return;
    this.names = names;
    this.place.replaceChildren();
    this.place.dataset.panels = this.domain.panels.length;
    this.#panels = this.domain.panels.map((_, number) => new Panel(this, number));
    if (!this.#panels.length) {
      const why = this.domain.kind === "exact" ? "Nothing is feasible anywhere along this path: see what blocks it above." : this.domain.structure.join(" ");
      this.place.append(html("p", { class: "nothing" }, why || "Nothing is feasible anywhere along this path."));
    }
  }
}

class Panel {
  constructor(view, number) {
    this.view = view;
    this.number = number;
    const { title, component, branch } = view.domain.panels[number];
    this.component = component;
    this.branch = branch;
    this.plot = new Plot(view.place, {
      label: `angle domain, ${title}`, yName: "redundancy parameter u [rad]", hover: (at) => this.#hover(at),
    });
    this.plot.draws(() => this.#draw());
    this.plot.title.textContent = title;
    this.plot.root.dataset.branch = branch;
    this.plot.root.addEventListener("pointerdown", (event) => this.#press(event));
  }

  show(data, curves, scene) {
    Object.assign(this, { data, curves, scene });
    this.plot.yName = scene.n_u > 1 ? `u${this.component + 1} [rad]` : scene.parameter ?? "redundancy parameter u [rad]";
    this.plot.yShort = "u [rad]";
    this.plot.scaled([0, 1], data.range);
    const focused = document.activeElement?.closest?.("svg") === this.plot.root ? document.activeElement.dataset.index : undefined;
    this.plot.redraw();
    if (focused !== undefined) this.plot.above.querySelector(`.handle[data-index="${focused}"]`)?.focus({ preventScroll: true });
  }

  mark(r) {
    this.r = r;
    this.plot.crosshair(r);
    this.#drawBead();
  }

  // The curve of a motion on this panel, moved by whole turns to where it is seen.
  *#copies(motion, branch = this.branch) {
    const { u, r, branch: on } = motion, columns = u.shape[1], [low, high] = this.data.range;
    const value = (k) => (columns > 1 || on[k] === branch ? u[k * columns + this.component] : NaN);
    let least = Infinity, most = -Infinity;
    for (let k = 0; k < r.length; k += 1) {
      const here = value(k);
      if (here < least) least = here;
      if (here > most) most = here;
    }
    if (least > most) return;
    const period = this.data.period ? this.data.period[1] - this.data.period[0] : TAU;
    for (let turn = Math.ceil((low - most) / period - 0.1); turn <= (high - least) / period + 0.1; turn += 1) {
      yield { turn: turn * period, value: (k) => value(k) + turn * period };
    }
  }

  #curve(motion, attributes, into = this.plot.inside, wrong = null) {
    const { plot } = this, { r } = motion;
    for (const { value, turn } of this.#copies(motion)) {
      const d = lineThrough(r.length, (k) => plot.x(r[k]), (k) => plot.y(value(k)));
      if (d) into.append(svg("path", { d, ...attributes, "data-turn": turn }));
      for (const part of wrong ?? []) {
        const from = Math.max(placeIn(r, part.r[0]) - 1, 0), to = Math.min(placeIn(r, part.r[1]) + 1, r.length - 1);
        const bad = lineThrough(to - from + 1, (k) => plot.x(r[from + k]), (k) => plot.y(value(from + k)));
        if (bad) into.append(svg("path", { d: bad, class: "wrong" }, svg("title", {}, part.text)));
      }
    }
  }

  #draw() {
    const { plot, data, curves } = this;
    if (!data) return;
    for (const strip of data.strips) {
      const count = strip.r.length;
      const d = lineThrough(
        2 * count, (k) => plot.x(strip.r[k < count ? k : 2 * count - 1 - k]),
        (k) => plot.y(k < count ? strip.low[k] : strip.high[2 * count - 1 - k]), true,
      );
      plot.inside.append(svg("path", { class: "region", d }));
    }
    this.#drawHoles();
    this.#drawTube();
    for (const edge of data.edges) {
      const d = lineThrough(edge.r.length, (k) => plot.x(edge.r[k]), (k) => plot.y(edge.u[k]));
      plot.inside.append(svg("path", { d, ...causeLook(edge.cause) }, svg("title", {}, edge.cause.text)));
    }
    this.#nameEdges();
    for (const event of data.events) {
      if (event.u === null) continue;
      plot.inside.append(svg(
        "text", { class: "event", x: plot.x(event.r), y: plot.y(event.u) + 4, "text-anchor": "middle" },
        MARKS[event.kind] ?? "·", svg("title", {}, event.text),
      ));
    }
    if (curves.rival) this.#curve(curves.rival, { class: "curve rival" });
    if (curves.motion) {
      this.#curve(curves.motion, { class: "curve grip" });
      this.#curve(curves.motion, { class: "curve" }, plot.inside, curves.motion.wrong);
    }
    this.#sayWrong();
    this.#drawHandles();
    this.bead = svg("circle", { class: "bead", r: 4.5 });
    plot.above.append(this.bead);
    this.#drawBead();
  }

  // What obstacles take: filled in their colour, and named where there is room.
  #drawHoles() {
    const { plot, data } = this, { left, right, top, bottom } = plot.inner;
    for (const hole of data.holes ?? []) {
      const group = svg("g", { class: `hole ${obstacleLook(hole.number)}`, "data-by": hole.by }, svg("title", {}, hole.short));
      for (const { r, low, high, ends } of hole.strips) {
        const count = r.length, x = (k) => plot.x(r[k]);
        group.append(svg("path", {
          class: "taken", d: lineThrough(2 * count, (k) => x(k < count ? k : 2 * count - 1 - k), (k) => plot.y(k < count ? low[k] : high[2 * count - 1 - k]), true),
        }));
        const open = (k, end) => (high[k] > low[k] ? plot.y(end[k]) : NaN);
        if (ends) for (const end of [low, high]) group.append(svg("path", { class: "rim", d: lineThrough(count, x, (k) => open(k, end)) }));
      }
      plot.inside.append(group);
    }
    this.named = [];
    for (const hole of data.holes ?? []) {
      const wide = 6.2 * hole.short.length + 8, y = clamp(plot.y(hole.at[1]) + 4, top + 12, bottom - 6);
      const x = clamp(plot.x(hole.at[0]), left + wide / 2, right - wide / 2);
      if (hole.size < 0.0005 * (data.range[1] - data.range[0]) || this.#isTaken(x, y, wide)) continue;
      this.named.push({ x, y, wide });
      plot.above.append(svg("text", { class: `hole-name ${obstacleLook(hole.number)}`, x, y, "text-anchor": "middle" }, hole.short));
    }
  }

  #isTaken(x, y, wide) {
    return this.named.some((other) => Math.abs(other.y - y) < 13 && Math.abs(other.x - x) < (other.wide + wide) / 2);
  }

  // What takes the place (r, u), if anything does.
  #holeAt(r, u) {
    const inside = (strip) => {
      const k = placeIn(strip.r, r);
      if (k >= strip.r.length || (k === 0 && strip.r[0] > r)) return false;
      const a = Math.max(k - 1, 0), part = (r - strip.r[a]) / (strip.r[k] - strip.r[a] || 1);
      const at = (end) => end[a] + part * (end[k] - end[a]);
      return at(strip.low) <= u && u <= at(strip.high);
    };
    return (this.data.holes ?? []).find((hole) => hole.strips.some(inside)) ?? null;
  }

  #drawTube() {
    for (const part of this.curves.tube ?? []) {
      if (part.branch !== this.branch || !part.polygons?.length) continue;
      let d = "";
      for (let k = 0; k < part.polygons.shape[0]; k += 1) {
        const corner = (i, axis) => part.polygons[(4 * k + i) * 2 + axis];
        d += lineThrough(4, (i) => this.plot.x(corner(i, 0)), (i) => this.plot.y(corner(i, 1)), true);
      }
      this.plot.inside.append(svg("path", { class: "tube", d }, svg("title", {}, "room for a better motion, if there is one")));
    }
  }

  // Each cause is named once, where its boundary has most room, and not on top of another name.
  #nameEdges() {
    const { plot, data } = this, { left, right, top, bottom } = plot.inner, named = new Set();
    const edges = [...data.edges].sort((a, b) => b.r.length - a.r.length);
    for (const edge of edges) {
      const text = edge.cause.short ?? edge.cause.text;
      if (named.has(text)) continue;
      const wide = 6.2 * text.length + 8;
      for (const part of [0.5, 0.3, 0.7, 0.15, 0.85]) {
        const k = Math.floor(part * (edge.r.length - 1));
        const x = clamp(plot.x(edge.r[k]), left + wide / 2, right - wide / 2), y = plot.y(edge.u[k]);
        if (!Number.isFinite(y) || y < top + 4 || y > bottom - 4) continue;
        const at = y > bottom - 20 ? y - 6 : y + 13;
        if (this.#isTaken(x, at, wide)) continue;
        this.named.push({ x, y: at, wide });
        named.add(text);
        plot.inside.append(svg("text", { class: `cause ${causeLook(edge.cause).class}`, x, y: at, "text-anchor": "middle" }, text));
        break;
      }
    }
  }

  #sayWrong() {
    const { plot, curves } = this, { left, right, top } = plot.inner;
    const long = ({ r }) => r[1] - r[0];
    const wrong = [...(curves.motion?.wrong ?? [])].sort((a, b) => long(b) - long(a)).slice(0, 2);
    wrong.forEach((part, k) => {
      const middle = (part.r[0] + part.r[1]) / 2;
      const text = `✕ ${part.text}`;
      const wide = Math.min(6.4 * text.length, right - left) / 2;
      plot.above.append(svg(
        "text", { class: "why", x: clamp(plot.x(middle), left + wide, right - wide), y: top + 14 + 15 * k, "text-anchor": "middle" }, text,
      ));
    });
  }

  #drawBead() {
    const motion = this.curves?.motion;
    if (!this.bead || !motion || this.r === undefined) { this.bead?.setAttribute("visibility", "hidden"); return; }
    const k = clamp(placeIn(motion.r, this.r), 0, motion.r.length - 1);
    for (const { value } of this.#copies(motion)) {
      const u = value(k), [low, high] = this.data.range;
      if (!(u >= low && u <= high)) continue;
      this.bead.setAttribute("cx", this.plot.x(this.r));
      this.bead.setAttribute("cy", this.plot.y(u));
      this.bead.removeAttribute("visibility");
      return;
    }
    this.bead.setAttribute("visibility", "hidden");
  }

  // Of a curve by hand: one handle per coefficient, that arrow keys move; only a few are drawn where there are many.
  #drawHandles() {
    const { hand, motion } = this.curves;
    if (!hand || !motion || this.view.acts.drag === undefined) return;
    if (this.scene.n_u === 1 && this.scene.branches[this.branch] !== hand.branch) return;
    const coefficients = hand.coefficients[this.component];
    if (!coefficients) return; // the panel is of an arm that was
    const places = placesOf(coefficients.length);
    const every = Math.max(1, Math.round(places.length / 12));
    places.forEach((r, index) => {
      if (index % every && index !== places.length - 1) return;
      const u = splineAt(coefficients, r);
      for (const { turn } of this.#copies(motion)) {
        const at = u + turn, [low, high] = this.data.range;
        if (at < low || at > high) continue;
        this.plot.above.append(svg("circle", {
          class: "handle", r: 5, cx: this.plot.x(r), cy: this.plot.y(at), tabindex: 0, role: "slider", "data-index": index,
          "aria-label": `curve at r = ${shown(r, 3)}`, "aria-valuenow": shown(u, 5), "aria-orientation": "vertical",
          "aria-valuetext": `u = ${shown(u, 5)} rad`,
          onkeydown: (event) => this.#key(event, r),
        }));
        break;
      }
    });
  }

  #key(event, r) {
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key], next = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (way) {
      event.preventDefault();
      const by = way * STEP * (event.shiftKey ? 10 : 1);
      this.view.acts.grab?.(this).then(() => {
        this.view.acts.drag({ component: this.component, r, by });
        this.view.acts.drop();
      });
    } else if (next) {
      event.preventDefault();
      const all = [...this.plot.above.querySelectorAll(".handle")];
      all[clamp(all.indexOf(event.target) + next, 0, all.length - 1)]?.focus();
    }
  }

  #hover(at) {
    this.view.acts.hover?.(at ? { r: at.x, u: at.y, panel: this, hole: this.#holeAt(at.x, at.y) } : null);
    if (at) this.plot.crosshair(at.x, at.y); else this.plot.crosshair(this.r ?? null);
  }

  #press(event) {
    if (event.button !== 0 || !this.plot.size) return;
    const at = this.plot.under(event);
    if (!at.inside) return;
    if (this.view.drawing) this.#drawFreehand(event);
    else if (this.view.acts.drag && event.target.closest(".grip, .handle")) this.#dragCurve(event);
    else this.view.acts.seek?.(clamp(at.x, 0, 1));
  }

  async #dragCurve(event) {
    const { acts } = this.view, { plot } = this, { x: r, y } = plot.under(event);
    event.preventDefault();
    let wanted = y, last = y, ready = false, released = false;
    const pull = () => {
      if (ready && wanted !== last) {
        acts.drag({ component: this.component, r: clamp(r, 0, 1), by: wanted - last });
        last = wanted;
      }
    };
    const move = (moved) => { wanted = plot.under(moved).y; pull(); };
    held(move, () => {
      released = true;
      if (ready) acts.drop();
    });
    await acts.grab(this);
    ready = true;
    pull();
    if (released) acts.drop();
  }

  #drawFreehand(event) {
    const { plot } = this, points = [], trace = svg("path", { class: "trace" });
    event.preventDefault();
    plot.above.append(trace);
    const move = (moved) => {
      const { x, y } = plot.under(moved);
      points.push([clamp(x, 0, 1), y]);
      trace.setAttribute("d", lineThrough(points.length, (k) => plot.x(points[k][0]), (k) => plot.y(points[k][1])));
    };
    held(move, () => {
      trace.remove();
      if (points.length > 2) this.view.acts.draw?.({ branch: this.branch, component: this.component, points });
    });
    move(event);
  }
}
