// Obstacles in pictures: in the plane as shapes with what is to stay clear about them, in space as wires; and how each is moved.

import { svg } from "selfmotion/svg";

const COLORS = 6;
const RING = 40; // corners of a circle in space

export const obstacleLook = (number) => (number === null || number === undefined ? "obstacle-none" : `obstacle-${number % COLORS}`);

export const obstacleName = (obstacle, k) => obstacle.name || `obstacle ${k + 1}`;

// One obstacle of the plane; `x` and `y` take lengths to pixels, `scale` is pixels per length, `far` as far as one sees,
// `aside` whether its name stands beside it.
export function planeShape(obstacle, k, { x, y, scale, far, clearance, aside = false }) {
  const name = obstacleName(obstacle, k), parts = [];
  const shape = (attributes, wide = 0) => {
    if (obstacle.kind === "circle") {
      return svg("circle", { cx: x(obstacle.center[0]), cy: y(obstacle.center[1]), r: obstacle.radius * scale + wide, ...attributes });
    }
    if (obstacle.kind === "polygon") return svg("path", { d: `M${obstacle.corners.map(([a, b]) => `${x(a)} ${y(b)}`).join("L")}Z`, ...attributes });
    const { point, normal } = obstacle, size = Math.hypot(...normal), [a, b] = normal.map((value) => value / size);
    const at = (along, across) => `${x(point[0] - along * b + across * a)} ${y(point[1] + along * a + across * b)}`;
    return svg("path", { d: `M${at(-far, wide / scale)}L${at(far, wide / scale)}L${at(far, -far)}L${at(-far, -far)}Z`, ...attributes });
  };
  if (clearance > 0) {
    // Of a polygon as a wide line with round corners, under a paler one that leaves its rim.
    const wide = clearance * scale;
    if (obstacle.kind === "polygon") {
      parts.push(shape({ class: "clearance rim", "stroke-width": 2 * wide + 1.6 }), shape({ class: "clearance room", "stroke-width": Math.max(2 * wide - 0.4, 0) }));
    } else parts.push(shape({ class: "clearance" }, wide));
  }
  parts.push(shape({ class: "obstacle", "data-obstacle": k }));
  parts.at(-1).append(svg("title", {}, `${name}: drag to move it`));
  const [a, b] = aside ? aboveOf(obstacle, 14 / scale) : middleOf(obstacle, 14 / scale);
  parts.push(svg("text", { class: "obstacle-name", x: x(a), y: y(b) + (aside && obstacle.kind !== "half_plane" ? -9 : 4), "text-anchor": "middle" }, obstacle.name || String(k + 1)));
  return svg("g", { class: obstacleLook(k) }, ...parts);
}

function middleOf(obstacle, inside) {
  if (obstacle.kind === "circle") return obstacle.center;
  if (obstacle.kind === "half_plane") {
    const size = Math.hypot(...obstacle.normal);
    return obstacle.point.map((value, axis) => value - (inside * obstacle.normal[axis]) / size);
  }
  const { corners } = obstacle;
  return [0, 1].map((axis) => corners.reduce((sum, corner) => sum + corner[axis], 0) / corners.length);
}

// Where a name is clear of the handles.
function aboveOf(obstacle, inside) {
  if (obstacle.kind === "circle") return [obstacle.center[0], obstacle.center[1] + obstacle.radius];
  if (obstacle.kind === "half_plane") return middleOf(obstacle, 1.3 * inside);
  return [middleOf(obstacle, inside)[0], Math.max(...obstacle.corners.map((corner) => corner[1]))];
}

