// Colours and dashes of joints: told apart by the colour-blind, and in grey.

const DASHES = ["", "7 2.5", "2 2", "8 2.5 2 2.5", "4.5 2", "11 3", "1.5 3", "6 2 1.5 2 1.5 2"];

export const jointLook = (joint) => ({ class: `joint-${joint % 8}`, "stroke-dasharray": DASHES[joint % DASHES.length] });

export const jointName = (scene, joint) => `${scene.slides?.[joint] ? "q" : "θ"}${joint + 1}`;

// Lower limits have long dashes and upper ones short dashes, with one dot fewer than the joint's number between them.
export function causeLook(cause) {
  if (cause.joint < 0 || cause.kind === "fold") return { class: "edge fold" };
  if (!cause.kind.includes("limit")) return { class: "edge" };
  const dash = cause.kind === "lower limit" ? "8 2.5" : "3.5 2.5";
  return { class: `edge joint-${cause.joint % 8}`, "stroke-dasharray": `${dash}${" 1.5 2.5".repeat(Math.min(cause.joint, 4))}` };
}
