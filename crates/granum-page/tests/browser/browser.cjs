// node browser.cjs ADDRESS FOLDER: opens every view of a served folder in Chromium; exit status 1 if anything is wrong.
const { chromium } = require("playwright-core");
const fs = require("fs"), path = require("path");

const [address, folder] = process.argv.slice(2);
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const VIEWS = [
  ["list", "#/", "What is in the folder"],
  ["run", "#/run?path=runs%2Floose", "loose"],
  ["named", "#/run?path=runs%2Fa+name+with+spaces+%26+%3Csigns%3E", "a name with spaces & <signs>"],
  ["compare", "#/compare?path=runs%2Floose&path=runs%2Fother-seed", "2 runs"],
  ["campaign", "#/campaign?path=campaign", "campaign"],
  ["families", "#/families", "Families of tests"],
  ["family", "#/family?family=sand&along=drained-triaxial", "sand, drained-triaxial"],
  ["study", "#/study?path=study", "study"],
  ["surrogate", "#/surrogate?path=study", "stress_ratio-ridge"],
  ["calibration", "#/calibration?path=fit", "fit"],
  ["nothing", "#/run?path=nothing", "This cannot be shown"],
];
const SIZES = [[1280, 900], [390, 844]];
const SCHEMES = ["light", "dark"];
const problems = [];

function problem(text) { problems.push(text); console.log("FAILED:", text); }

/** Numbers as reports write them; a test of the crate asks the same of those. */
async function numbers() {
  const { quantity } = await import(`data:text/javascript;base64,${fs.readFileSync(path.join(__dirname, "../../page/modules/numbers.js")).toString("base64")}`);
  for (const [value, unit, text] of JSON.parse(fs.readFileSync(path.join(__dirname, "numbers.json"), "utf8"))) {
    if (quantity(value, unit) !== text) problem(`${value} ${unit} is written ${quantity(value, unit)}, and should be ${text}`);
  }
}

async function settled(page) {
  await page.waitForFunction(() => !document.querySelector("main[aria-busy]") && ![...document.querySelectorAll(".note")]
    .some(note => /^(Reading|Drawing|Predicting)/.test(note.textContent)), null, { timeout: 60000 });
  await page.waitForFunction(() => [...document.images].every(image => image.complete && image.naturalWidth > 0), null, { timeout: 20000 });
}

async function looked(page, name, size, scheme) {
  const where = `${name} at ${size[0]} ${scheme}`;
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  if (wide > 0) {
    const who = await page.evaluate(() => [...document.querySelectorAll("main *, header *")].filter(e => e.getBoundingClientRect().right > innerWidth + 1 && !e.closest(".scroll, .canvas, pre")).slice(0, 3).map(e => e.outerHTML.slice(0, 120)));
    problem(`${where}: ${wide} px too wide: ${who.join(" | ")}`);
  }
  await page.evaluate(axe);
  const found = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  for (const violation of found.violations) {
    problem(`${where}: ${violation.id}: ${violation.help}: ${violation.nodes.slice(0, 2).map(node => `${node.html.slice(0, 160)} ${(node.any[0] ?? node.all[0])?.message ?? ""}`).join(" | ")}`);
  }
  await page.screenshot({ path: path.join(folder, `${name}-${size[0]}-${scheme}.png`), fullPage: true });
}

