// Exact numbers at a place under the pointer.

import { jointName } from "selfmotion/looks";
import { clamp, placeIn, row, shown } from "selfmotion/numbers";

export function hovered({ r, u, panel: on, hole }, motion, scene) {
  const parts = [u === undefined ? `r = ${shown(r, 4)}` : `pointer: r = ${shown(r, 4)}, u = ${shown(u, 5)}`];
  if (hole) parts.push(`taken: ${hole.short}`);
  if (motion) {
    const k = clamp(placeIn(motion.r, r), 0, motion.r.length - 1);
    const joints = Array.from(row(motion.q, k), (value, j) => `${jointName(scene, j)} = ${shown(value, 7)}`).join(", ");
    parts.push(`at r = ${shown(motion.r[k], 6)}: u = ${Array.from(row(motion.u, k), (value) => shown(value, 9)).join(", ")}`, joints);
    if (scene.n_u === 1 && on && motion.branch[k] !== on.branch) parts.push(`on ${scene.branches[motion.branch[k]]}`);
  }
  return parts.join(" · ");
}
