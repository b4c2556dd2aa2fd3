// A pointer that is held down, until it is let go or taken away.

export function held(moving, ended) {
  const up = () => {
    removeEventListener("pointermove", moving);
    removeEventListener("pointerup", up);
    removeEventListener("pointercancel", up);
    ended();
  };
  addEventListener("pointermove", moving);
  addEventListener("pointerup", up);
  addEventListener("pointercancel", up);
}
