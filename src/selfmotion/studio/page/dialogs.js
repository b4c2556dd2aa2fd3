// Opening, saving and exporting.

import { ask } from "selfmotion/requests";
import { html } from "selfmotion/svg";

const FORMATS = [
  ["csv", "Trajectory (CSV)", "joint angles and u against r, at the samples and at every given waypoint"],
  ["plan", "Plan (JSON)", "all of it: selfmotion time makes an executable trajectory of it"],
  ["png", "Figures (PNG)", "postures, joints and the motion in the angle domain"],
  ["gif", "Animation (GIF)", "the arm on its path, and its way through the angle domain"],
  ["json", "Result (JSON)", "the figures that selfmotion plan --json prints"],
];

const dialog = document.querySelector("#dialog");

function show(title, ...content) {
  const close = html("button", { type: "button", class: "close", "aria-label": "close", onclick: () => dialog.close() }, "✕");
  dialog.replaceChildren(html("div", { class: "bar" }, html("h2", { id: "dialog-title" }, title), close), ...content);
  if (!dialog.open) dialog.showModal();
}

function complaint(error) {
  const { message, remedy } = error.data ?? { message: String(error) };
  return html("p", { class: "complaint", role: "alert" }, remedy ? `${message}; ${remedy}` : message);
}

const button = (text, act, extra = {}) => html("button", { type: "button", onclick: act, ...extra }, text);

// Choose an example, a file of the folder or one of this machine; `use({problem, file})` takes it.
export async function openDialog(use) {
  const list = html("div", { class: "choices" }, html("p", {}, "Looking…"));
  const said = html("div");
  const input = html("input", { type: "file", accept: ".yaml,.yml,.json", "aria-label": "problem file on this machine" });
  const take = async (work) => {
    try {
      use(await work());
      dialog.close();
    } catch (error) {
      said.replaceChildren(complaint(error));
    }
  };
  input.addEventListener("change", () => input.files.length && take(async () => {
    const [file] = input.files;
    return { problem: (await ask("read", { text: await file.text() })).problem, file: file.name };
  }));
  show("Open a problem", said, list, html("label", { class: "field" }, "or a file from elsewhere ", input));
  try {
    const [examples, { folder, files }] = await Promise.all([ask("examples"), ask("files")]);
    list.replaceChildren(
      html("h3", {}, "Examples"),
      ...examples.map((example) => button(example.title, () => take(async () => ({ problem: example.problem, file: null })))),
      html("h3", {}, `Files in ${folder}`),
      ...files.map((file) => button(file, () => take(async () => ({ ...(await ask("open", { file })), file })), { class: "file" })),
      ...(files.length ? [] : [html("p", {}, "none")]),
    );
  } catch (error) {
    list.replaceChildren(complaint(error));
  }
}

export function saveDialog(state, saved) {
  const name = html("input", { id: "save-name", value: state.file ?? "problem.yaml", spellcheck: false });
  const said = html("div");
  const save = async (force) => {
    try {
      const given = name.value.trim(), full = /\.\w+$/.test(given) ? given : `${given}.yaml`;
      const { file } = await ask("save", { file: full, problem: state.problem, force });
      saved(file);
      dialog.close();
    } catch (error) {
      said.replaceChildren(complaint(error), error.data?.field === "force" ? button("Replace it", () => save(true)) : "");
    }
  };
  name.addEventListener("keydown", (event) => { if (event.key === "Enter") save(false); });
  const curve = state.hand ? " The curve by hand is not part of a problem file: copy the link, or export its plan." : "";
  show("Save the problem", html("p", {}, `In the folder that the studio was started for.${curve}`), html("div", { class: "field" }, html("label", { for: "save-name" }, "file"), name),
    said, html("div", { class: "buttons" }, button("Save", () => save(false), { class: "primary" })));
}

// Files of a plan, or of a curve moved by hand: `what` is {problem, plan} or {problem, hand}, or null.
export function exportDialog(what, drawn, planar) {
  const said = html("div", { role: "status" });
  const make = async (format) => {
    said.replaceChildren(html("p", {}, "Working…"));
    try {
      const { name, type, data } = await ask("export", { format, ...what });
      download(name, new Blob([Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0))], { type }));
      said.replaceChildren(html("p", {}, `${name} is in your downloads`));
    } catch (error) {
      said.replaceChildren(complaint(error));
    }
  };
  const choices = FORMATS.filter(([format]) => planar || format !== "gif").map(([format, title, about]) =>
    button(title, () => make(format), { title: about, "data-format": format, disabled: what === null }));
  const picture = button("This picture (SVG)", () => download("angle-domain.svg", drawn()), { "data-format": "svg" });
  show("Export", what ? html("p", {}, what.hand ? "Of the curve moved by hand." : "Of the plan.") : html("p", {}, "Plan first, or move a curve by hand: then there is a motion to export."),
    html("div", { class: "choices" }, ...choices, picture), said);
}

function download(name, blob) {
  const address = URL.createObjectURL(blob);
  const link = html("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

// Returns whether it is in the clipboard; if not, it is shown.
export async function copyLink(address) {
  try {
    await navigator.clipboard.writeText(address);
    return true;
  } catch {
    const field = html("textarea", { readonly: true, rows: 6, "aria-label": "link" });
    field.value = address;
    show("Link", html("p", {}, "It opens this very state in this browser, while the studio runs on the same port."), field);
    field.select();
    return false;
  }
}

export function tell(title, error) { show(title, complaint(error)); }
