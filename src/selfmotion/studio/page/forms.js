// Forms made from the JSON Schema of problem files: what the library can be told can be told here.

import { html } from "selfmotion/svg";

const SECTIONS = new Set(["arm", "path", "task", "planner", "optimizer"]);
const LONG = 160; // characters that a field shows; what is longer is edited as text

let counter = 0;

export class Forms {
  // `begin(section, kind)` gives the data that a newly chosen kind begins with.
  constructor(schema, begin) {
    this.schema = schema;
    this.begin = begin;
  }

  kindsOf(section) { return this.#formsOf(section).map((form) => form.properties.kind.const); }

  #formsOf(section) { return this.schema.$defs[section].oneOf.map((one) => this.#resolved(one)); }

  #resolved(part) { return part.$ref ? this.schema.$defs[part.$ref.split("/").at(-1)] : part; }

  #formOf(section, kind) { return this.#formsOf(section).find((form) => form.properties.kind.const === kind); }

  // The fields of a section with a choice of its kind, or `bare` of them; `change(data)` hears of every edit.
  section(section, data, change, { bare = false } = {}) {
    const kinds = this.kindsOf(section).filter((kind) => kind === data.kind || this.begin(section, kind, data) !== null);
    const chosen = this.#select("kind", kinds, data.kind, (kind) => change(this.begin(section, kind, data)));
    const form = this.#formOf(section, data.kind);
    if (!form || bare) return html("div", {}, chosen);
    const about = form.description ? html("p", { class: "about" }, form.description.replaceAll("`", "")) : null;
    const fields = Object.entries(form.properties).filter(([name]) => name !== "kind").map(([name, part]) => {
      const set = (value) => {
        const { [name]: _, ...rest } = data;
        change(value === undefined ? rest : { ...data, [name]: value });
      };
      return this.field(name, part, data[name], set, `${section}.${name}`);
    });
    return html("div", { class: "section" }, chosen, about, ...fields);
  }

  field(name, part, value, set, where) {
    const inner = this.#resolved(part), nested = part.$ref?.split("/").at(-1);
    if (SECTIONS.has(nested) && value) {
      return html("fieldset", {}, html("legend", {}, name), this.section(nested, value, set));
    }
    if (inner.enum) return this.#select(name, inner.enum, value ?? inner.default, set, where);
    if (inner.type === "boolean") {
      const box = html("input", { type: "checkbox", checked: value ?? inner.default, onchange: () => set(box.checked) });
      return html("label", { class: "field check", "data-field": where }, box, words(name));
    }
    if (inner.type === "number" || inner.type === "integer") return this.#number(name, inner, value ?? inner.default, set, where);
    return this.#data(name, value, inner.default, set, where);
  }

  #select(name, options, value, set, where = null) {
    const id = `field-${(counter += 1)}`;
    const select = html("select", { id, onchange: () => set(options[select.selectedIndex]) },
      ...options.map((option) => html("option", { selected: option === value }, words(String(option)))));
    return labelled(name, id, select, where);
  }

  #number(name, form, value, set, where) {
    const id = `field-${(counter += 1)}`;
    const input = html("input", {
      id, type: "number", step: form.type === "integer" ? 1 : "any", value: value ?? "",
      onchange: () => { if (input.value !== "" && Number.isFinite(input.valueAsNumber)) set(input.valueAsNumber); },
    });
    return labelled(name, id, input, where);
  }

  // Lists and anything else as JSON on one line.
  #data(name, value, instead, set, where) {
    const id = `field-${(counter += 1)}`, text = value === undefined || value === null ? "" : compact(value);
    if (text.length > LONG) return html("p", { class: "field long", "data-field": where }, `${words(name)}: ${text.length} characters, see the text below`);
    const input = html("input", {
      id, value: text, spellcheck: false, placeholder: instead === null || instead === undefined ? "" : compact(instead),
      onchange: () => {
        const given = input.value.trim();
        if (!given) { input.setCustomValidity(""); set(undefined); return; }
        try {
          const data = JSON.parse(given);
          input.setCustomValidity("");
          set(data);
        } catch {
          if (/^[\w .µ/-]+$/u.test(given) && !/^[-\d]/.test(given)) { input.setCustomValidity(""); set(given); return; }
          input.setCustomValidity("write numbers in brackets, such as [30, 30, 20]");
          input.reportValidity();
        }
      },
    });
    return labelled(name, id, input, where);
  }
}

const compact = (value) => (typeof value === "string" ? value : JSON.stringify(value).replaceAll(",", ", "));

const words = (name) => name.replaceAll("_", " ");

export function labelled(name, id, input, where = null) {
  return html("div", { class: "field", "data-field": where }, html("label", { for: id }, words(name)), input);
}

// Links and limits of a planar arm as a table, one row per joint.
export function jointTable(arm, change) {
  const listed = (value) => (Array.isArray(value) ? value : []); // as text it may be anything
  const links = listed(arm.links), limits = listed(arm.limits);
  const set = (k, what) => {
    const newLinks = [...links], newLimits = links.map((_, i) => limits[i] ?? null);
    what(newLinks, newLimits);
    const plain = newLimits.every((limit) => limit === null);
    const { limits: _, ...rest } = arm;
    change(plain ? { ...rest, links: newLinks } : { ...rest, links: newLinks, limits: newLimits });
  };
  const number = (k, name, value, take) => {
    const input = html("input", {
      type: "number", step: "any", value: value ?? "", placeholder: "free", "aria-label": `${name} of joint ${k + 1}`,
      onchange: () => {
        if (input.value !== "" && !Number.isFinite(input.valueAsNumber)) return;
        const refused = take(input.value === "" ? null : input.valueAsNumber) ?? "";
        input.setCustomValidity(refused);
        if (refused) { input.reportValidity(); input.value = value; }
      },
    });
    return html("td", {}, input);
  };
  const side = (k, which) => (value) => set(k, (_, all) => {
    const pair = [...(all[k] ?? [null, null])];
    pair[which] = value;
    all[k] = pair.every((end) => end === null) ? null : pair;
  });
  const rows = links.map((length, k) => html("tr", {},
    html("th", { scope: "row" }, `θ${k + 1}`),
    number(k, "link length", length, (value) => { if (value > 0) set(k, (all) => { all[k] = value; }); else return "a length is positive"; }),
    number(k, "lower limit", limits[k]?.[0], side(k, 0)), number(k, "upper limit", limits[k]?.[1], side(k, 1)),
  ));
  const count = html("div", { class: "buttons" },
    html("button", { type: "button", onclick: () => set(0, (all, limit) => { all.push(all.at(-1) ?? 1); limit.push(null); }) }, "add a link"),
    html("button", { type: "button", disabled: links.length <= 3, onclick: () => set(0, (all, limit) => { all.pop(); limit.pop(); }) }, "remove one"));
  const head = html("tr", {}, ...["", "link", "lower [rad]", "upper [rad]"].map((name) => html("th", { scope: "col" }, name)));
  return html("div", {}, html("table", { class: "joints-table" }, html("thead", {}, head), html("tbody", {}, ...rows)), count);
}