// By keyboard alone: the first run is chosen and opened, two are compared, a family is asked.
async function byKeyboard(page) {
  const reach = async (what, test, most = 80) => {
    for (let k = 0; k < most; k++) {
      if (await page.evaluate(test)) return true;
      await page.keyboard.press("Tab");
      const seen = await page.evaluate(() => {
        const focus = document.activeElement, style = getComputedStyle(focus);
        return focus === document.body || style.outlineStyle !== "none" || parseFloat(style.outlineWidth) > 0 ? "" : focus.outerHTML.slice(0, 120);
      });
      if (seen) problem(`keyboard: the focus is not seen on ${seen}`);
    }
    problem(`keyboard: ${what} is not reached by Tab`);
    return false;
  };
  await page.goto(address.replace(/\?.*/, "") + "#/");
  await page.reload();
  await settled(page);
  await page.keyboard.press("Tab");
  if (!await page.evaluate(() => document.activeElement.id === "skip")) problem("keyboard: the first stop does not skip to the content");
  await page.keyboard.press("Enter");
  if (!await page.evaluate(() => document.activeElement.id === "content")) problem("keyboard: the skip does not lead to the content");
  const box = path => `document.activeElement.getAttribute("aria-label") === "Choose ${path} to compare"`;
  for (const run of ["runs/loose", "runs/other-seed"]) {
    await page.evaluate(() => document.getElementById("content").focus());
    if (await reach(`the box of ${run}`, box(run))) await page.keyboard.press("Space");
  }
  await page.evaluate(() => document.getElementById("content").focus());
  if (await reach("the button to compare", `document.activeElement.textContent === "Compare 2 runs"`)) await page.keyboard.press("Enter");
  await page.waitForFunction(() => location.hash.startsWith("#/compare"), null, { timeout: 5000 }).catch(() => problem("keyboard: nothing is compared"));
  await settled(page);
  await page.evaluate(() => { location.hash = "#/campaign?path=campaign"; });
  await settled(page);
  if (await reach("a point of the map", `document.activeElement.className === "point"`)) {
    const first = await page.evaluate(() => document.activeElement.href);
    await page.keyboard.press("ArrowRight");
    if (await page.evaluate(() => document.activeElement.href) === first) problem("keyboard: the arrows do not go from point to point");
    await page.keyboard.press("Enter");
  }
  await page.waitForFunction(() => location.hash.startsWith("#/run"), null, { timeout: 5000 }).catch(() => problem("keyboard: a point of the map does not open its run"));
  await page.evaluate(() => { location.hash = "#/family?family=sand&along=drained-triaxial"; });
  await settled(page);
  if (await reach("the friction of a family", `document.activeElement.name === "--friction"`)) await page.keyboard.type("0.4");
  if (await reach("the pressure of a family", `document.activeElement.name === "--pressure"`)) await page.keyboard.type("100 kPa");
  await page.keyboard.press("Enter");
  await page.waitForSelector("figure img", { timeout: 20000 }).catch(() => problem("keyboard: a family predicts nothing"));
  await settled(page);
}

(async () => {
  await numbers();
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM || "/usr/bin/chromium",
    args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
      "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
  const context = await browser.newContext({ permissions: [], bypassCSP: false });
  const page = await context.newPage();
  const own = new URL(address).origin;
  // axe is put into the page from outside, which the policy of the page allows a debugger.
  page.on("console", message => {
    const expected = /404|422/.test(message.text()) && message.location().url.includes("path=nothing");
    if (["error", "warning"].includes(message.type()) && !expected && !/GPU stall|GL Driver/.test(message.text())) problem(`console: ${message.text()} (${message.location().url})`);
  });
  page.on("pageerror", error => problem(`page: ${error.message}`));
  page.on("request", request => { if (!request.url().startsWith(own) && !/^(blob|data):/.test(request.url())) problem(`asked for ${request.url()}`); });
  await page.goto(address);
  await settled(page);
  if (page.url().includes("token")) problem("the token stays in the address");
  for (const scheme of SCHEMES) {
    for (const size of SIZES) {
      await page.emulateMedia({ colorScheme: scheme, reducedMotion: "reduce" });
      await page.setViewportSize({ width: size[0], height: size[1] });
      for (const [name, hash, title] of VIEWS) {
        await page.evaluate(hash => { location.hash = "#/"; location.hash = hash; }, hash);
        await page.waitForFunction(title => document.querySelector("h1")?.textContent === title, title, { timeout: 30000 })
          .catch(async () => problem(`${name}: its title is ${await page.evaluate(() => document.querySelector("main").textContent.slice(0, 200))}`));
        await settled(page).catch(error => problem(`${name}: ${error.message}`));
        if (name === "run") {
          await page.click("summary:has-text('three dimensions')");
          await page.waitForSelector("#view[data-drawn]", { timeout: 20000 }).catch(() => problem("the grains are not drawn"));
        }
        if (name === "family") {
          await page.fill("input[name='--friction']", "0.4");
          await page.fill("input[name='--pressure']", "100 kPa");
          await page.click("button[type=submit]");
          await page.waitForSelector("figure img", { timeout: 20000 }).catch(() => problem("a family predicts nothing"));
          await settled(page);
        }
        if (name === "surrogate") {
          await page.click("button[type=submit]");
          await page.waitForSelector("main .scroll table", { timeout: 20000 }).catch(() => problem("a surrogate predicts nothing"));
          await settled(page);
        }
        await looked(page, name, size, scheme);
      }
    }
  }
  await page.setViewportSize({ width: 1280, height: 900 });
  await byKeyboard(page);
  await browser.close();
  console.log(problems.length ? `${problems.length} problems` : `${VIEWS.length} views at ${SIZES.length} widths in ${SCHEMES.length} colours: no problem`);
  process.exit(problems.length ? 1 : 0);
})().catch(error => { console.error(error); process.exit(1); });
