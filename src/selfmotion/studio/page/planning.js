// Planning in a worker: started, watched, given up; and what came out, kept for as long as it is an answer to what is asked.

import { ask } from "selfmotion/requests";
import { taskOf } from "selfmotion/model";

const KEPT = 24;

export class Planning extends EventTarget {
  #answers = new Map();
  #stop = null;
  failure = null;

  get isRunning() { return this.#stop !== null; }

  // The latest plan for the problem, however it was planned; null without one.
  planFor(problem) { return problem ? this.#answers.get(taskOf(problem)) ?? null : null; }

  // What was proved of every motion for the problem, by any plan for it.
  boundFor(problem) { return this.planFor(problem)?.bound ?? null; }

  async run(problem) {
    this.cancel();
    const stop = (this.#stop = new AbortController()), task = taskOf(problem);
    this.failure = null;
    this.#tell("started");
    try {
      const found = await ask("plan", { problem }, { signal: stop.signal, progress: (step) => this.#tell("step", step) });
      if (this.#stop !== stop) return;
      const { lower_bound: proved, gap } = found.summary;
      const before = this.#answers.get(task)?.bound ?? null;
      const bound = proved === null ? before : before === null ? { value: proved, gap } : { value: Math.max(proved, before.value), gap };
      this.#answers.delete(task);
      this.#answers.set(task, { ...found, bound });
      if (this.#answers.size > KEPT) this.#answers.delete(this.#answers.keys().next().value);
      this.#stop = null;
      this.#tell("finished", { problem });
    } catch (error) {
      if (this.#stop !== stop) return;
      this.#stop = null;
      if (error.name === "AbortError") { this.#tell("cancelled"); return; }
      this.failure = { ...(error.data ?? { status: "error", message: String(error), remedy: "" }), problem: JSON.stringify(problem) };
      this.#tell("failed");
    }
  }

  cancel() {
    if (!this.#stop) return;
    this.#stop.abort();
    this.#stop = null;
    this.#tell("cancelled");
  }

  #tell(type, detail = null) { this.dispatchEvent(new CustomEvent(type, { detail })); }
}