// By which points an obstacle of the plane is changed: {name, label, at, to(entry, place)}, `to` gives the entry of the problem.
export function gripsOf(obstacle, k) {
  const name = obstacleName(obstacle, k), { kind } = obstacle;
  const set = (what) => (entry, at) => ({ ...entry, [kind]: what(entry[kind], at) });
  if (kind === "polygon") {
    return obstacle.corners.map((at, j) => ({
      name: `corner-${k}-${j}`, label: `corner ${j + 1} of ${name}`, at, to: set((corners, place) => corners.map((old, i) => (i === j ? place : old))),
    }));
  }
  if (kind === "half_plane") {
    return [{ name: `edge-${k}`, label: `edge of ${name}`, at: obstacle.point, to: set((fields, point) => ({ ...fields, point })) }];
  }
  const { center, radius } = obstacle;
  return [
    { name: `center-${k}`, label: `centre of ${name}`, at: center, to: set((fields, place) => ({ ...fields, center: place })) },
    {
      name: `radius-${k}`, label: `radius of ${name}`, at: [center[0] + radius, center[1]],
      to: set((fields, place) => ({ ...fields, radius: Math.max(Math.hypot(place[0] - fields.center[0], place[1] - fields.center[1]), 1e-3 * radius) })),
    },
  ];
}

// The entry of a problem moved by a way.
export function movedBy(entry, way) {
  const add = (point) => point.map((value, axis) => value + way[axis]);
  const field = { circle: "center", half_plane: "point" };
  const kind = ["circle", "polygon", "half_plane"].find((name) => name in entry);
  if (kind === "polygon") return { ...entry, polygon: entry.polygon.map(add) };
  return kind ? { ...entry, [kind]: { ...entry[kind], [field[kind]]: add(entry[kind][field[kind]]) } } : entry;
}

// The lines of an obstacle in space, each a list of points.
export function spaceLines(obstacle) {
  const { kind } = obstacle;
  if (kind === "box") return boxLines(obstacle);
  if (kind === "sphere") return [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => ring(obstacle.center, axis, obstacle.radius));
  if (kind === "capsule") return capsuleLines(obstacle);
  if (kind === "mesh") return obstacle.triangles.map((corners) => [...corners, corners[0]]);
  if (kind === "half_space") return floorLines(obstacle);
  return [];
}

function boxLines({ center, size, rotation }) {
  const corner = (signs) => center.map((value, row) => value + signs.reduce((sum, sign, axis) => sum + rotation[row][axis] * sign * 0.5 * size[axis], 0));
  const lines = [];
  for (let axis = 0; axis < 3; axis += 1) {
    for (const a of [-1, 1]) {
      for (const b of [-1, 1]) {
        lines.push([-1, 1].map((sign) => corner([0, 1, 2].map((k) => (k === axis ? sign : k === (axis + 1) % 3 ? a : b)))));
      }
    }
  }
  return lines;
}

const plus = (a, b, by = 1) => a.map((value, k) => value + by * b[k]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((value) => value / (Math.hypot(...a) || 1));

// Two directions across an axis.
function across(axis) {
  const first = unit(cross(axis, Math.abs(axis[2]) < 0.9 * Math.hypot(...axis) ? [0, 0, 1] : [1, 0, 0]));
  return [first, unit(cross(axis, first))];
}

function ring(center, axis, radius) {
  const [a, b] = across(axis);
  return Array.from({ length: RING + 1 }, (_, k) => {
    const turn = (2 * Math.PI * k) / RING;
    return plus(plus(center, a, radius * Math.cos(turn)), b, radius * Math.sin(turn));
  });
}

function capsuleLines({ from, to, radius }) {
  const along = plus(to, from, -1), axis = Math.hypot(...along) ? unit(along) : [0, 0, 1], [a, b] = across(axis);
  const lines = [ring(from, axis, radius), ring(to, axis, radius)];
  for (const side of [a, b]) {
    const arc = (end, sign) => Array.from({ length: RING / 2 + 1 }, (_, k) => {
      const turn = (Math.PI * k) / (RING / 2);
      return plus(plus(end, side, sign * radius * Math.cos(turn)), axis, sign * radius * Math.sin(turn));
    });
    const outline = [...arc(to, 1), ...arc(from, -1)];
    lines.push([...outline, outline[0]]);
  }
  return lines;
}

function floorLines({ point, normal }) {
  const [a, b] = across(unit(normal)), lines = [];
  for (let k = -4; k <= 4; k += 1) {
    const at = k / 4;
    lines.push([plus(plus(point, a, -1), b, at), plus(plus(point, a, 1), b, at)], [plus(plus(point, b, -1), a, at), plus(plus(point, b, 1), a, at)]);
  }
  return lines;
}
