// How a search goes on: the best cost against generations or rounds while it runs, and what was proved of it.

import { shown } from "selfmotion/numbers";
import { Plot } from "selfmotion/plot";
import { lineThrough, svg } from "selfmotion/svg";

export class EvolutionView {
  // What is said of the search in words goes to `said`.
  constructor(place, said, acts = {}) {
    this.said = said;
    this.plot = new Plot(place, {
      label: "how the search went on", xName: "generation", yName: "cost", hover: (at) => acts.hover?.(at ? this.#near(at.x) : null),
    });
    this.plot.draws(() => this.#draw());
    this.clear();
  }

  clear(said = "none yet") {
    this.best = [];
    this.lines = [];
    this.said.textContent = said;
    this.#scale();
  }

  // A step of a search that is running.
  step({ done, total, best }) {
    if (best !== null) this.best.push([done, best]);
    this.lines = [{ name: "best so far", points: this.best, look: "best" }];
    this.plot.xName = "generation or round";
    this.said.textContent = total ? `${done} of ${total}` : `round ${done}`;
    this.#scale();
  }

  // A search that is over: its history per branch, or the rounds of a proof.
  show(history, levels) {
    if (levels?.length) {
      this.lines = [
        { name: "best motion", points: levels.map((level, k) => [k + 1, level.cost]), look: "best" },
        { name: "proved bound", points: levels.map((level, k) => [k + 1, level.bound > 0 ? level.bound : null]), look: "bound" },
      ];
      this.plot.xName = "round of the proof";
      this.said.textContent = "";
    } else if (history?.length) {
      this.lines = history.flatMap((one, k) => [
        { name: "mean", points: one.mean.map((value, i) => [i + 1, value]), look: "mean" },
        { name: "best so far", points: one.best.map((value, i) => [i + 1, value]), look: "best" },
      ]);
      this.plot.xName = "generation";
      this.said.textContent = "";
    } else {
      this.lines = [];
      this.said.textContent = "this planner tells no history";
    }
    this.#scale();
  }

  #scale() {
    this.plot.root.toggleAttribute("data-empty", !this.lines.some(({ points }) => points.length));
    let low = Infinity, high = -Infinity, last = 1;
    for (const { points, look } of this.lines) {
      for (const [x, y] of points) {
        last = Math.max(last, x);
        if (y === null || !Number.isFinite(y)) continue;
        low = Math.min(low, y);
        if (look !== "mean" || x > 3) high = Math.max(high, y);
      }
    }
    if (low > high) [low, high] = [0, 1];
    const room = 0.08 * (high - low) || 0.01 * Math.abs(high) || 1;
    this.plot.scaled([this.lines.some(({ points }) => points.length > 1) ? 1 : 0, Math.max(last, 2)], [low - room, high + room]);
    this.plot.redraw();
  }

  #near(x) {
    const said = this.lines.flatMap(({ name, points }) => {
      const found = points.findLast(([at]) => at <= x + 0.5);
      return found && found[1] !== null ? [`${name} ${shown(found[1], 9)}`] : [];
    });
    return said.length ? { text: `${Math.round(x)}: ${said.join(", ")}` } : null;
  }

  #draw() {
    const { plot } = this, seen = new Set();
    let named = plot.inner.right;
    for (const { name, points, look } of this.lines) {
      const d = lineThrough(points.length, (k) => plot.x(points[k][0]), (k) => (points[k][1] === null ? NaN : plot.y(points[k][1])));
      plot.inside.append(svg("path", { d, class: `evolution ${look}` }, svg("title", {}, name)));
      if (points.length === 1 && points[0][1] !== null) {
        plot.inside.append(svg("circle", { class: `evolution-dot ${look}`, cx: plot.x(points[0][0]), cy: plot.y(points[0][1]), r: 3 }));
      }
      if (seen.has(look)) continue;
      seen.add(look);
      plot.above.append(
        svg("text", { class: "key", x: named, y: 13, "text-anchor": "end" }, name),
        svg("path", { d: `M${named - 6.2 * name.length - 22} 9H${named - 6.2 * name.length - 6}`, class: `evolution ${look}` }),
      );
      named -= 6.2 * name.length + 34;
    }
  }
}
