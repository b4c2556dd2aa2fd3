// The studio's page: the parts, and how they hear of one another.

import { ArmView } from "selfmotion/arm";
import { CurveByHand } from "selfmotion/curve_by_hand";
import { copyLink, exportDialog, openDialog, saveDialog, tell } from "selfmotion/dialogs";
import { DomainView } from "selfmotion/domain";
import { EvolutionView } from "selfmotion/evolution";
import { Forms } from "selfmotion/forms";
import { hovered } from "selfmotion/hover";
import { JointsView } from "selfmotion/joints";
import { Live } from "selfmotion/live";
import { Model, stateIn, taskOf } from "selfmotion/model";
import { clamp, row, shown } from "selfmotion/numbers";
import { pictureOf } from "selfmotion/picture";
import { Planning } from "selfmotion/planning";
import { Player } from "selfmotion/player";
import { beginnings, lines, ProblemPanel } from "selfmotion/problem_panel";
import { ask } from "selfmotion/requests";
import { SpaceView } from "selfmotion/space";
import { html } from "selfmotion/svg";
import { chip, curveParts, failureParts, planParts } from "selfmotion/verdict";

const $ = (selector) => document.querySelector(selector);
const CURVES = { plan: "plan", hand: "by hand", sinusoid: "sinusoid" };
const AROUND = 160; // rows of a motion that the domains of many links are looked at around

const model = new Model(), live = new Live(), planning = new Planning(), player = new Player();
let curve = null; // which of CURVES is shown

const scene = () => live.scene;
const plan = () => planning.planFor(model.state.problem);
const available = () => Object.keys(CURVES).filter((name) => ({
  plan: plan(), hand: model.state.hand, sinusoid: model.state.problem?.planner?.kind === "sinusoid" && model.state.frequency,
})[name]);
const motion = () => (curve === "plan" ? plan()?.motion : live.motion?.kind === curve ? live.motion : null) ?? null;
const shownMotion = () => motion() ?? (curve !== "plan" ? live.motion : null);

// Views

const spot = (at) => {
  player.stop();
  player.seek(clamp(at, 0, 1));
};
const byHand = new CurveByHand(model, scene, shownMotion, () => $("#reach").valueAsNumber);
const grab = (panel) => byHand.grab(panel).catch((error) => tell("The curve cannot be taken in hand", error));
const tellOf = (at) => { $("#domain-readout").textContent = at ? hovered(at, shownMotion(), scene()) : ""; };
const domainView = new DomainView($("#domain-view"), {
  hover: tellOf,
  seek: spot,
  grab,
  drag: (by) => byHand.drag(by),
  drop: () => byHand.drop(),
  draw: async (drawn) => {
    await byHand.draw(drawn).catch((error) => tell("The curve cannot be drawn", error));
    setDrawing(false);
  },
});
const joints = new JointsView($("#joints-view"), { hover: tellOf, seek: spot });
const evolution = new EvolutionView($("#evolution-view"), $("#evolution-said"), { hover: (at) => { $("#evolution-readout").textContent = at?.text ?? ""; } });
let armView = null, panel = null;

function armFor(found) {
  const wanted = found.dimension === 3 ? SpaceView : ArmView;
  if (armView instanceof wanted) return;
  armView = new wanted($("#arm-view"), {
    path: (k, at, settled) => movePath(k, at, settled),
    link: (k, length, settled) => changeArm((arm) => ({ ...arm, links: arm.links.map((old, j) => (j === k ? rounded(renewed(length, old)) : old)) }), settled),
    limit: (k, side, value, settled) => changeArm((arm) => ({
      ...arm, limits: arm.limits.map((old, j) => (j === k ? old.map((end, s) => (s === side ? rounded(renewed(value, end)) : end)) : old)),
    }), settled),
    obstacle: (k, what, settled) => changeObstacle(k, what, settled),
    freehand: (points) => {
      const { direction } = model.state.problem.path;
      const path = { kind: "waypoints", points: points.map((point) => point.map(rounded)), interpolation: "spline" };
      model.change({ problem: { ...model.state.problem, path: direction === undefined ? path : { ...path, direction } }, hand: null });
      setMode("path");
    },
  });
  const planar = found.dimension === 2;
  $("#arm-modes").hidden = $("#whole-label").hidden = !planar;
  armView.ghosts = $("#ghosts").checked;
}

