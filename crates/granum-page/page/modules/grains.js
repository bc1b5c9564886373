// @ts-check
// The grains of a run in three dimensions, by the viewer of granum's reports.

import { show, stage } from "./viewer.js";
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
      const shown = stage(`${found.grains} grains at ${asked.snapshot}`);
      replace(place,
        element("div", { class: "tools" },
          choice("Snapshot", names, asked.snapshot, snapshot => again({ snapshot })),
          choice("Colour by", colours, asked.colour, colour => again({ colour }))),
        shown);
      show(shown, found.data);
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
