// A report that was sent: the studio's pictures of one plan, to look at, with no server behind them.

import { ArmView } from "selfmotion/arm";
import { DomainView } from "selfmotion/domain";
import { EvolutionView } from "selfmotion/evolution";
import { hovered } from "selfmotion/hover";
import { JointsView } from "selfmotion/joints";
import { clamp, shown, unpacked } from "selfmotion/numbers";
import { Player } from "selfmotion/player";
import { SpaceView } from "selfmotion/space";
import { html } from "selfmotion/svg";
import { planParts } from "selfmotion/verdict";

const $ = (selector) => document.querySelector(selector);
const { scene, domain, plan, problem, stored } = unpacked(JSON.parse($("#data").textContent));
const player = new Player();

const seek = (r) => { player.stop(); player.seek(clamp(r, 0, 1)); };
const hover = (at) => { $("#domain-readout").textContent = at ? hovered(at, plan.motion, scene) : ""; };
const arm = scene.dimension === 3 ? new SpaceView($("#arm-view")) : new ArmView($("#arm-view"));
const domainView = domain && new DomainView($("#domain-view"), { hover, seek });
const joints = new JointsView($("#joints-view"), { hover, seek });
const evolution = new EvolutionView($("#evolution-view"), $("#evolution-said"));

$("#verdict").replaceChildren(...planParts(plan, scene));
arm.mode = "look";
arm.show(scene, plan.motion);
domainView?.show(scene, domain, { motion: plan.motion, rival: null, tube: plan.tube, hand: null });
if (!domainView) $("#domain").hidden = true;
joints.show(scene, plan.motion);
evolution.show(plan.history, plan.levels);
if (!evolution.lines.length) $("#evolution").hidden = true;
player.addEventListener("moved", () => {
  arm.mark(player.r);
  joints.mark(player.r);
  domainView?.mark(player.r);
});
player.seek(0);
$("#ghosts").addEventListener("change", () => { arm.ghosts = $("#ghosts").checked; arm.redraw(); });
addEventListener("keydown", (event) => {
  if (event.key === " " && !event.target.closest?.("button, input, summary")) { event.preventDefault(); player.toggle(); }
});

const NAMES = {
  cost: "cost, the objective as an integral", cost_error: "error of the cost, at most", cost_sampled: "the same as a chord sum over the samples",
  lower_bound: "lower bound: no motion costs less", gap: "relative gap", l1_travel: "Σ∫|θ′| dr", l2_travel: "∫‖θ′‖ dr", l2_waypoints: "Σ‖Δθ‖ over the given points",
  max_tracking_error: "tool off the path, at most", min_limit_margin: "nearest a joint gets to a limit", max_joint_step: "largest joint step between samples",
  reconfigurations: "reconfigurations", planner: "planner", evaluations: "evaluations", wall_time_s: "planning time [s]", version: "selfmotion",
};
for (const [check, left] of Object.entries(plan.summary.margins ?? {})) {
  NAMES[`left_${check}`] = check === "clearance" ? "clearance left beyond what is asked for, at least" : `${check} left, at least`;
  plan.summary[`left_${check}`] = left;
}
const rows = Object.entries(NAMES).filter(([name]) => plan.summary[name] !== null && plan.summary[name] !== undefined);
$("#figures").replaceChildren(...rows.map(([name, text]) => {
  const value = plan.summary[name];
  return html("tr", {}, html("th", { scope: "row" }, text), html("td", {}, typeof value === "number" ? shown(value, 10) : String(value)));
}));
$("#structure-lines").replaceChildren(...[...(scene.warnings ?? []), ...(domain?.structure ?? [])].map((line) => html("li", {}, line)));
$("#happens").hidden = !$("#structure-lines").children.length;
$("#source").textContent = problem;
$("#settings").textContent = JSON.stringify(plan.summary.parameters, null, 1);
if (stored) {
  $("#stored").append(html("a", { download: "plan.json", href: URL.createObjectURL(new Blob([stored], { type: "application/json" })) }, "the plan as a file"), " for selfmotion time");
}