const rounded = (value) => Number(value.toPrecision(5));

const renewed = (value, old) => (typeof value === "function" ? value(old) : value);

function changeArm(what, settled) { model.changeProblem({ arm: what(model.state.problem.arm) }, settled); }

function changeObstacle(k, what, settled) {
  const { obstacles } = model.state.problem;
  model.changeProblem({ obstacles: obstacles.map((old, j) => (j === k ? roundedAll(what(old)) : old)) }, settled);
}

const roundedAll = (value) => {
  if (typeof value === "number") return rounded(value);
  if (Array.isArray(value)) return value.map(roundedAll);
  return value && typeof value === "object" ? Object.fromEntries(Object.entries(value).map(([name, inner]) => [name, roundedAll(inner)])) : value;
};

function movePath(k, at, settled) {
  const { path } = model.state.problem, name = { bezier: "control_points", waypoints: "points" }[path.kind], end = k ? "end" : "start";
  const moved = (old) => [...renewed(at, old).map(rounded), ...old.slice(2)];
  const changed = name ? { [name]: path[name].map((old, j) => (j === k ? moved(old) : old)) } : { [end]: moved(path[end]) };
  model.changeProblem({ path: { ...path, ...changed } }, settled);
}

function setMode(mode) {
  armView.mode = mode;
  for (const button of $("#arm-modes").children) button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
  $("#arm-view").dataset.mode = mode;
  armView.redraw(true);
}

function setDrawing(on) {
  domainView.drawing = on;
  $("#draw-curve").setAttribute("aria-pressed", String(on));
  $("#domain-view").classList.toggle("drawing", on);
}

// What is shown follows from the state, from what was looked at, and from the plan.

function showAll(settled = true) {
  const { problem, hand, frequency, file } = model.state;
  if (!problem) return;
  const choices = available();
  if (!choices.includes(curve)) curve = choices[0] ?? null;
  $("#file").textContent = file ?? "";
  $("#undo").disabled = !model.canUndo;
  $("#redo").disabled = !model.canRedo;
  showVerdict();
  if (settled) panel?.show();
  showSearch();
  if (!live.scene) return;
  const stale = live.failure !== null && live.task !== taskOf(problem); // the pictures are of an earlier problem
  document.querySelector("main").classList.toggle("stale", stale);
  const now = shownMotion(), found = stale ? null : plan();
  if (stale && curve === "plan") { showCurves(choices); return; }
  armFor(live.scene);
  armView.show(live.scene, now, { refit: settled });
  joints.show(live.scene, now);
  if (live.domain) {
    const rival = curve !== "plan" && found ? found.motion : null;
    domainView.show(live.scene, live.domain, { motion: now, rival, tube: found?.tube ?? null, hand: curve === "hand" && hand.coefficients.length === live.scene.n_u ? hand : null });
  }
  $("#domain-view").classList.toggle("waiting", !live.domain);
  $("#reach-label").classList.toggle("away", curve !== "hand");
  showCurves(choices);
  const sinusoid = problem.planner?.kind === "sinusoid" && frequency;
  $("#frequency-bar").classList.toggle("away", !sinusoid);
  if (sinusoid) {
    const { optimizer } = problem.planner;
    const bounds = [(optimizer?.optimizer ?? optimizer)?.bounds ?? [0, 15]].flat(2);
    $("#frequency").min = Math.min(...bounds);
    $("#frequency").max = Math.max(...bounds);
    $("#frequency").value = frequency[0];
    $("#frequency-value").textContent = shown(frequency[0], 6);
  }
  $("#structure-lines").replaceChildren(...lines([...(live.scene.warnings ?? []), ...live.scene.blocked.map((part) => part.text), ...(live.domain?.structure ?? [])]));
  player.seek(player.r);
}

async function takeInHand() {
  const { branch } = motion();
  await grab({ branch: branch[Math.floor(branch.length / 2)] });
  byHand.drop();
}

let searched = null; // the plan whose search is shown

function showSearch() {
  const found = plan();
  if (planning.isRunning || found === searched) return;
  searched = found;
  if (found) evolution.show(found.history, found.levels); else evolution.clear();
}

