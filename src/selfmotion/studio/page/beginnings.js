// What newly chosen parts of a problem begin with: near what is there, so that something is feasible.

const round = (value) => Number(value.toPrecision(4));

// The middle of the path that is there, and how large it is.
function frameOf(scene) {
  const { x } = scene.path, dimension = x.shape[1];
  const least = [Infinity, Infinity], most = [-Infinity, -Infinity];
  for (let k = 0; k < x.shape[0]; k += 1) {
    for (const axis of [0, 1]) {
      least[axis] = Math.min(least[axis], x[k * dimension + axis]);
      most[axis] = Math.max(most[axis], x[k * dimension + axis]);
    }
  }
  const size = Math.max(most[0] - least[0], most[1] - least[1]) / 2 || 0.1 * (scene.reach?.outer ?? 1);
  return { middle: [(least[0] + most[0]) / 2, (least[1] + most[1]) / 2].map(round), size: round(size) };
}

// A new obstacle: where there is room, between the base and the path.
export function beginObstacle(kind, scene) {
  const { middle, size } = frameOf(scene), reach = scene.reach?.outer ?? 2 * (Math.hypot(...middle) || size);
  const [x, y] = middle.map((value) => round(0.5 * value)), small = round(0.05 * reach), big = round(0.12 * reach);
  return {
    circle: { circle: { center: [x, y], radius: small } },
    polygon: { polygon: [[x - small, y - small], [x + small, y - small], [x + small, y + small], [x - small, y + small]].map((point) => point.map(round)) },
    half_plane: { half_plane: { point: [0, round(-0.6 * reach)], normal: [0, 1] } },
    sphere: { sphere: { center: [x, y, big], radius: small } },
    box: { box: { center: [x, y, big], size: [big, big, big] } },
    capsule: { capsule: { from: [x, y, 0], to: [x, y, big], radius: round(0.5 * small) } },
    half_space: { half_space: { point: [0, 0, -0.1], normal: [0, 0, 1] } },
  }[kind];
}

export function sampledPoints(scene, count) {
  const { x } = scene.path, last = x.shape[0] - 1;
  return Array.from({ length: count }, (_, k) => {
    const at = 2 * Math.round((k / (count - 1)) * last);
    return [round(x[at]), round(x[at + 1])];
  });
}

const PATHS = {
  bezier: (scene) => ({ control_points: scene.path.handles ?? sampledPoints(scene, 6) }),
  waypoints: (scene) => ({ points: scene.path.handles ?? sampledPoints(scene, 7), interpolation: "spline" }),
  line: (scene) => {
    const [start, end] = [sampledPoints(scene, 2)[0], sampledPoints(scene, 2)[1]];
    const { middle, size } = frameOf(scene);
    return Math.hypot(end[0] - start[0], end[1] - start[1]) > 0.2 * size
      ? { start, end } : { start: [middle[0] - size, middle[1]].map(round), end: [middle[0] + size, middle[1]].map(round) };
  },
  circle: (scene) => ({ center: frameOf(scene).middle, radius: frameOf(scene).size }),
  arc: (scene) => ({ center: frameOf(scene).middle, radius: frameOf(scene).size, start_angle: 0, sweep: 3.14159 }),
  ellipse: (scene) => ({ center: frameOf(scene).middle, radii: [frameOf(scene).size, round(0.6 * frameOf(scene).size)] }),
  lissajous: (scene) => ({ center: frameOf(scene).middle, radii: Array(2).fill(frameOf(scene).size), frequencies: [1, 2] }),
  rose: (scene) => ({ center: frameOf(scene).middle, radius: frameOf(scene).size, petals: 3 }),
  clothoid: (scene) => ({ center: frameOf(scene).middle, scale: frameOf(scene).size, coefficients: [0, -4, 0, 0.33], t_range: [-4.712, 0] }),
};

const fill = (scene, value) => Array(scene.n_u).fill(value);
// The one inside another, if there is one: a shifted copy is an experiment, and not begun here.
const search = (old, bounds) => old.optimizer?.optimizer ?? old.optimizer ?? { kind: "pso", population: 20, iterations: 100, ...(bounds ? { bounds } : {}), seed: 1 };
const free = (old) => {
  const { bounds: _, ...rest } = search(old);
  return rest;
};

const PLANNERS = {
  sinusoid: (scene, old, start) => ({
    offset: old.offset ?? start, amplitude: old.amplitude ?? fill(scene, 0.3),
    optimizer: { ...search(old), bounds: search(old).bounds ?? [0, 15] },
  }),
  harmonics: (scene, old, start) => ({ offset: old.offset ?? start, span: old.span ?? fill(scene, 0.3), optimizer: free(old) }),
  bspline: (scene, old, start) => ({ offset: old.offset ?? start, span: old.span ?? fill(scene, 0.3), optimizer: free(old) }),
  global: (scene) => (scene.n_u === 1 ? { gap: scene.dimension === 3 ? 1e-2 : 1e-4 } : null),
  widest: (scene) => (scene.n_u === 1 ? { margin: scene.obstacles?.length ? "clearance" : "least_singular_value" } : null),
  refine: () => ({ seed: 0 }),
  moving_base: (scene, old) => (scene.n_u > 1 && scene.dimension === 2 ? { optimizer: free(old) } : null),
};

// Of another kind of arm: its path comes with it.
const ARMS = {
  planar: (scene) => ({ links: scene.links ?? [30, 30, 20] }),
  named: () => ({ name: "panda" }),
};

const SEARCHES = ({ kind: _, variant: _v, walls: _w, ...rest }) => rest;

// A problem for another arm of the same kind: what has one number per redundant degree gets the number that is needed.
export function adapted(problem, arm) {
  const next = { ...problem, arm }, before = problem.arm.links?.length, now = arm.links?.length;
  if (now === undefined || now === before) return next;
  const degrees = now - 2 - (problem.path.direction === undefined && arm.direction === undefined ? 0 : 1);
  for (const name of ["start", "end", "weights"]) delete next[name];
  let planner = { ...(problem.planner ?? {}) };
  for (const name of ["offset", "amplitude", "span"]) {
    if (!Array.isArray(planner[name])) continue;
    const last = planner[name].at(-1) ?? 0;
    planner[name] = Array.from({ length: degrees }, (_, k) => planner[name][k] ?? (name === "offset" ? 0 : last));
  }
  if (degrees > 1 && ["global", "widest", "modules"].includes(planner.kind)) planner = { kind: "refine", seed: 0 };
  if (planner.kind) next.planner = planner;
  return next;
}

// Data of a kind in a section, or null where it cannot be begun here: open a file or an example for that.
export function begin(section, kind, old, scene, start) {
  if (section === "optimizer") {
    if (kind === "shifted") return null;
    const { population, iterations, bounds, seed } = SEARCHES(old);
    return Object.fromEntries(Object.entries({ kind, population, iterations, bounds, seed }).filter(([, value]) => value !== undefined));
  }
  const makers = { task: PATHS, path: PATHS, planner: PLANNERS, arm: ARMS }[section];
  if (!scene || (scene.dimension !== 2 && makers === PATHS)) return null; // poses: as text
  const made = makers?.[kind]?.(scene, old, start);
  if (!made) return null;
  return { kind, ...made, ...(section === "task" && old.direction !== undefined ? { direction: old.direction } : {}) };
}
