// @ts-check
// Figures are drawn by granum as SVG and shown as pictures, in which nothing is executed or loaded.

import { element } from "./dom.js";

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

/**
 * A figure whose points open what they stand for.
 * @param {string} svg
 * @param {string} title
 * @param {string} caption
 * @param {MapPoint[]} points
 * @param {(path: string) => string} address
 * @param {AbortSignal} signal
 */
export function map(svg, title, caption, points, address, signal) {
  const link = (/** @type {MapPoint} */ point) => {
    if (point.path === null) return null;
    const made = element("a", { class: "point", href: address(point.path), title: point.name, "aria-label": point.name });
    made.style.left = `${100 * point.left}%`;
    made.style.top = `${100 * point.top}%`;
    return made;
  };
  const shown = picture(svg, title, signal);
  const sheet = element("div", { class: "sheet" }, shown, points.map(link));
  const canvas = element("div", { class: "canvas", role: "group", "aria-label": title, tabindex: "0" }, sheet);
  return element("figure", {}, canvas, element("figcaption", {}, caption));
}
