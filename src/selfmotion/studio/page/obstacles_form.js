// Obstacles as a form: each with its name and numbers, more of every kind, and what links must keep from them.

import { beginObstacle } from "selfmotion/beginnings";
import { obstacleLook } from "selfmotion/obstacles";
import { html } from "selfmotion/svg";

const KINDS = { 2: ["circle", "polygon", "half_plane"], 3: ["sphere", "box", "capsule", "half_space"] };
const CONSTRAINTS = ["clearance", "self_collision", "least_singular_value"];
const words = (name) => name.replaceAll("_", " ");

// The form for a problem; `change(part)` takes what of the problem is new, undefined for what is left out.
export function obstaclesForm(forms, problem, scene, change) {
  const obstacles = Array.isArray(problem.obstacles) ? problem.obstacles : [];
  const { $defs: forms_of, properties } = forms.schema;
  const set = (k, entry) => change({ obstacles: obstacles.map((old, j) => (j === k ? entry : old)) });
  const rows = obstacles.map((entry, k) => {
    const kind = Object.keys(entry ?? {}).find((name) => forms_of[`obstacle_${name}`]);
    if (!kind) return html("p", { class: "field long" }, `obstacle ${k + 1}: see the text below`);
    const part = forms_of[`obstacle_${kind}`].properties[kind], inner = part.$ref ? forms_of[part.$ref.split("/").at(-1)] : null;
    const where = (name) => `obstacles.${k}.${name}`;
    const fields = inner
      ? Object.entries(inner.properties).map(([name, form]) => forms.field(name, form, entry[kind][name], (value) => {
        const { [name]: _, ...rest } = entry[kind];
        set(k, { ...entry, [kind]: value === undefined ? rest : { ...rest, [name]: value } });
      }, where(name)))
      : [forms.field("corners", part, entry[kind], (value) => set(k, { ...entry, [kind]: value ?? [] }), where(kind))];
    const name = forms.field("name", { type: "text" }, entry.name ?? undefined, (value) => {
      const { name: _, ...rest } = entry;
      set(k, value === undefined ? rest : { name: String(value), ...rest });
    }, where("name"));
    const remove = html("button", {
      type: "button", title: "remove this obstacle", "aria-label": `remove obstacle ${k + 1}`,
      onclick: () => change({ obstacles: obstacles.length > 1 ? obstacles.filter((_, j) => j !== k) : undefined }),
    }, "✕");
    const legend = html("legend", {}, html("span", { class: `dot ${obstacleLook(k)}` }), ` ${k + 1}: ${words(kind)} `, remove);
    return html("fieldset", { "data-obstacle-form": k }, legend, name, ...fields);
  });
  const add = html("div", { class: "buttons" }, "add", ...KINDS[scene.dimension].map((kind) => html("button", {
    type: "button", "data-add": kind, onclick: () => change({ obstacles: [...obstacles, beginObstacle(kind, scene)] }),
  }, words(kind))));
  const about = html("p", { class: "about" }, "Links keep clear of obstacles, and of each other where self collision is ticked. In the picture, obstacles are dragged.");
  const own = CONSTRAINTS.map((name) => {
    const form = properties[name], number = form.anyOf?.find((one) => one.type === "number");
    return forms.field(name, number ? { ...number, default: null } : form, problem[name] ?? undefined, (value) => change({ [name]: value === null || value === false ? undefined : value }), name);
  });
  const thickness = problem.arm.kind === "planar" ? [forms.field("thickness", { type: "text", default: 0 }, problem.arm.thickness, (value) => {
    const { thickness: _, ...rest } = problem.arm;
    change({ arm: value === undefined ? rest : { ...rest, thickness: value } });
  }, "arm.thickness")] : [];
  return [about, ...rows, add, ...own, ...thickness];
}