function showCurves(choices) {
  $("#curves").hidden = choices.length === 0;
  const buttons = choices.map((name) => html("button", {
    type: "button", "data-curve": name, "aria-pressed": String(name === curve), onclick: () => { curve = name; look(true); showAll(); },
  }, CURVES[name]));
  if (!model.state.hand && motion() && live.domain?.panels.length) {
    buttons.push(html("button", { type: "button", title: "take this curve in hand: then points on it can be moved by drags and arrow keys", onclick: takeInHand }, "take in hand"));
  }
  if (model.state.hand) {
    buttons.push(html("button", { type: "button", title: "drop the curve by hand", "aria-label": "drop the curve by hand", onclick: () => model.change({ hand: null }) }, "✕"));
  }
  $("#curves").replaceChildren(...buttons);
}

function showVerdict() {
  const place = $("#verdict"), { problem } = model.state, now = motion();
  const failed = planning.failure?.problem === JSON.stringify(withPlanner(problem)) ? planning.failure : null;
  const blocked = live.scene?.blocked ?? [];
  let parts;
  if (live.failure) parts = failureParts(live.failure);
  else if (planning.isRunning) parts = [chip("planning", "hand"), html("p", { class: "said" }, "in a process of its own: you may go on, and cancel at any time; the first plan with a kind of arm is compiled first, up to a minute")];
  else if (failed) parts = failureParts(failed);
  else if (curve === "plan" && plan()) parts = planParts(plan(), live.scene);
  else if (blocked.length && !now) parts = [chip("no motion exists", "infeasible"), html("p", { class: "said" }, blocked[0].text)];
  else if (live.domain?.connected === false) {
    parts = [chip("no motion exists", "infeasible"), html("p", { class: "said" }, live.domain.structure.at(-1))];
  } else if (now) parts = curveParts(now, CURVES[curve], planning.boundFor(problem), live.scene);
  else parts = [chip("ready", "hand"), html("p", { class: "said" }, "Plan finds a motion; or draw one in the angle domain")];
  place.replaceChildren(...parts);
}

function look(settled) {
  if (!model.state.problem) return;
  const found = plan(), many = (live.scene?.n_u ?? 1) > 1;
  live.update(model.state, settled, curve, many && curve === "plan" && found ? thinned(found.motion) : null);
}

function thinned({ r, u, branch }) {
  const every = Math.max(1, Math.floor(r.length / AROUND)), rows = [];
  for (let k = 0; k < r.length; k += every) rows.push(k);
  return { r: rows.map((k) => r[k]), u: rows.map((k) => Array.from(row(u, k))), branch: branch[0] };
}

// Events

let hadHand = false;

model.addEventListener("change", ({ detail: { settled } }) => {
  const hasHand = model.state.hand !== null;
  if (hasHand && !hadHand) curve = "hand"; // by undo and redo too
  hadHand = hasHand;
  if (curve === "plan" && !plan()) curve = null;
  const choices = available();
  if (!choices.includes(curve)) curve = choices.find((name) => name !== "plan") ?? choices[0] ?? null;
  look(settled);
  if (settled) showAll();
});
live.addEventListener("seen", ({ detail: { settled } }) => showAll(settled));
player.addEventListener("moved", () => {
  armView?.mark(player.r);
  joints.mark(player.r);
  domainView.mark(player.r);
});
planning.addEventListener("started", () => {
  searched = null;
  evolution.clear("starting");
  showRunning();
});
planning.addEventListener("step", ({ detail }) => {
  evolution.step(detail);
  if (detail.total) { $("#progress").max = detail.total; $("#progress").value = detail.done; } else $("#progress").removeAttribute("value");
});
planning.addEventListener("finished", ({ detail: { problem } }) => {
  const found = planning.planFor(problem);
  if (plan() === found) curve = "plan";
  showRunning();
  domainView.reveal();
  look(true);
});
planning.addEventListener("failed", showRunning);
planning.addEventListener("cancelled", () => {
  evolution.clear("cancelled");
  showRunning();
});

function showRunning() {
  const running = planning.isRunning;
  $("#plan").hidden = running;
  $("#cancel").hidden = $("#progress").hidden = !running;
  if (running) $("#progress").removeAttribute("value");
  showAll();
}

