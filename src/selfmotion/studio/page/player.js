// The place along the path that is shown, moved by hand or played.

const SECONDS = 6;

export class Player extends EventTarget {
  r = 0;
  #since = null;

  constructor() {
    super();
    this.scrub = document.querySelector("#scrub");
    this.button = document.querySelector("#play");
    this.output = document.querySelector("#place");
    this.scrub.addEventListener("input", () => { this.stop(); this.seek(this.scrub.valueAsNumber); });
    this.button.addEventListener("click", () => this.toggle());
  }

  get isPlaying() { return this.#since !== null; }

  seek(r) {
    this.r = r;
    this.scrub.value = r;
    this.output.textContent = `r = ${r.toFixed(3)}`;
    this.dispatchEvent(new Event("moved"));
  }

  toggle() { if (this.isPlaying) this.stop(); else this.#play(); }

  stop() {
    this.#since = null;
    this.#name("▶", "play");
  }

  #play() {
    const from = this.r >= 1 ? 0 : this.r;
    this.#since = performance.now() - 1000 * SECONDS * from;
    this.#name("❚❚", "pause");
    const step = (now) => {
      if (!this.isPlaying) return;
      const r = (now - this.#since) / (1000 * SECONDS);
      this.seek(Math.min(Math.max(r, 0), 1));
      if (r >= 1) this.stop(); else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  #name(mark, name) {
    this.button.textContent = mark;
    this.button.setAttribute("aria-label", name);
  }
}
