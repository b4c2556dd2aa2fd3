// What the page is about: a problem, a curve moved by hand, a frequency; with undo, redo and a link that says it all.

const MOST_STEPS = 200;
const STARTED = { problem: null, hand: null, frequency: null, file: null };

export class Model extends EventTarget {
  #past = [];
  #future = [];
  #settled = STARTED;
  state = STARTED;

  // Take over changes. While something is dragged they are not `settled`: one undo takes the whole drag back.
  change(changes, settled = true) {
    const before = this.state.problem;
    this.state = { ...this.state, ...changes };
    if (changes.problem && !changes.hand && shapeOf(before) !== shapeOf(changes.problem)) this.state = { ...this.state, hand: null };
    if (settled && JSON.stringify(this.state) !== JSON.stringify(this.#settled)) {
      if (this.#settled.problem) this.#past.push(this.#settled);
      this.#past.splice(0, this.#past.length - MOST_STEPS);
      this.#future = [];
      this.#settled = this.state;
    }
    this.#tell(settled);
  }

  changeProblem(part, settled = true) {
    this.change({ problem: { ...this.state.problem, ...part } }, settled);
  }

  get canUndo() { return this.#past.length > 0; }
  get canRedo() { return this.#future.length > 0; }
  undo() { this.#move(this.#past, this.#future); }
  redo() { this.#move(this.#future, this.#past); }

  #move(from, to) {
    if (!from.length) return;
    to.push(this.#settled);
    this.#settled = this.state = from.pop();
    this.#tell(true);
  }

  #tell(settled) { this.dispatchEvent(new CustomEvent("change", { detail: { settled } })); }

  async link() {
    const address = new URL(location.href);
    address.search = "";
    address.hash = `s=${await packed(JSON.stringify(this.state))}`;
    return address.href;
  }
}

// The state that a link's fragment holds, or null.
export async function stateIn(fragment) {
  const found = /^#?s=([\w-]+)$/.exec(fragment);
  if (!found) return null;
  const state = JSON.parse(await unpackedText(found[1]));
  if (typeof state?.problem !== "object" || state.problem === null) throw new Error("no problem in it");
  return { ...STARTED, ...Object.fromEntries(Object.keys(STARTED).map((name) => [name, state[name] ?? null])) };
}

async function through(stream, bytes) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

async function packed(text) {
  const bytes = await through(new CompressionStream("deflate-raw"), new TextEncoder().encode(text));
  const letters = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

async function unpackedText(text) {
  const letters = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  return new TextDecoder().decode(await through(new DecompressionStream("deflate-raw"), bytes));
}

// What a curve by hand is a curve of: with another arm it means nothing.
function shapeOf(problem) {
  if (!problem) return "";
  const { kind, name, file, links } = problem.arm;
  return JSON.stringify([kind, name, file, Array.isArray(links) ? links.length : 0, problem.path.direction !== undefined]);
}

// What a plan is a plan of: the problem but for how it is planned.
export function taskOf(problem) {
  const { planner: _, ...task } = problem;
  return JSON.stringify(task);
}
