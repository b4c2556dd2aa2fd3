// The curve of a motion taken in hand: bent by drags and by keys, or drawn anew.

import { TAU } from "selfmotion/numbers";
import { ask } from "selfmotion/requests";
import { moved } from "selfmotion/spline";

const MOST_ROWS = 500;

export class CurveByHand {
  // `motion()` is the one shown, `reach()` how far along the path a drag bends it.
  constructor(model, scene, motion, reach) {
    Object.assign(this, { model, scene, motion, reach });
  }

  // Have a curve in hand: the one that is, or one that follows the motion shown on the panel's branch.
  async grab({ branch }) {
    const { hand, problem } = this.model.state, name = this.scene().branches[branch];
    if (hand && (hand.branch === name || this.scene().n_u > 1) && this.motion()?.kind === "hand") return;
    const rows = rowsOn(this.motion(), this.scene().n_u > 1 ? null : branch);
    if (!rows) return;
    const at = this.scene().n_u > 1 ? this.scene().branches[this.motion().branch[0]] : name;
    const found = await ask("fit", { problem, branch: at, ...rows });
    this.model.change({ hand: found.hand }, false);
  }

  drag({ component, r, by }) {
    const { hand, problem } = this.model.state, kept = [problem.start, problem.end].map(Boolean);
    if (!hand) return;
    const coefficients = hand.coefficients.map((row, k) => (k === component ? moved(row, r, by, this.reach(), kept) : row));
    this.model.change({ hand: { ...hand, coefficients } }, false);
  }

  drop() {
    this.model.change({}, true);
  }

  // A curve drawn freehand over the panel of a branch and a component.
  async draw({ branch, component, points }) {
    const scene = this.scene(), sorted = [...points].sort((a, b) => a[0] - b[0]);
    const count = 200, old = this.motion() && rowsOn(this.motion(), null);
    const r = Array.from({ length: count }, (_, k) => k / (count - 1));
    const u = r.map((at) => Array.from({ length: scene.n_u }, (_, k) => (k === component ? heldAt(sorted, at) : old ? heldAt(old.r.map((x, i) => [x, old.u[i][k]]), at) : 0)));
    const found = await ask("fit", { problem: this.model.state.problem, branch: scene.branches[branch], r, u });
    this.model.change({ hand: found.hand });
  }
}

// Rows of a motion on one branch (on any: null), no more than needed, u continuous, held where the branch is another.
function rowsOn(motion, branch) {
  if (!motion) return null;
  const columns = motion.u.shape[1], every = Math.max(1, Math.floor(motion.r.length / MOST_ROWS)), r = [], u = [];
  for (let k = 0; k < motion.r.length; k += k + every < motion.r.length || k === motion.r.length - 1 ? every : motion.r.length - 1 - k) {
    if (branch !== null && motion.branch[k] !== branch) continue;
    const here = Array.from(motion.u.subarray(k * columns, (k + 1) * columns));
    if (!here.every(Number.isFinite)) continue;
    const last = u.at(-1);
    r.push(motion.r[k]);
    u.push(last ? here.map((value, j) => value - TAU * Math.round((value - last[j]) / TAU)) : here);
  }
  if (!r.length) return null;
  if (r[0] > 0) { r.unshift(0); u.unshift(u[0]); }
  if (r.at(-1) < 1) { r.push(1); u.push(u.at(-1)); }
  return { r, u };
}

// The value at a place between points sorted by place; beyond the ends it stays.
function heldAt(points, at) {
  if (at <= points[0][0]) return points[0][1];
  for (let k = 1; k < points.length; k += 1) {
    if (at <= points[k][0]) {
      const [[a, p], [b, q]] = [points[k - 1], points[k]];
      return b > a ? p + ((at - a) / (b - a)) * (q - p) : q;
    }
  }
  return points.at(-1)[1];
}
