// @ts-check
// The only module that asks the server.

const KEY = "granum-token";

/** Takes the token from the address, where it would be seen and copied, and keeps it for this page and its tabs. */
export function takeToken() {
  const address = new URL(location.href);
  const token = address.searchParams.get("token");
  if (!token) return;
  localStorage.setItem(KEY, token);
  address.searchParams.delete("token");
  history.replaceState(null, "", address.pathname + address.search + address.hash);
}

/** What the server says when it does not answer. */
export class Refused extends Error {
  /**
   * @param {number} status
   * @param {string} reason
   */
  constructor(status, reason) {
    super(reason);
    this.status = status;
  }
}

/** A query: a name has a text, a number or several texts. @typedef {Record<string, string | number | string[] | undefined>} Query */

/**
 * @param {string} name
 * @param {Query} query
 */
function address(name, query) {
  const search = new URLSearchParams();
  for (const [key, value] of Object.entries(query)) {
    for (const text of Array.isArray(value) ? value : [value]) if (text !== undefined) search.append(key, String(text));
  }
  return `/api/${name}?${search}`;
}

/**
 * @param {string} name
 * @param {Query} query
 * @param {AbortSignal} [signal]
 */
async function ask(name, query, signal) {
  const headers = { Authorization: `Bearer ${localStorage.getItem(KEY) ?? ""}` };
  let response;
  try {
    response = await fetch(address(name, query), { headers, signal: signal ?? null, cache: "no-store" });
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    throw new Refused(0, "granum serve does not answer; it may have been ended");
  }
  if (response.ok) return response;
  const said = await response.json().catch(() => ({}));
  throw new Refused(response.status, typeof said.error === "string" ? said.error : `status ${response.status}`);
}

/**
 * Data.
 * @param {string} name
 * @param {Query} [query]
 * @param {AbortSignal} [signal]
 * @returns {Promise<any>}
 */
export async function data(name, query = {}, signal) {
  return (await ask(name, query, signal)).json();
}

/**
 * A figure as text.
 * @param {string} name
 * @param {Query} query
 * @param {AbortSignal} [signal]
 */
export async function figure(name, query, signal) {
  return (await ask(name, query, signal)).text();
}
