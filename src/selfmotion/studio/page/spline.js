// Clamped cubic B-splines on uniform knots, as the family `bspline` of the library has them.

const DEGREE = 3;
const LEAST = 0.05; // of a weight: so near an end that is kept the curve cannot be moved

// The knots of `count` coefficients.
function knotsOf(count) {
  const pieces = count - DEGREE;
  const inner = Array.from({ length: pieces + 1 }, (_, k) => k / pieces);
  return [...Array(DEGREE).fill(0), ...inner, ...Array(DEGREE).fill(1)];
}

// What each coefficient counts at r: all but four are zero (Cox and de Boor).
export function basisAt(count, r) {
  const t = knotsOf(count);
  const last = Math.min(DEGREE + Math.floor(r * (count - DEGREE)), count - 1);
  let values = [1];
  for (let degree = 1; degree <= DEGREE; degree += 1) {
    const next = Array(degree + 1).fill(0);
    for (let k = 0; k < degree; k += 1) {
      const left = t[last + k - degree + 1], right = t[last + k + 1];
      const part = values[k] / (right - left);
      next[k] += (right - r) * part;
      next[k + 1] += (r - left) * part;
    }
    values = next;
  }
  return { first: last - DEGREE, values };
}

export function splineAt(coefficients, r) {
  const { first, values } = basisAt(coefficients.length, r);
  return values.reduce((sum, value, k) => sum + value * coefficients[first + k], 0);
}

// Where along the path each coefficient has its say (Greville).
export function placesOf(count) {
  const t = knotsOf(count);
  return Array.from({ length: count }, (_, k) => (t[k + 1] + t[k + 2] + t[k + 3]) / 3);
}

// Coefficients of the curve moved by `by` at r; what is farther away than `reach` stays where it is, and so do ends that
// are `kept` ([start, end]).
export function moved(coefficients, r, by, reach, kept = [false, false]) {
  const count = coefficients.length;
  const wide = Math.max(reach, 2.5 / (count - DEGREE));
  const weight = placesOf(count).map((at) => {
    const away = Math.abs(at - r) / wide;
    return away < 1 ? 0.5 + 0.5 * Math.cos(Math.PI * away) : 0;
  });
  if (kept[0]) weight[0] = 0;
  if (kept[1]) weight[count - 1] = 0;
  const here = splineAt(weight, r);
  if (here < LEAST) return coefficients;
  return coefficients.map((value, k) => value + (by * weight[k]) / here);
}
