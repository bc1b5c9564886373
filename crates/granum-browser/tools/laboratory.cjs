// laboratory.cjs FOLDER SHOTS [views | NAME]: opens the laboratory of a folder that scripts/page made in Chromium, asks a surrogate, makes a test, and looks for what should
// not be: errors of the console, requests to elsewhere, violations of axe, a page wider than the window. With `views` only what views.cjs asks is tried, with a name one of it. NODE_PATH has
// playwright-core and axe-core.

const { chromium } = require("playwright-core");
const http = require("http"), fs = require("fs"), path = require("path");

const { views } = require("./views.cjs");

const [folder, shots, only] = process.argv.slice(2);
const TYPES = { ".wasm": "application/wasm", ".js": "text/javascript", ".mjs": "text/javascript", ".html": "text/html", ".css": "text/css", ".json": "application/json", ".svg": "image/svg+xml" };
const problems = [];
const expect = (holds, what) => { console.log(`${holds ? "ok" : "NOT OK"}  ${what}`); if (!holds) problems.push(what); };

async function main() {
  const server = http.createServer((request, response) => {
    let place = path.normalize(request.url.split("?")[0]);
    if (place.endsWith("/")) place += "index.html";
    const file = path.join(folder, place);
    if (!fs.existsSync(file)) { console.log(`there is no ${place}`); response.statusCode = 404; return response.end(); }
    response.setHeader("content-type", TYPES[path.extname(file)] ?? "text/plain");
    fs.createReadStream(file).pipe(response);
  });
  await new Promise(done => server.listen(0, "127.0.0.1", done));
  const url = `http://127.0.0.1:${server.address().port}/`;
  // Without a graphics processor WebGL is computed.
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run", "--disable-background-networking"] });
  const watch = page => {
    // What colours the examples of the book complains about languages that it does not know.
    page.on("console", message => { if (!message.location().url.includes("/book/highlight-") && (message.type() === "error" || message.type() === "warning")) problems.push(`console: ${message.text()}`); });
    page.on("pageerror", error => problems.push(`page: ${error.message}`));
    page.on("request", request => { if (![url, "blob:", "data:"].some(start => request.url().startsWith(start))) problems.push(`a request to ${request.url()}`); });
  };
  await views({ browser, url, folder, expect, watch, shots }, only);
  if (only) { await browser.close(); return server.close(); }
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 } });
  watch(page);
  await page.goto(url);
  await page.waitForSelector("#case", { timeout: 60_000 });

  await page.fill("#case", "[grains]\ncount = 100\ndiametre = '1 mm'\n");
  expect((await page.textContent("#mistakes")).includes("Line 3"), "a mistake in a case is told at its line");
  expect(await page.isDisabled("section[aria-label='The case'] button.main"), "a case with a mistake is not tested");
  await page.selectOption("section[aria-label='The case'] select", "drained-loose");

  await page.selectOption("section >> nth=0 >> select", "powder/oedometer.json");
  await page.waitForSelector(".slider", { timeout: 120_000 });
  await page.focus(".slider input");
  await page.keyboard.press("ArrowRight");
  await page.waitForTimeout(1500);
  console.log(`a surrogate answers in ${Math.round(Number(await page.getAttribute("[data-milliseconds]", "data-milliseconds")))} ms`);
  await page.fill("input[type=number]", "800");
  await page.screenshot({ path: `${shots}/laboratory-surrogate.png`, fullPage: true });
  await page.focus("section >> nth=0 >> button.main");
  await page.keyboard.press("Enter");
  await page.waitForSelector("#stage[data-pictures]", { timeout: 60_000 });
  const pictures = async () => Number(await page.getAttribute("#stage", "data-pictures"));
  await page.click("#pause");
  await page.waitForTimeout(500);
  const waits = await pictures();
  await page.waitForTimeout(1000);
  expect((await pictures()) === waits, "a test that waits stands still");
  await page.click("#step");
  await page.waitForTimeout(500);
  expect((await pictures()) === waits + 1, "one piece is one picture");
  const saving = page.waitForEvent("download");
  await page.click("#save");
  const saved = JSON.parse(fs.readFileSync(await (await saving).path(), "utf8"));
  expect(saved.format === "granum run 1" && saved.checkpoint.length > 1000, "a run under way can be saved");
  await page.click("#go");
  const begun = Date.now(), first = await pictures();
  await page.waitForTimeout(2000);
  const rate = (1000 * ((await pictures()) - first)) / (Date.now() - begun);
  console.log(`${rate.toFixed(1)} pictures a second while it computes`);
  expect(rate > 5, "the grains move while the test is computed");
  await page.waitForFunction(() => /complete|✓/.test(document.getElementById("states").textContent) || document.querySelector("#states .missed"), null, { timeout: 300_000 });
  await page.waitForSelector("#results button", { timeout: 30_000 });
  expect((await page.textContent("#states")).includes("digest"), "a test comes to its end and has a digest");
  expect((await page.getAttribute("#curves img", "alt")).includes("prediction"), "its curves lie over the prediction");
  const picture = page.waitForEvent("download");
  await page.click("#results button:has-text('Figure')");
  expect(fs.readFileSync(await (await picture).path(), "utf8").includes("<svg "), "its figure can be kept");
  await page.click("#results button:has-text('Compare')");
  expect((await page.textContent("#compared")).includes("seed"), "its run is kept to be compared");
  const download = page.waitForEvent("download");
  await page.click("#results button:has-text('Report')");
  expect((await download).suggestedFilename() === "report.html", "its report can be kept");

  // A second test beside it.
  await page.selectOption("section[aria-label='The case'] select", "drained-loose");
  await page.fill("input[type=number]", "60");
  await page.click("section[aria-label='The case'] button.main");
  await page.waitForFunction(() => !document.querySelector("#results button"), null, { timeout: 30_000 });
  await page.waitForSelector("#results button", { timeout: 300_000 });
  const both = page.waitForEvent("download");
  await page.click("#results button:has-text('Figure')");
  const drawn = fs.readFileSync(await (await both).path(), "utf8");
  expect(drawn.includes("oedometer, seed") && drawn.includes("drained-loose, seed"), "a run is drawn beside the next test");
  await page.click("#compared button");
  expect((await page.textContent("#compared")) === "", "a run that was compared is taken away");

  const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
  for (const scheme of ["light", "dark"]) {
    for (const width of [1280, 390]) {
      await page.emulateMedia({ colorScheme: scheme });
      await page.setViewportSize({ width, height: 900 });
      await page.waitForTimeout(700);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      expect(wide <= width, `no scrolling sideways at ${width} pixels, ${scheme}`);
      await page.evaluate(axe);
      const found = await page.evaluate(() => globalThis.axe.run().then(result => result.violations.map(one => `${one.id}: ${one.nodes[0]?.html.slice(0, 120)}`)));
      expect(found.length === 0, `axe at ${width} pixels, ${scheme} ${found.join("; ")}`);
      await page.screenshot({ path: `${shots}/laboratory-${width}-${scheme}.png`, fullPage: true });
    }
  }
  await browser.close();
  server.close();
}

main().catch(error => problems.push(String(error))).then(() => {
  problems.forEach(problem => console.log(`NOT OK  ${problem}`));
  process.exit(problems.length ? 1 : 0);
});
