// in-browsers.mjs FOLDER [--speed]: compares the modules of a folder with the program's digests in Chromium, in Chromium without FMA3, and in Firefox,
// which must be installed; with --speed the time of a step is measured instead. The environment names the programs: CHROMIUM, FIREFOX.

import { spawn } from "node:child_process";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const folder = process.argv[2], asked = process.argv.includes("--speed") ? "speed" : "compare";
const root = fileURLToPath(new URL("../../../", import.meta.url));
const TYPES = { ".mjs": "text/javascript", ".wasm": "application/wasm", ".html": "text/html" };
const PAGE = `<!doctype html><title>Comparison of digests</title><script type="module">
import { ${asked} as work } from "/crates/granum-browser/tools/${asked}.mjs";
const tell = (kind, text) => fetch("/" + kind, { method: "POST", body: text });
const read = async path => new Uint8Array(await (await fetch("/" + path)).arrayBuffer());
const load = async name => { const found = await fetch("/modules/" + name + ".wasm"); return found.ok ? found.arrayBuffer() : null; };
try { await tell("ended", String(await work(read, load, line => tell("said", line)))); } catch (error) { await tell("ended", String(error)); }
</script>`;

let ended = () => {};
const server = createServer((request, response) => {
  const path = normalize(decodeURIComponent(request.url ?? "/").split("?")[0]);
  if (request.method === "POST") {
    let text = "";
    request.on("data", part => (text += part)).on("end", () => { response.end(); path === "/ended" ? ended(text) : console.log("  " + text); });
    return;
  }
  if (path === "/") return response.setHeader("content-type", "text/html").end(PAGE);
  const file = path.startsWith("/modules/") ? join(folder, path.slice("/modules/".length)) : join(root, path);
  readFile(file).then(
    content => response.setHeader("content-type", TYPES[path.slice(path.lastIndexOf("."))] ?? "text/plain").end(content),
    () => { response.statusCode = 404; response.end(); },
  );
});
await new Promise(done => server.listen(0, "127.0.0.1", () => done(null)));
const url = `http://127.0.0.1:${server.address().port}/`;

async function inBrowser(name, program, flags) {
  console.log(name);
  const profile = await mkdtemp(join(tmpdir(), "granum-browser-"));
  const child = spawn(program, flags(profile), { stdio: "ignore" });
  const failed = new Promise(done => child.on("error", error => done(`it does not start: ${error.message}`)));
  const late = new Promise(done => setTimeout(() => done("it takes longer than ten minutes"), 600_000).unref());
  const told = await Promise.race([new Promise(done => (ended = done)), failed, late]);
  child.kill();
  await rm(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 500 }).catch(() => {});
  if (told === "0") return true;
  console.log(`  ${Number(told) > 0 ? `${told} digests differ` : told}`);
  return false;
}

const chromium = more => profile => ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", `--user-data-dir=${profile}`, ...more, url];
const browsers = [
  ["Chromium", process.env.CHROMIUM ?? "chromium", chromium([])],
  ["Chromium without the instruction FMA3", process.env.CHROMIUM ?? "chromium", chromium(["--js-flags=--no-enable-fma3"])],
  ["Firefox", process.env.FIREFOX ?? "firefox-esr", profile => ["--headless", "--no-remote", "--profile", profile, url]],
];
let good = true;
for (const browser of browsers) good = (await inBrowser(...browser)) && good;
server.close();
process.exit(good ? 0 : 1);
