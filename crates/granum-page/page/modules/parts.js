// @ts-check
// What several views have: command lines, tables, states.

import { announce, element } from "./dom.js";
import { quantity, words } from "./numbers.js";

/** @typedef {{ what: string, command: string }} Command */

/**
 * Command lines with what they are for, and buttons that copy them.
 * @param {Command[]} commands
 * @param {string} [title]
 */
export function commandLines(commands, title = "The same in the terminal") {
  if (commands.length === 0) return null;
  const line = (/** @type {Command} */ { what, command }) => {
    const copy = async () => {
      let done = true;
      try {
        await navigator.clipboard.writeText(command);
      } catch {
        done = false;
        getSelection()?.selectAllChildren(text);
      }
      button.textContent = done ? "Copied" : "Selected";
      announce(done ? `Copied: ${command}` : "The command is selected; copy it with the keyboard");
      setTimeout(() => { button.textContent = "Copy"; }, 2000);
    };
    const text = element("code", {}, command);
    const button = element("button", { type: "button", onclick: copy, "aria-label": `Copy: ${command}` }, "Copy");
    return element("li", {}, element("span", {}, what), text, button);
  };
  return element("section", {},
    element("h2", {}, title), element("ul", { class: "commands" }, commands.map(line)));
}

/**
 * A state as a word with a border, which colours only underline.
 * @param {string} word
 */
export function state(word) {
  return element("span", { class: `status ${word.split(/[ ,]/)[0]}` }, word);
}

/** @typedef {{ name: string, unit: string, is_number: boolean, values: any[] }} Column */

/**
 * A table of columns. The cells of the first column are links where an address is given.
 * @param {string} caption
 * @param {Column[]} columns
 * @param {(row: number) => string | null} [address]
 */
export function table(caption, columns, address) {
  const rows = columns[0]?.values.length ?? 0;
  const cell = (/** @type {Column} */ column, /** @type {number} */ place, /** @type {number} */ row) => {
    const value = column.values[row];
    const text = column.is_number ? quantity(value, column.unit) : String(value ?? "");
    const to = place === 0 ? address?.(row) : null;
    const content = to ? element("a", { href: to }, text) : text;
    return place === 0
      ? element("th", { scope: "row", class: "word" }, content)
      : element("td", { class: column.is_number ? null : "word" }, content);
  };
  const head = columns.map(column => element("th", { scope: "col", class: column.is_number ? null : "word" }, words(column.name)));
  const body = Array.from({ length: rows }, (_, row) => element("tr", {}, columns.map((column, place) => cell(column, place, row))));
  return scrolling(caption, element("table", {},
    element("caption", {}, caption), element("thead", {}, element("tr", {}, head)), element("tbody", {}, body)));
}

/** A marked-up text as the program tells it: its parts, each with the names of its elements. @typedef {[string, string][]} Rich */
/** @typedef {{ passed: boolean, name: Rich, before: Rich, value: Rich, after: Rich, advice: string }} Check */
/** @typedef {{ label: string, caption: Rich, groups: [Rich, number][], columns: Rich[], rows: Rich[][], words: number, note: Rich }} PageTable */
/** @typedef {{ tiles: [Rich, Rich, Rich][], signs: Rich, unfinished: Rich | null, verdict: Rich, checks: Check[], strength: PageTable | null }} Presented */

/**
 * A marked-up text.
 * @param {Rich} parts
 * @returns {(Node | string)[]}
 */
export const rich = parts => parts.map(([text, kinds]) => kinds.split(" ").reverse().reduce(
  (/** @type {Node | string} */ inner, kind) => (kind === "i" || kind === "sub" || kind === "sup" ? element(kind, {}, inner) : inner), text));

/**
 * The main numbers side by side, as a report has them.
 * @param {[Rich, Rich, Rich][]} found
 */
export function tiles(found) {
  return found.length === 0 ? null : element("ul", { class: "tiles" }, found.map(([value, name, remark]) =>
    element("li", { class: "tile" }, element("b", {}, rich(value)), element("span", {}, rich(name)), remark.length > 0 && element("small", {}, rich(remark)))));
}

/**
 * Whether a result can be trusted, as its report says it; open where it cannot.
 * @param {Presented} found
 */
export function trust({ verdict, checks }) {
  if (checks.length === 0) return null;
  const line = (/** @type {Check} */ check) => element("li", { class: check.passed ? "passed" : "missed" },
    rich(check.name), ": ", rich(check.before), element("b", {}, rich(check.value)), rich(check.after),
    check.advice && [" What to do: ", element("span", { class: "advice" }, `${check.advice}.`)]);
  return element("details", { open: checks.some(check => !check.passed) },
    element("summary", {}, "Can it be trusted? ", rich(verdict)), element("ul", { class: "checks" }, checks.map(line)));
}

/**
 * A table of marked-up text, as a report has it.
 * @param {PageTable} table
 */
export function richTable({ label, caption, groups, columns, rows, words, note }) {
  const kind = (/** @type {number} */ place) => (place < words ? "word" : null);
  const name = caption.map(([text]) => text).join("");
  return scrolling(label || name, element("table", {},
    element("caption", {}, label && element("b", {}, `${label}. `), rich(caption)),
    element("thead", {},
      groups.length > 0 && element("tr", {}, groups.map(([head, span]) => element("th", { colspan: span, class: head.length > 0 ? "group" : null }, rich(head)))),
      element("tr", {}, columns.map((head, place) => element("th", { scope: "col", class: kind(place) }, rich(head))))),
    element("tbody", {}, rows.map(row => element("tr", {}, row.map((cell, place) => element("td", { class: kind(place) }, rich(cell))))))),
    note.length > 0 && element("p", { class: "note" }, rich(note)));
}

/**
 * What scrolls where it has no room, with the keyboard as well.
 * @param {string} label
 * @param {...import("./dom.js").Child} content
 */
export function scrolling(label, ...content) {
  return element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": label }, ...content);
}

/**
 * Something that could not be shown, and why.
 * @param {unknown} error
 */
export function trouble(error) {
  const text = error instanceof Error ? error.message : String(error);
  return element("p", { class: "callout bad", role: "alert" }, text);
}

/**
 * A labelled choice.
 * @param {string} label
 * @param {{ value: string, text: string }[]} options
 * @param {string} chosen
 * @param {(value: string) => void} changed
 */
export function choice(label, options, chosen, changed) {
  const select = element("select", { onchange: () => changed(select.value) },
    options.map(({ value, text }) => element("option", { value, selected: value === chosen }, text)));
  return element("label", {}, label, select);
}

/**
 * Buttons for the rows before and after.
 * @param {{ from: number, shown: number, total: number, step: number }} rows
 * @param {(from: number) => void} changed
 */
export function pages({ from, shown, total, step }, changed) {
  if (total <= step && from === 0) return null;
  return element("div", { class: "tools" },
    element("button", { type: "button", disabled: from === 0, onclick: () => changed(Math.max(0, from - step)) }, "Before"),
    element("span", {}, `${shown === 0 ? 0 : from + 1} to ${from + shown} of ${total}`),
    element("button", { type: "button", disabled: from + shown >= total, onclick: () => changed(from + step) }, "Next"));
}
