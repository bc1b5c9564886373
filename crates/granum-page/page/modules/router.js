// @ts-check
// What is shown stands in the address behind the hash: #/run?path=a/b.

/** @typedef {{ name: string, query: URLSearchParams }} Route */

/** The route of the present address. @returns {Route} */
export function present() {
  const [name, query] = location.hash.replace(/^#\/?/, "").split("?");
  return { name: name || "list", query: new URLSearchParams(query ?? "") };
}

/**
 * The address of a route.
 * @param {string} name
 * @param {Record<string, string | string[] | number | undefined>} [query]
 */
export function to(name, query = {}) {
  const search = new URLSearchParams();
  for (const [key, value] of Object.entries(query)) {
    for (const text of Array.isArray(value) ? value : [value]) if (text !== undefined && text !== "") search.append(key, String(text));
  }
  const text = search.toString();
  return `#/${name === "list" ? "" : name}${text ? `?${text}` : ""}`;
}

/**
 * Changes the query of the present route without showing it anew.
 * @param {Record<string, string | string[] | number | undefined>} query
 */
export function remember(query) {
  history.replaceState(null, "", to(present().name, query));
}
