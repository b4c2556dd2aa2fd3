// Questions to the server: each carries all that is needed, so nothing is remembered there.

import { unpacked } from "selfmotion/numbers";

const TOKEN = document.querySelector('meta[name="selfmotion-token"]')?.content ?? "";

// Links to this studio hold no token: in this browser, and for this port only, they find it here.
if (TOKEN) localStorage.setItem("selfmotion-token", TOKEN);

export class Refused extends Error {
  constructor(error) {
    super(error.message);
    this.data = { status: "error", remedy: "", field: null, ...error };
  }
}

const GONE = {
  message: "the studio does not answer",
  remedy: "is the program still running? Start it again: selfmotion studio; what you see here is kept",
};

async function* linesOf(body) {
  const reader = body.getReader(), letters = new TextDecoder();
  let rest = [];
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    const parts = letters.decode(value, { stream: true }).split("\n");
    for (const part of parts.slice(0, -1)) {
      yield rest.join("") + part;
      rest = [];
    }
    rest.push(parts.at(-1));
  }
  const last = rest.join("");
  if (last.trim()) yield last;
}

// Ask for a task; `progress` hears how it goes, `signal` can give it up. Throws Refused, or AbortError.
export async function ask(task, payload = {}, { progress = null, signal } = {}) {
  let answer;
  try {
    answer = await fetch(`/api/${task}`, {
      method: "POST", signal, cache: "no-store",
      headers: { "Content-Type": "application/json", "X-Selfmotion-Token": TOKEN },
      body: JSON.stringify(payload),
    });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refused(GONE);
  }
  if (!answer.ok) {
    const said = await answer.json().catch(() => ({}));
    throw new Refused(said.error ?? { message: `the studio refused this (${answer.status})` });
  }
  let last = null; // the answer is read to its end: one that is dropped would be taken for given up
  try {
    if (progress === null) { // at once, which is quicker
      last = JSON.parse((await answer.text()).trimEnd().split("\n").at(-1));
    } else {
      for await (const line of linesOf(answer.body)) {
        last = JSON.parse(line);
        if (last.progress) progress(last.progress);
      }
    }
  } catch (error) {
    if (error.name === "AbortError") throw error;
  }
  if (last?.error) throw new Refused(last.error);
  if (last?.result === undefined) throw new Refused(GONE);
  return unpacked(last.result);
}
