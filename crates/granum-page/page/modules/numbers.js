// @ts-check
// Numbers for reading, with their units.

/** A number as the server writes it: what is not known is null, what is infinite is a word. @typedef {number | "inf" | "-inf" | null | undefined} Numeric */

/** @type {[number, string][]} */
const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "μ"], [1e-9, "n"]];
const PREFIXED = ["Pa", "m", "N", "J", "s"];
/** Narrow no-break space, between groups of digits and before units. */
const THIN = "\u202f";

/** A whole number raised. @param {number} value */
const raised = value => [...String(value)].map(sign => (sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(sign)])).join("");

/** The digits before the point in groups of three, if there are more than four. @param {string} text */
function grouped(text) {
  const [head = "", tail] = text.split(".");
  const groups = head.replace("-", "").length > 4 ? head.replace(/\B(?=(\d{3})+$)/g, THIN) : head;
  return tail === undefined ? groups : `${groups}.${tail}`;
}

/**
 * A number with at most so many significant digits, as reports have it: with a power of ten below a thousandth and from a million on.
 * @param {number} value
 * @param {number} [count]
 */
export function digits(value, count = 4) {
  if (value === 0) return "0";
  const [mantissa = "0", exponent] = value.toExponential(count - 1).split("e"), power = Number(exponent);
  if (power < -3 || power >= 6) return `${mantissa} × 10${raised(power)}`.replace("-", "−");
  const text = value.toFixed(Math.max(0, count - 1 - power));
  return grouped(text.includes(".") ? text.replace(/\.?0+$/, "") : text).replace("-", "−");
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
    const [factor, prefix] = PREFIXES.find(([factor]) => size >= factor) ?? [1e-9, "n"];
    return `${digits(value / factor, count)}${THIN}${prefix}${unit}`;
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
 * The size of a file.
 * @param {number} value bytes
 */
export function size(value) {
  return value < 1000 ? counted(value, "byte") : `${digits(value / (value < 1e6 ? 1e3 : 1e6), 3)}\u202f${value < 1e6 ? "kB" : "MB"}`;
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
