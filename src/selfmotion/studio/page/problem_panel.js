// The problem as forms and as text.

import { adapted, begin } from "selfmotion/beginnings";
import { jointTable } from "selfmotion/forms";
import { obstaclesForm } from "selfmotion/obstacles_form";
import { taskOf } from "selfmotion/model";
import { ask } from "selfmotion/requests";
import { html } from "selfmotion/svg";

const OWN = ["elbow", "cyclic", "objective", "weights", "samples", "start", "end"];

export class ProblemPanel {
  #shown = null;

  // `examples` are where another kind of arm gets its path from.
  constructor(model, forms, scene, examples) {
    Object.assign(this, { model, forms, scene, examples });
    this.places = Object.fromEntries(["planner", "arm", "path", "obstacles", "task"].map((name) => [name, document.querySelector(`#${name}-form`)]));
    this.text = document.querySelector("#text");
    this.source = document.querySelector("#source");
    this.source.addEventListener("toggle", () => this.#write());
    document.querySelector("#apply").addEventListener("click", () => this.#apply());
  }

  show() {
    const { problem } = this.model.state, now = JSON.stringify([problem, this.scene()?.n, this.scene()?.branches]);
    if (now === this.#shown) return;
    this.#shown = now;
    const focused = document.activeElement?.closest?.("[data-field]")?.dataset.field;
    const change = (name) => (data) => {
      if (data === null) return;
      if (name === "arm" && data.kind !== problem.arm.kind) { this.#changeArm(data); return; }
      const more = name === "planner" && data.kind !== problem.planner?.kind ? { frequency: data.kind === "sinusoid" ? [1] : null } : {};
      const now = this.model.state.problem;
      this.model.change({ problem: name === "arm" ? adapted(now, data) : { ...now, [name]: data }, ...more });
    };
    this.places.planner.replaceChildren(this.forms.section("planner", problem.planner ?? { kind: "global" }, change("planner")));
    const planar = problem.arm.kind === "planar";
    this.places.arm.replaceChildren(...[
      this.forms.section("arm", problem.arm, change("arm"), { bare: planar }), planar ? jointTable(problem.arm, change("arm")) : null,
    ].filter(Boolean));
    this.places.path.replaceChildren(this.forms.section("task", problem.path, change("path")));
    if (this.scene()) {
      this.places.obstacles.replaceChildren(...obstaclesForm(this.forms, problem, this.scene(), (part) => {
        const now = Object.entries({ ...this.model.state.problem, ...part }).filter(([, value]) => value !== undefined);
        this.model.change({ problem: Object.fromEntries(now) });
      }));
    }
    this.places.task.replaceChildren(...OWN.map((name) => this.#own(name, problem)));
    if (focused) document.querySelector(`[data-field="${CSS.escape(focused)}"] :is(input, select)`)?.focus({ preventScroll: true });
    this.#write();
  }

  // Another kind of arm moves where the path that is there makes no sense: take one that does.
  #changeArm(arm) {
    const found = this.examples.map((example) => example.problem).find((problem) => problem.arm.kind === arm.kind && problem.planner.kind === "global");
    if (found) this.model.change({ problem: found, hand: null, frequency: null, file: null });
  }

  #own(name, problem) {
    const part = { ...this.forms.schema.properties[name] };
    if (name === "elbow") part.enum = ["any", ...(this.scene()?.branches ?? [])];
    const key = name === "elbow" && problem.branch !== undefined ? "branch" : name;
    return this.forms.field(name, part, problem[key], (value) => {
      const { [key]: _, ...rest } = this.model.state.problem;
      this.model.change({ problem: value === undefined ? rest : { ...rest, [key]: value } });
    }, key);
  }

  async #write() {
    if (!this.source.open) return;
    const { problem } = this.model.state;
    try {
      const { text } = await ask("write", { problem });
      if (problem === this.model.state.problem) this.text.value = text;
    } catch (error) {
      this.text.value = `# ${error.message}`;
    }
  }

  async #apply() {
    this.text.setCustomValidity("");
    try {
      const { problem } = await ask("read", { text: this.text.value });
      const same = taskOf(problem) === taskOf(this.model.state.problem);
      this.model.change({ problem, ...(same ? {} : { hand: null }) });
    } catch (error) {
      this.text.setCustomValidity(error.data ? `${error.data.message}; ${error.data.remedy}` : String(error));
      this.text.reportValidity();
    }
  }
}

export const beginnings = (scene, startOf) => (section, kind, old) => begin(section, kind, old, scene(), startOf());
export const lines = (texts) => texts.map((text) => html("li", {}, text));
