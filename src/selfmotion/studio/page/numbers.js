// Numbers as people read them, and arrays as they come over the wire.

export const TAU = 2 * Math.PI;

export function shown(value, digits = 6) {
  if (value == null || !Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

// A share as a percentage that is never too small.
export function percent(part) {
  if (part == null || !Number.isFinite(part)) return "–";
  if (part <= 0) return "0 %";
  const size = 10 ** (Math.floor(Math.log10(part * 100)) - 1);
  return `${Number((Math.ceil((part * 100) / size - 1e-9) * size).toPrecision(3))} %`;
}

export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

const KINDS = { f4: Float32Array, f8: Float64Array };

// {f4: base64, shape} becomes a typed array with that shape.
function unpackedArray(packed) {
  const kind = packed.f4 === undefined ? "f8" : "f4";
  const letters = atob(packed[kind]), bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k += 1) bytes[k] = letters.charCodeAt(k); // within a drag: ten times as fast as from()
  const array = new KINDS[kind](bytes.buffer);
  array.shape = packed.shape;
  return array;
}

// Plain data with every packed array in it unpacked.
export function unpacked(value) {
  if (Array.isArray(value)) return value.map(unpacked);
  if (value === null || typeof value !== "object") return value;
  if (Array.isArray(value.shape) && ("f4" in value || "f8" in value)) return unpackedArray(value);
  return Object.fromEntries(Object.entries(value).map(([name, inner]) => [name, unpacked(inner)]));
}

// The first place in an ascending array whose value is not below the one given.
export function placeIn(array, value) {
  let low = 0, high = array.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (array[middle] < value) low = middle + 1; else high = middle;
  }
  return low;
}

// Row k of an array of shape (rows, columns).
export function row(array, k) {
  const columns = array.shape[1];
  return array.subarray(k * columns, (k + 1) * columns);
}

// A row between the rows of `array` at the places `r`, linear between them; `nearest` takes the one that is nearer.
export function rowAt(r, array, at, nearest = false) {
  const right = clamp(placeIn(r, at), 1, r.length - 1), left = right - 1;
  const part = clamp((at - r[left]) / (r[right] - r[left] || 1), 0, 1);
  if (nearest) return row(array, part < 0.5 ? left : right);
  const a = row(array, left), b = row(array, right);
  return Float64Array.from(a, (value, k) => value + part * (b[k] - value));
}
