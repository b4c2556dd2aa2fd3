// Keeps pictures in step with the state: one question at a time, always about the latest state.

import { ask } from "selfmotion/requests";
import { taskOf } from "selfmotion/model";

const MEASURED = 400;

export class Live extends EventTarget {
  scene = null;
  domain = null;
  motion = null; // of the hand or the sinusoid
  failure = null;
  timings = []; // from a change until what it changes is drawn [ms]
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
    while (this.#wanted) {
      const now = this.#wanted;
      this.#wanted = null;
      await this.#look(now);
    }
    this.#running = false;
  }

  async #look({ state, settled, curve, around, since }) {
    const task = taskOf(state.problem), fresh = task !== this.task;
    const quick = this.scene?.dimension === 2 && this.scene?.n_u === 1;
    const want = ["motion"];
    if (fresh) want.push("scene");
    if (fresh && (quick || !this.scene)) want.push("domain");
    try {
      // Of the first problem nobody knows yet whether its domain is quick: ask for the scene alone.
      const first = !this.scene || (fresh && !quick);
      const asked = first ? want.filter((part) => part !== "domain") : want;
      const found = await ask("look", { ...questionOf(state, curve), want: asked, settled, around });
      this.task = task;
      if (found.scene) this.scene = found.scene;
      if (found.domain) {
        this.domain = found.domain;
        this.#domainTask = task;
      }
      this.motion = found.motion ?? null;
      this.failure = null;
      this.dispatchEvent(new CustomEvent("seen", { detail: { settled } }));
      this.timings.push(performance.now() - since);
      if (this.timings.length > MEASURED) this.timings.shift();
      if (this.#domainTask !== task || (settled && this.domain?.kind === "component")) this.#lookAtDomain(state, curve, task, around);
    } catch (error) {
      if (error.name === "AbortError") return;
      this.failure = error.data ?? { message: String(error), remedy: "" };
      this.dispatchEvent(new CustomEvent("seen", { detail: { settled } }));
    }
  }

  // The domains of arms in space and of many links take longer: they come when they come, unless something newer is asked.
  async #lookAtDomain(state, curve, task, around) {
    this.#domainStop?.abort();
    const stop = (this.#domainStop = new AbortController());
    if (this.#domainTask !== task) {
      this.domain = null;
      this.dispatchEvent(new CustomEvent("seen", { detail: { settled: true } }));
    }
    try {
      const found = await ask("look", { ...questionOf(state, curve), want: ["domain"], settled: true, around }, { signal: stop.signal });
      this.domain = found.domain;
      this.#domainTask = task;
      this.dispatchEvent(new CustomEvent("seen", { detail: { settled: true } }));
    } catch (error) {
      if (error.name === "AbortError") return;
      this.failure = error.data ?? { message: String(error), remedy: "" };
      this.dispatchEvent(new CustomEvent("seen", { detail: { settled: true } }));
    }
  }
}

function questionOf({ problem, hand, frequency }, curve) {
  const sinusoid = (curve === "sinusoid" || !hand) && problem.planner?.kind === "sinusoid" && frequency !== null;
  return { problem, hand: sinusoid ? null : hand, frequency: sinusoid ? [problem.planner.amplitude].flat().map((_, k) => frequency[k] ?? frequency[0]) : null };
}