$("#plan").addEventListener("click", () => model.state.problem && planning.run(withPlanner(model.state.problem)));
$("#cancel").addEventListener("click", () => planning.cancel());
$("#undo").addEventListener("click", () => model.undo());
$("#redo").addEventListener("click", () => model.redo());
$("#open").addEventListener("click", () => openDialog(use));
$("#save").addEventListener("click", () => saveDialog(model.state, (file) => model.change({ file })));
$("#link").addEventListener("click", async () => {
  if (!await copyLink(await model.link())) return;
  $("#link").textContent = "Link copied";
  setTimeout(() => { $("#link").textContent = "Copy link"; }, 2500);
});
$("#export").addEventListener("click", () => exportDialog(exported(), () => pictureOf($("#domain-view")), live.scene?.dimension === 2));
$("#ghosts").addEventListener("change", () => { armView.ghosts = $("#ghosts").checked; armView.redraw(); });
$("#whole").addEventListener("change", () => { armView.wholeReach = $("#whole").checked; armView.redraw(true); });
$("#arm-modes").addEventListener("click", ({ target }) => target.dataset.mode && setMode(target.dataset.mode));
$("#draw-curve").addEventListener("click", () => setDrawing(!domainView.drawing));
$("#frequency").addEventListener("input", () => {
  curve = "sinusoid";
  model.change({ frequency: [$("#frequency").valueAsNumber] }, false);
});
$("#frequency").addEventListener("change", () => model.change({ frequency: [$("#frequency").valueAsNumber] }));
addEventListener("keydown", (event) => {
  const typing = event.target.matches?.("input:not([type=range]):not([type=checkbox]), textarea, select");
  if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !typing) {
    event.preventDefault();
    if (event.shiftKey) model.redo(); else model.undo();
  } else if (event.key === " " && !event.target.closest?.("button, input, textarea, select, summary, dialog")) {
    event.preventDefault();
    player.toggle();
  }
});
addEventListener("hashchange", () => fromLink().catch((error) => tell("This link cannot be read", damaged(error))));

const withPlanner = (problem) => (problem.planner ? problem : { ...problem, planner: { kind: (scene()?.n_u ?? 1) > 1 ? "refine" : "global" } });

function exported() {
  const { problem, hand } = model.state;
  if (curve === "hand" && hand) return { problem: { ...problem, planner: undefined }, hand };
  return plan() ? { problem, plan: plan().plan } : null;
}

function use({ problem, file = null }) {
  curve = null;
  planning.failure = null;
  model.change({ problem, file, hand: null, frequency: problem.planner?.kind === "sinusoid" ? [1] : null });
}

async function fromLink() {
  const found = await stateIn(location.hash);
  if (found) { curve = found.hand ? "hand" : null; model.change(found); }
  return found;
}

const damaged = (error) => (error.data ? error : { data: { message: "it is damaged or cut off", remedy: "copy it again" } });

const startOf = () => {
  const now = shownMotion();
  return now ? Array.from(row(now.u, 0), rounded) : Array(scene()?.n_u ?? 1).fill(0);
};

const PATIENCE = 2500; // before the page says what takes so long [ms]

async function start() {
  const late = setTimeout(() => {
    $("#verdict").replaceChildren(chip("starting", "hand"), html("p", { class: "said" }, "the library is compiled for this machine: only the first time, half a minute or more"));
  }, PATIENCE);
  live.addEventListener("seen", () => clearTimeout(late), { once: true });
  const file = document.querySelector('meta[name="selfmotion-file"]')?.content;
  const [schema, examples] = await Promise.all([ask("schema"), ask("examples")]);
  const linked = await fromLink().catch((error) => { tell("This link cannot be read", damaged(error)); return null; });
  if (!linked) {
    if (file) use({ ...(await ask("open", { file })), file });
    else use(examples[0]);
  }
  panel = new ProblemPanel(model, new Forms(schema, beginnings(scene, startOf)), scene, examples);
  showAll();
}

start().catch((error) => { $("#verdict").replaceChildren(...failureParts(error.data ?? { message: String(error), remedy: "" })); });

// For tests and the curious: what the page knows.
globalThis.selfmotion = {
  model, live, planning, player, motion: shownMotion,
  get curve() { return curve; },
};
