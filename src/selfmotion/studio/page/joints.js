// Joint angles along the path, with the limits that are near them.

import { jointLook, jointName } from "selfmotion/looks";
import { rowAt, shown, TAU } from "selfmotion/numbers";
import { Plot } from "selfmotion/plot";
import { html, lineThrough, svg } from "selfmotion/svg";

export class JointsView {
  #hidden = new Set();

  constructor(place, acts = {}) {
    this.legend = html("div", { class: "legend", role: "group", "aria-label": "joints shown" });
    this.plot = new Plot(place, { label: "joint angles along the path", hover: (at) => acts.hover?.(at ? { r: at.x } : null) });
    this.plot.draws(() => this.#draw());
    this.plot.root.addEventListener("pointerdown", (event) => {
      const at = this.plot.size && this.plot.under(event);
      if (at?.inside) acts.seek?.(at.x);
    });
    place.append(this.legend);
  }

  show(scene, motion) {
    const renamed = this.scene?.n !== scene.n;
    Object.assign(this, { scene, motion });
    if (renamed) this.#hidden.clear();
    this.plot.yName = scene.slides?.some((slides) => slides) ? "joints [rad, m]" : "joint angle [rad]";
    this.#scale();
    this.plot.redraw();
    if (renamed) this.#name();
    this.mark(this.r ?? 0);
  }

  mark(r) {
    this.r = r;
    this.plot.crosshair(r);
    const q = this.motion && rowAt(this.motion.r, this.motion.q, r);
    for (const [k, output] of [...this.legend.querySelectorAll("output")].entries()) output.textContent = q ? shown(q[k], 4) : "";
  }

  #scale() {
    const { q } = this.motion ?? { q: null };
    let low = Infinity, high = -Infinity;
    for (let k = 0; k < (q?.length ?? 0); k += 1) {
      if (this.#hidden.has(k % this.scene.n)) continue;
      if (q[k] < low) low = q[k];
      if (q[k] > high) high = q[k];
    }
    if (low > high) [low, high] = [-Math.PI, Math.PI];
    const near = this.scene.limits.flatMap((limit, k) => (this.#hidden.has(k) ? [] : limit ?? [])).filter((value) => value !== null);
    const seen = near.filter((value) => value > low - 0.35 * TAU && value < high + 0.35 * TAU);
    low = Math.min(low, ...seen);
    high = Math.max(high, ...seen);
    const room = 0.06 * (high - low || 1);
    this.plot.scaled([0, 1], [low - room, high + room]);
  }

  #name() {
    this.legend.replaceChildren(...Array.from({ length: this.scene.n }, (_, k) => html(
      "button", {
        type: "button", "aria-pressed": "true", title: `${this.scene.joints?.[k] ?? jointName(this.scene, k)}: show or hide`,
        onclick: (event) => {
          if (this.#hidden.has(k)) this.#hidden.delete(k); else this.#hidden.add(k);
          event.currentTarget.setAttribute("aria-pressed", String(!this.#hidden.has(k)));
          this.#scale();
          this.plot.redraw();
        },
      },
      svg("svg", { viewBox: "0 0 26 6", width: 26, height: 6, "aria-hidden": "true" }, svg("path", { d: "M0 3H26", ...jointLook(k) })),
      html("span", {}, jointName(this.scene, k)), html("output", {}),
    )));
  }

  #draw() {
    const { plot, scene, motion } = this;
    if (!scene) return;
    const { left, right } = plot.inner;
    scene.limits.forEach((limit, joint) => {
      for (const value of this.#hidden.has(joint) ? [] : limit ?? []) {
        if (value === null) continue;
        const look = jointLook(joint);
        plot.inside.append(svg("path", { ...look, class: `limit ${look.class}`, d: `M${left} ${plot.y(value)}H${right}` },
          svg("title", {}, `limit of ${jointName(scene, joint)}: ${shown(value)}`)));
      }
    });
    if (!motion) return;
    for (let joint = 0; joint < scene.n; joint += 1) {
      if (this.#hidden.has(joint)) continue;
      const d = lineThrough(motion.r.length, (k) => plot.x(motion.r[k]), (k) => plot.y(motion.q[k * scene.n + joint]));
      plot.inside.append(svg("path", { d, ...jointLook(joint), class: `series ${jointLook(joint).class}` },
        svg("title", {}, jointName(scene, joint))));
    }
    for (const part of motion.wrong ?? []) {
      const from = plot.x(part.r[0]), to = Math.max(plot.x(part.r[1]), from + 2);
      plot.inside.append(svg("rect", { class: "wrong-band", x: from, y: plot.inner.top, width: to - from, height: plot.inner.bottom - plot.inner.top }, svg("title", {}, part.text)));
    }
  }
}
