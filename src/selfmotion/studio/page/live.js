// Keeps pictures in step with the state: one question at a time, always about the latest state.

import { ask } from "selfmotion/requests";
import { taskOf } from "selfmotion/model";

const MEASURED = 400;

export class Live extends EventTarget {
  scene = null;
  domain = null;
  motion = null; // of the hand or the sinusoid
  failure = null;
  timings = []; // from a change until what it changes is drawn, the wait for the picture before it included [ms]
  redraws = []; // the same without that wait: asked, computed, told and drawn
  task = null; // that of the scene
  #wanted = null;
  #running = false;
  #domainTask = null;
  #domainStop = null;

  // Ask for what `state` looks like with a curve by "hand" or the "sinusoid", the domains of many links `around` a motion.
  // While something is dragged it is not settled: then only what is quick is asked for.
  update(state, settled, curve = "hand", around = null) {
    this.#wanted = { state, settled, curve, around, since: performance.now() };
    if (!this.#running) this.#run();
  }

  async #run() {
    this.#running = true;
    let asked = this.#begin();
    while (asked) {
      const answer = await asked;
      // What is newer is asked for before this is drawn: the library works while the page does.
      asked = this.#wanted ? this.#begin() : null;
      this.#take(answer);
      asked ??= this.#wanted ? this.#begin() : null;
    }
    this.#running = false;
  }

  // Ask for what is wanted; that it is refused is an answer too.
  async #begin() {
    const now = this.#wanted, task = taskOf(now.state.problem), fresh = task !== this.task;
    this.#wanted = null;
    const quick = this.scene?.dimension === 2 && this.scene?.n_u === 1; // of the first problem nobody knows yet
    const want = ["motion", ...(fresh ? ["scene"] : []), ...(fresh && quick ? ["domain"] : [])];
    const { state, settled, curve, around } = now;
    now.asked = performance.now();
    try {
      return { ...now, task, found: await ask("look", { ...questionOf(state, curve), want, settled, around }) };
    } catch (error) {
      return { ...now, task, error };
    }
  }

  #take({ state, settled, curve, around, since, asked, task, found, error }) {
    if (error) {
      this.#refused(error, settled);
      return;
    }
    this.task = task;
    if (found.scene) this.scene = found.scene;
    if (found.domain) {
      this.domain = found.domain;
      this.#domainTask = task;
    }
    this.motion = found.motion ?? null;
    this.failure = null;
    this.#tell(settled);
    for (const [kept, from] of [[this.timings, since], [this.redraws, asked]]) {
      kept.push(performance.now() - from);
      if (kept.length > MEASURED) kept.shift();
    }
    if (this.#domainTask !== task || (settled && this.domain?.kind === "component")) this.#lookAtDomain(state, curve, task, around);
  }

  #tell(settled) { this.dispatchEvent(new CustomEvent("seen", { detail: { settled } })); }

  #refused(error, settled) {
    if (error.name === "AbortError") return;
    this.failure = error.data ?? { message: String(error), remedy: "" };
    this.#tell(settled);
  }

  // The domains of arms in space and of many links take longer: they come when they come, unless something newer is asked.
  async #lookAtDomain(state, curve, task, around) {
    this.#domainStop?.abort();
    const stop = (this.#domainStop = new AbortController());
    if (this.#domainTask !== task) {
      this.domain = null;
      this.#tell(true);
    }
    try {
      const found = await ask("look", { ...questionOf(state, curve), want: ["domain"], settled: true, around }, { signal: stop.signal });
      this.domain = found.domain;
      this.#domainTask = task;
      this.#tell(true);
    } catch (error) {
      this.#refused(error, true);
    }
  }
}

function questionOf({ problem, hand, frequency }, curve) {
  const sinusoid = (curve === "sinusoid" || !hand) && problem.planner?.kind === "sinusoid" && frequency !== null;
  return { problem, hand: sinusoid ? null : hand, frequency: sinusoid ? [problem.planner.amplitude].flat().map((_, k) => frequency[k] ?? frequency[0]) : null };
}
