// node book.cjs BUILT-BOOK FOLDER: opens the page of packings of the built book from disk in Chromium, and chooses each packing; exit status 1 if
// anything is wrong.
const { chromium } = require("playwright-core");
const path = require("path"), { pathToFileURL } = require("url");

const [book, folder] = process.argv.slice(2);
const problems = [];
function problem(text) { problems.push(text); console.log("FAILED:", text); }

// The share of the picture that is neither paper nor grey: grains have colours.
const coloured = canvas => {
  const copy = document.createElement("canvas");
  copy.width = canvas.width; copy.height = canvas.height;
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  let count = 0;
  for (let k = 0; k < data.length; k += 4) {
    if (Math.max(data[k], data[k + 1], data[k + 2]) - Math.min(data[k], data[k + 1], data[k + 2]) > 40) count++;
  }
  return 4 * count / data.length;
};

(async () => {
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM,
    args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader", "--allow-file-access-from-files"],
  });
  const page = await browser.newPage({ viewport: { width: 1280, height: 1000 } });
  page.on("console", message => { if (message.type() === "error") problem(`console: ${message.text()}`); });
  page.on("pageerror", error => problem(`error: ${error}`));
  page.on("request", request => { if (!/^(file|data|blob|about):/.test(request.url())) problem(`asks for ${request.url()}`); });
  await page.goto(pathToFileURL(path.resolve(book, "packings.html")).href);
  const links = page.locator('a[target="packing"]');
  const count = await links.count();
  if (count < 5) problem(`the page has ${count} packings`);
  for (let k = 0; k < count; k++) {
    const href = await links.nth(k).getAttribute("href");
    const name = path.basename(href, ".html").replace("packing-", "");
    await links.nth(k).focus();
    await page.keyboard.press("Enter");
    await page.locator('iframe[name="packing"]').scrollIntoViewIfNeeded();
    for (let n = 0; n < 100 && !page.frames().some(frame => frame.url().endsWith(href)); n++) await page.waitForTimeout(100);
    const frame = page.frames().find(frame => frame.url().endsWith(href));
    if (!frame) { problem(`${name} is not shown`); continue; }
    await frame.waitForFunction(() => Number(document.getElementById("view")?.dataset.drawn) > 0, null, { timeout: 60000 })
      .catch(() => problem(`${name} is not drawn`));
    const title = await frame.title();
    if (title !== name) problem(`${name} has the title ${title}`);
    const share = await frame.locator("#view").evaluate(coloured);
    if (!(share > 0.05)) problem(`${name}: ${(100 * share).toFixed(1)} % of the picture have a colour`);
    console.log(`${name}: ${(100 * share).toFixed(0)} % of the picture are grains`);
    await page.locator('iframe[name="packing"]').screenshot({ path: path.join(folder, `packing-${name}.png`) });
  }
  await page.evaluate(() => scrollTo(0, 0));
  await page.screenshot({ path: path.join(folder, "packings.png"), fullPage: true });
  await browser.close();
  process.exit(problems.length ? 1 : 0);
})();
