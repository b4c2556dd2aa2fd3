// One line that says how things stand.

import { percent, shown } from "selfmotion/numbers";
import { html } from "selfmotion/svg";

const figure = (name, value, title = "") => html("span", { class: "figure", title }, html("small", {}, name), ` ${value}`);

// What is left of constraints beyond joint limits.
const NAMES = { clearance: "clearance left", singularity: "singular value left" };
const leftOver = (margins, scene) => Object.entries(margins ?? {}).map(([check, left]) => figure(
  NAMES[check] ?? check, `${shown(left, 3)}${check === "clearance" && scene?.length_unit ? ` ${scene.length_unit}` : ""}`, "beyond what is asked for, where it is least",
));

// What is wrong and what to do, of an error.
export function failureParts(failure) {
  const status = { infeasible: "no motion exists", unknown: "undecided", error: "cannot be" }[failure.status] ?? "cannot be";
  const needs = (failure.needs ?? []).slice(0, 2).map((need) => html("span", { class: "figure" }, need));
  return [chip(status, failure.status ?? "error"), html("p", { class: "said" }, failure.remedy ? `${failure.message}; ${failure.remedy}` : failure.message), ...needs];
}

export const chip = (text, kind) => html("span", { class: `chip ${kind}` }, text);

// The figures of a plan.
export function planParts({ summary, verdict, motion }, scene) {
  const unit = scene?.unit ?? "rad";
  const unproved = scene?.n_u === 1 ? "how far from the best possible is not known: planner global proves it" : "how far from the best possible is not known";
  const proved = summary.lower_bound !== null;
  const parts = [
    chip(motion.holds ? `solved by ${summary.planner}` : "does not hold", motion.holds ? "solved" : "error"),
    html("p", { class: "said" }, verdict ?? (motion.holds ? unproved : motion.wrong[0]?.text ?? "")),
    figure("cost", shown(summary.cost, 9), "the objective as an integral"),
    proved ? figure("lower bound", shown(summary.lower_bound, 9), "no motion costs less") : null,
    figure("chord sum", shown(summary.cost_sampled, 9), "the seed's F over the samples"),
    figure("tool off the path", shown(summary.max_tracking_error, 2)),
    summary.min_limit_margin === null ? null : figure("nearest limit", `${shown(summary.min_limit_margin, 4)} ${unit}`),
    ...leftOver(summary.margins, scene),
    figure("time", `${shown(summary.wall_time_s, 3)} s`),
  ];
  return parts.filter((part) => part !== null);
}

// The figures of a curve moved by hand, or of the seed's sinusoid, beside what was proved of every motion.
export function curveParts(motion, name, bound, scene) {
  if (motion.wrong.length) {
    const worst = motion.wrong.reduce((a, b) => (b.r[1] - b.r[0] > a.r[1] - a.r[0] ? b : a));
    const more = motion.wrong.length > 1 ? ` (and ${motion.wrong.length - 1} more)` : "";
    const where = worst.r[1] > worst.r[0] ? `r from ${shown(worst.r[0], 3)} to ${shown(worst.r[1], 3)}` : `r = ${shown(worst.r[0], 3)}`;
    return [chip("not a motion", "error"), html("p", { class: "said" }, `${name}: ${worst.text} for ${where}${more}`)];
  }
  const cost = motion.cost ?? motion.cost_sampled; // while it is dragged the sum of chords may have to do
  const off = bound && cost ? Math.max(cost - bound.value, 0) / bound.value : null;
  const said = off === null
    ? scene.n_u === 1 ? "plan with planner global to see how far it is from the best possible" : "nothing is proved of other motions"
    : `at most ${percent(off)} above the best possible`;
  return [
    chip(name, "hand"), html("p", { class: "said" }, `cost ${shown(cost, 6)}, ${said}`),
    motion.cost === null ? null : figure("cost", shown(motion.cost, 9)), bound ? figure("lower bound", shown(bound.value, 9)) : null,
    figure("chord sum", shown(motion.cost_sampled, 9)),
    ...leftOver(motion.margins, scene),
    motion.margin === null || motion.margin === undefined ? null : figure("nearest limit", `${shown(motion.margin, 4)} ${scene.unit}`),
  ].filter((part) => part !== null);
}
