// node page.mjs VISITS.json
//
// Opens report pages from their files, uses them as a person would, and says on standard output what there was to see.
//
// VISITS.json: {"browser": path, "folder": for pictures, "visits": [visit, ...]}, a visit being
//   {"name", "page": path, "width", "height", "theme", "steps": [step, ...], "picture": whether of all of it, "print"}
// A step is ["click", selector], ["slide", share of the run], ["type", selector, text], ["press", selector, key],
// ["point", selector, share of the width, share of the height], or ["evaluate", expression].
// The answer: {NAME: {"drawn": ms until all was drawn, "looks": [look, ...], "lines": [line of the console, ...],
//                     "requests": [address, ...], "printed": bytes of the PDF, "title", "overflow": pixels}}
// A look is what is shown at first, and after each step:
//   {"time", "slider", "selected": text of the chart's caption, "now": [row, ...], "told", "value": of the expression,
//    "canvases": {ID: {"file": of rows of RGBA, "width", "height"}}}
//
// CLOSECALL_STUDIO_DIR names the folder that has the packages.
import { readFile, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const puppeteer = createRequire(join(process.env.CLOSECALL_STUDIO_DIR, "package.json"))("puppeteer-core");

const FLAGS = [
  "--no-sandbox",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--ignore-gpu-blocklist",
  "--disable-background-networking",
  "--host-resolver-rules=MAP * ~NOTFOUND",
];
const PATIENCE_MS = 60_000;
const CANVASES = ["scene-canvas", "rows-canvas", "any"];

// Runs what is asked for, then waits until it is painted: scripts paint in the next frame.
async function take(page, [what, selector, ...rest]) {
  const element = what === "slide" || what === "evaluate" ? null : await page.waitForSelector(selector);
  switch (what) {
    case "click":
      await element.click();
      break;
    case "point": {
      await element.scrollIntoView();
      const box = await element.boundingBox();
      await page.mouse.click(box.x + rest[0] * box.width, box.y + rest[1] * box.height);
      break;
    }
    case "type":
      await element.type(rest[0]);
      break;
    case "press":
      await element.press(rest[0]);
      break;
    case "slide":
      await page.evaluate((share) => {
        const slider = document.getElementById("slider");
        slider.value = Number(slider.min) + share * (slider.max - slider.min);
        slider.dispatchEvent(new Event("input"));
      }, selector);
      break;
  }
  const value = what === "evaluate" ? await page.evaluate(selector) : null;
  await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
  return value;
}

// Returns a canvas's pixels, as base64 of RGBA.
function pixels(id) {
  const canvas = document.getElementById(id);
  if (!canvas || canvas.offsetWidth === 0) return null;
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  let text = "";
  for (let at = 0; at < data.length; at += 0x8000) text += String.fromCharCode(...data.subarray(at, at + 0x8000));
  return { width: canvas.width, height: canvas.height, data: btoa(text) };
}

async function look(page, path, value) {
  const seen = await page.evaluate(() => ({
    time: document.getElementById("time").textContent,
    slider: Number(document.getElementById("slider").value),
    selected: document.querySelector("#selected figcaption")?.innerText ?? "",
    now: Array.from(document.querySelectorAll("#now li"), (row) => row.innerText),
    told: document.getElementById("map-told").textContent,
  }));
  seen.value = value;
  seen.canvases = {};
  for (const id of CANVASES) {
    const found = await page.evaluate(pixels, id);
    if (!found) continue;
    await writeFile(`${path}_${id}.rgba`, Buffer.from(found.data, "base64"));
    seen.canvases[id] = { file: `${path}_${id}.rgba`, width: found.width, height: found.height };
  }
  return seen;
}

async function visit(browser, folder, { name, page: file, width, height, theme, steps, picture, print }) {
  const page = await browser.newPage();
  const address = pathToFileURL(file).href;
  const lines = [];
  const requests = [];
  page.on("console", (line) => lines.push(`${line.type()}: ${line.text()}`));
  page.on("pageerror", (error) => lines.push(`exception: ${error.message}`));
  page.on("request", (request) => requests.push(request.url()));
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: theme }]);
  await page.setViewport({ width, height });
  const began = performance.now();
  await page.goto(address);
  await page.waitForSelector("[data-drawn]", { timeout: PATIENCE_MS });
  await take(page, ["evaluate", "0"]);
  const drawn = performance.now() - began;
  const looks = [await look(page, join(folder, `${name}_0`), null)];
  for (const step of steps) {
    const value = await take(page, step);
    looks.push(await look(page, join(folder, `${name}_${looks.length}`), value));
  }
  if (picture) await page.screenshot({ path: join(folder, `${name}.png`), fullPage: true });
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  const title = await page.title();
  const printed = print
    ? (await page.pdf({ path: join(folder, `${name}.pdf`), format: "A4", printBackground: true })).length
    : 0;
  await page.close();
  return { drawn, looks, lines, requests: requests.filter((one) => one !== address), printed, title, overflow };
}

const { browser: executablePath, folder, visits } = JSON.parse(await readFile(process.argv[2], "utf8"));
const browser = await puppeteer.launch({ executablePath, headless: true, args: FLAGS });
try {
  const seen = {};
  for (const one of visits) {
    seen[one.name] = await visit(browser, folder, one);
  }
  process.stdout.write(JSON.stringify(seen));
} finally {
  await browser.close();
}
