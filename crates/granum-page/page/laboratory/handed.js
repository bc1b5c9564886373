// @ts-check
// The files that a case names: the reader hands them to the page, which gives them to the module that reads them and to nobody else.

import { announce, element, replace } from "../modules/dom.js";
import { size } from "../modules/numbers.js";
import { trouble } from "../modules/parts.js";

/** The most bytes of the text of a case. */
const LONGEST_CASE = 1 << 20;

/**
 * The content of a file in base64.
 * @param {File} file
 * @returns {Promise<string>}
 */
const content = file => new Promise((done, failed) => {
  const reader = new FileReader();
  reader.addEventListener("load", () => done(String(reader.result).replace(/^[^,]*,/, "")));
  reader.addEventListener("error", () => failed(new Error(`The file ${file.name} cannot be read.`)));
  reader.readAsDataURL(file);
});

/** The name by which a case knows a file: that in a chosen folder begins with the name of the folder. @param {File} file */
const nameOf = file => file.webkitRelativePath || file.name;

/** @typedef {import("./engine.mjs").Engine} Engine */

/**
 * Offers to hand over files. A file that ends in .toml is a case and takes the place of the one that is shown.
 * @param {{ engine: Engine, surrogates: () => Promise<Engine> }} modules the second one reads files
 * @param {HTMLElement} target where files can be dropped as well
 * @param {{ changed: () => void, open: (text: string, name: string) => void }} page
 * @returns {{ offer: HTMLElement, reader: () => Engine }} the offer, and the module that reads a case with the files that are there now
 */
export function handed(modules, target, page) {
  let reader = modules.engine;
  /** @type {Map<string, { bytes: number, content: string }>} */
  const files = new Map();
  const list = element("ul", { class: "checks", id: "files" }), fault = element("div", { role: "alert" });

  async function give() {
    const second = files.size > 0 || reader !== modules.engine ? await modules.surrogates() : null;
    second?.call("files", { files: Object.fromEntries([...files].map(([name, file]) => [name, file.content])) });
    reader = files.size > 0 && second ? second : modules.engine;
    replace(list, [...files].map(([name, file]) => element("li", {}, `${name}, ${size(file.bytes)} `,
      element("button", { type: "button", "aria-label": `Take away ${name}`, onclick: () => { files.delete(name); void give(); } }, "×"))));
    page.changed();
  }

  /** @param {FileList | File[]} chosen */
  async function take(chosen) {
    replace(fault);
    const before = new Map(files);
    try {
      const cases = [...chosen].filter(file => /\.toml$/i.test(file.name));
      for (const file of [...chosen].filter(file => !cases.includes(file))) files.set(nameOf(file), { bytes: file.size, content: await content(file) });
      await give();
      const first = cases[0];
      if (!first) return announce("The files are there for the case");
      if (first.size > LONGEST_CASE) throw new Error(`The file ${first.name} is no case: it has ${size(first.size)}.`);
      page.open(await first.text(), first.name);
      announce(`The case is that of ${first.name}`);
    } catch (error) {
      files.clear();
      before.forEach((file, name) => files.set(name, file));
      await give();
      replace(fault, trouble(error));
    }
  }

  const chosen = (/** @type {Event} */ event) => {
    const input = /** @type {HTMLInputElement} */ (event.currentTarget);
    // The list of the input is emptied with it.
    const found = [...(input.files ?? [])];
    input.value = "";
    void take(found);
  };
  target.addEventListener("dragover", event => event.preventDefault());
  target.addEventListener("drop", event => {
    if (!event.dataTransfer?.files.length) return;
    event.preventDefault();
    void take(event.dataTransfer.files);
  });
  const offer = element("details", { id: "handed" },
    element("summary", {}, "Files that the case names, or a case of your own"),
    element("p", { class: "note" }, "Meshes of grains (STL, OBJ, PLY), stacks of images (TIFF), sieve curves, histories and files of the IncrementalDriver, under the names that the case gives them; a file that ends in .toml is taken as the case. They stay in this browser."),
    element("div", { class: "tools" },
      element("label", {}, "Files", element("input", { type: "file", multiple: true, onchange: chosen })),
      element("label", {}, "A folder of images", element("input", { type: "file", webkitdirectory: true, onchange: chosen }))),
    list, fault);
  return { offer, reader: () => reader };
}
