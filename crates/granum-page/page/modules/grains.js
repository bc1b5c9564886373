// @ts-check
// The grains of a run in three dimensions, by the viewer of granum's reports.

import { show } from "./viewer.js";
import { element, replace } from "./dom.js";
import { choice, trouble } from "./parts.js";
import { data } from "./server.js";

/**
 * A part of a page that shows the grains when it is opened.
 * @param {string} path
 * @param {string[]} snapshots
 * @param {AbortSignal} signal
 */
export function grains(path, snapshots, signal) {
  const usual = snapshots.includes("end") ? "end" : snapshots[0] ?? "";
  const asked = { snapshot: usual, colour: "radius" };
  const place = element("div", {});
  let begun = false;
  const draw = async () => {
    replace(place, element("p", { class: "note" }, "Reading the grains …"));
    try {
      const found = await data("grains", { path, ...asked }, signal);
      const colours = found.colours.map((/** @type {string} */ value) => ({ value, text: value.replaceAll("_", " ") }));
      const names = snapshots.map(value => ({ value, text: value }));
      const again = (/** @type {Partial<typeof asked>} */ change) => { Object.assign(asked, change); void draw(); };
      const stage = viewer(`${found.grains} grains at ${asked.snapshot}`);
      replace(place,
        element("div", { class: "tools" },
          choice("Snapshot", names, asked.snapshot, snapshot => again({ snapshot })),
          choice("Colour by", colours, asked.colour, colour => again({ colour }))),
        stage);
      show(stage, found.data);
    } catch (error) {
      if (!signal.aborted) replace(place, trouble(error));
    }
  };
  const details = element("details", {}, element("summary", {}, "Grains and forces in three dimensions"), place);
  details.addEventListener("toggle", () => {
    if (details.open && !begun) { begun = true; void draw(); }
  });
  return details;
}

/**
 * The elements that the viewer fills, under the names that it knows.
 * @param {string} title
 */
function viewer(title) {
  const box = (/** @type {string} */ id, /** @type {string} */ text, checked = false) =>
    element("label", {}, element("input", { type: "checkbox", id, checked }), text);
  const slider = (/** @type {string} */ id, /** @type {number} */ min, /** @type {number} */ value) =>
    element("label", {}, id, element("input", { type: "range", id, min, max: 1, step: 0.01, value }));
  const label = `${title}: turn with the mouse or the arrow keys, nearer and farther with the wheel or plus and minus`;
  return element("div", { id: "stage" },
    element("canvas", { id: "view", tabindex: "0", role: "img", "aria-label": label }),
    element("div", { id: "panel" },
      box("grains", "grains", true), slider("opacity", 0, 0.25), slider("size", 0.1, 1), slider("cut", 0, 0),
      box("forces", "forces", true), box("chains", "force chains alone"), box("bonds", "bonds", true), box("cracks", "cracks", true),
      element("div", { class: "scale" }, element("div", { id: "scale" }),
        element("div", { id: "ends" }, element("span", { id: "low" }), element("span", { id: "name" }), element("span", { id: "high" }))),
      element("p", { id: "note" })));
}
