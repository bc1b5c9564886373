// @ts-check
// Figures are drawn by granum as SVG and shown as pictures, in which nothing is executed or loaded.

import { element } from "./dom.js";
import { quantity } from "./numbers.js";

/** Width of a picture from which it is scrolled on a narrow screen. */
const WIDE = 560;

/**
 * A picture of an SVG text. Its address is given back when the signal says that it is no longer shown.
 * @param {string} svg
 * @param {string} title
 * @param {AbortSignal} signal
 */
export function picture(svg, title, signal) {
  const address = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  signal.addEventListener("abort", () => URL.revokeObjectURL(address));
  const width = Number(/<svg[^>]* width="([\d.]+)"/.exec(svg)?.[1] ?? 0);
  const height = Number(/<svg[^>]* height="([\d.]+)"/.exec(svg)?.[1] ?? 0);
  const size = width && height ? { width: Math.round(width), height: Math.round(height) } : {};
  return element("img", { src: address, alt: title, class: width > WIDE ? "wide" : null, ...size });
}

/**
 * A figure with its caption. A wide one can be scrolled with the keyboard where there is no room.
 * @param {string} svg
 * @param {string} title
 * @param {string} caption
 * @param {AbortSignal} signal
 */
export function figure(svg, title, caption, signal) {
  const canvas = element("div", { class: "canvas", tabindex: "0", role: "group", "aria-label": title }, picture(svg, title, signal));
  return element("figure", {}, canvas, element("figcaption", {}, caption));
}

/**
 * @typedef {{ name: string, path: string | null, x: any, y: any, left: number, top: number, flagged: boolean }} MapPoint
 */

/** Most points that are links. */
const MOST = 2000;

/**
 * A figure whose points open what they stand for. The points are one stop of the keyboard; the arrows go from one to the next, from left to right.
 * @param {string} svg
 * @param {string} title
 * @param {string} caption
 * @param {MapPoint[]} points
 * @param {(path: string) => string} address
 * @param {AbortSignal} signal
 */
export function map(svg, title, caption, points, address, signal) {
  const known = points.filter(point => point.path !== null).sort((a, b) => a.left - b.left || b.top - a.top).slice(0, MOST);
  const links = known.map((point, k) => {
    const text = `${point.name}: ${quantity(point.x)}, ${quantity(point.y)}`;
    const made = element("a", { class: "point", href: address(point.path ?? ""), title: text, "aria-label": text, tabindex: k === 0 ? "0" : "-1" });
    made.style.left = `${100 * point.left}%`;
    made.style.top = `${100 * point.top}%`;
    return made;
  });
  const step = (/** @type {KeyboardEvent} */ event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1, Home: -links.length, End: links.length }[event.key];
    const from = links.findIndex(link => link === document.activeElement);
    if (by === undefined || from < 0) return;
    event.preventDefault();
    const next = links[Math.max(0, Math.min(links.length - 1, from + by))];
    for (const link of links) link.tabIndex = link === next ? 0 : -1;
    next?.focus();
  };
  const sheet = element("div", { class: "sheet", onkeydown: step }, picture(svg, title, signal), links);
  const canvas = element("div", { class: "canvas", role: "group", "aria-label": title, tabindex: "0" }, sheet);
  const more = known.length < points.filter(point => point.path !== null).length ? ` The first ${MOST} marks can be opened.` : "";
  return element("figure", {}, canvas, element("figcaption", {}, caption + more));
}
