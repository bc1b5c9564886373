// @ts-check
// Numbers for reading, with their units.

/** A number as the server writes it: what is not known is null, what is infinite is a word. @typedef {number | "inf" | "-inf" | null | undefined} Numeric */

/** @type {[number, string][]} */
const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"]];
const PREFIXED = ["Pa", "m", "N", "J", "s"];

/**
 * A number with at most so many significant digits.
 * @param {number} value
 * @param {number} [digits]
 */
export function digits(value, digits = 4) {
  const size = Math.abs(value);
  if (value === 0) return "0";
  if (size >= 1e6 || size < 1e-4) return value.toExponential(Math.max(0, digits - 1)).replace(/\.?0+e/, "e").replace("e+", "e").replace("-", "−");
  return Number(value.toPrecision(digits)).toString().replace("-", "−");
}

/**
 * A number with its unit.
 * @param {Numeric} value
 * @param {string} [unit]
 * @param {number} [count]
 */
export function quantity(value, unit = "", count = 4) {
  if (value === null || value === undefined) return "–";
  if (typeof value === "string") return value === "inf" ? "∞" : "−∞";
  if (unit === "deg") return `${digits(value, count)}°`;
  if (PREFIXED.includes(unit) && value !== 0) {
    const size = Math.abs(value) * (1 + 1e-9);
    const [factor, prefix] = PREFIXES.find(([factor]) => size >= factor) ?? [1, ""];
    return `${digits(value / factor, count)}\u202f${prefix}${unit}`;
  }
  return unit ? `${digits(value, count)}\u202f${unit}` : digits(value, count);
}

/**
 * A time of work.
 * @param {Numeric} value seconds
 */
export function duration(value) {
  if (typeof value !== "number") return "–";
  if (value < 60) return `${digits(value, 2)}\u202fs`;
  if (value < 3600) return `${Math.floor(value / 60)}\u202fmin ${Math.round(value % 60)}\u202fs`;
  return `${Math.floor(value / 3600)}\u202fh ${Math.round((value % 3600) / 60)}\u202fmin`;
}

/**
 * A name in words.
 * @param {string} name
 */
export function words(name) {
  return name.replaceAll("_", " ");
}

/**
 * How many of something.
 * @param {number} count
 * @param {string} one
 * @param {string} [several]
 */
export function counted(count, one, several = `${one}s`) {
  return `${count} ${count === 1 ? one : several}`;
}
