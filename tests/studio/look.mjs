// node look.mjs VISITS.json
//
// Opens logs in Studio, looks at them as a person would, and says on standard output what there was to see.
//
// VISITS.json: {"browser": path, "folder": for pictures, "visits": [visit, ...]}, a visit being
//   {"name", "address", "seeks": [share of the run, ...], "pictures": whether of the whole page, else charts and problems}
// The answer: {NAME: {"looks": [look, ...], "problems": text, "painted": [text in a chart, ...],
//                     "opening": [line of the console until all had loaded, ...], "console": [line since, ...]}}
// A look is what is shown when the log has just opened, and after each seek:
//   {"time", "panels": {ID: {"text", "height", "canvas": height or null}}, "scene": {"file", "width", "height"}},
// `file` with the picture of the 3D panel as rows of RGBA, and beside it that of the page as PNG, where pictures are asked for.
//
// CLOSECALL_STUDIO_DIR names the folder that has the packages.
import { readFile, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";

const puppeteer = createRequire(join(process.env.CLOSECALL_STUDIO_DIR, "package.json"))("puppeteer-core");

const PANEL = "panel-mouseenter-container ";
const FLAGS = [
  "--no-sandbox",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--ignore-gpu-blocklist",
  "--disable-background-networking",
  "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
];
const VIEW = { width: 1600, height: 1000 };
const POLL_MS = 250;
const QUIET_POLLS = 2;
const PATIENCE_MS = 60_000;

const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

// Waits until picture and text stay the same for some polls: Studio has loaded and drawn what it will.
async function settle(page) {
  const until = Date.now() + PATIENCE_MS;
  for (let last = "", same = 0; same < QUIET_POLLS; ) {
    const picture = await page.screenshot({ encoding: "base64", type: "jpeg", quality: 50 }); // twice as fast as PNG
    const now = (await page.evaluate(() => document.body.innerText)) + picture;
    same = now === last ? same + 1 : 0;
    last = now;
    if (Date.now() > until) {
      throw new Error(`the page of ${page.url()} did not come to rest`);
    }
    await pause(POLL_MS);
  }
}

// Returns a picture's pixels as RGBA; the browser decodes its own PNG.
async function decoded(page, png) {
  const pixels = await page.evaluate(async (encoded) => {
    const bytes = Uint8Array.from(atob(encoded), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let text = "";
    for (let at = 0; at < data.length; at += 0x8000) {
      text += String.fromCharCode(...data.subarray(at, at + 0x8000));
    }
    return { width: image.width, height: image.height, data: btoa(text) };
  }, png);
  return { ...pixels, data: Buffer.from(pixels.data, "base64") };
}

async function look(page, path, picture) {
  await settle(page);
  const seen = await page.evaluate(
    (prefix) => ({
      time: document.querySelector('[data-testid="PlaybackTime-text"] input')?.value,
      panels: Object.fromEntries(
        Array.from(document.querySelectorAll(`[data-testid^="${prefix}"]`), (panel) => [
          panel.dataset.testid.slice(prefix.length),
          {
            text: panel.innerText,
            height: panel.getBoundingClientRect().height,
            canvas: panel.querySelector("canvas")?.getBoundingClientRect().height ?? null,
          },
        ]),
      ),
    }),
    PANEL,
  );
  if (picture) {
    await page.screenshot({ path: `${path}.png` });
  }
  const canvas = await page.$(`[data-testid^="${PANEL}3D!"] canvas`);
  if (canvas) {
    const { width, height, data } = await decoded(page, await canvas.screenshot({ encoding: "base64" }));
    await writeFile(`${path}.rgba`, data);
    seen.scene = { file: `${path}.rgba`, width, height };
  }
  return seen;
}

// Closes the hint that Studio lays over its panels when it is used for the first time.
async function dismissHint(page) {
  await page.evaluate(() => {
    document.querySelectorAll('[role="tooltip"] button').forEach((button) => button.click());
  });
}

// Clicks the playback slider, then moves the mouse away from it, whose tooltip would hide a part of the page.
async function seek(page, share) {
  const slider = await (await page.waitForSelector('[class*="Slider-root"]')).boundingBox();
  await page.mouse.click(slider.x + share * slider.width, slider.y + slider.height / 2);
  await page.mouse.move(0, 0);
}

// Keeps, inside a worker, every text that it paints from now on: Studio's charts paint theirs on canvases.
function keepPainted() {
  const paint = OffscreenCanvasRenderingContext2D.prototype.fillText;
  self.painted = new Set();
  OffscreenCanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
    self.painted.add(text);
    return paint.call(this, text, ...rest);
  };
}

// Returns every text in the charts.
async function painted(page) {
  const texts = await Promise.all(page.workers().map((worker) => worker.evaluate(() => Array.from(self.painted ?? []))));
  return texts.flat();
}

// Returns the sidebar with its list of problems.
async function problems(page) {
  await page.evaluate(() => {
    Array.from(document.querySelectorAll('[role="tab"]')).find((tab) => tab.innerText.startsWith("Problems"))?.click();
  });
  await settle(page);
  return page.evaluate(() => document.querySelector(".mosaic-tile")?.innerText ?? "");
}

async function visit(browser, folder, { name, address, seeks, pictures }) {
  const page = await browser.newPage();
  await page.setViewport(VIEW);
  const lines = [];
  page.on("workercreated", (worker) => worker.evaluate(keepPainted).catch((fault) => lines.push(`error: ${fault}`)));
  page.on("console", (line) => lines.push(`${line.type()}: ${line.text()}`));
  page.on("pageerror", (error) => lines.push(`exception: ${error.message}`));
  page.on("response", (answer) => answer.status() >= 400 && lines.push(`error: ${answer.status()} ${answer.url()}`));
  await page.goto(address);
  await page.waitForSelector(`[data-testid^="${PANEL}"]`, { timeout: PATIENCE_MS });
  await page.waitForFunction(() => document.body.innerText.includes("END TIME"), { timeout: PATIENCE_MS });
  await settle(page);
  const opening = lines.splice(0);
  await dismissHint(page);
  const looks = [await look(page, join(folder, `${name}_0`), pictures)];
  await page.setViewport({ ...VIEW, width: VIEW.width - 20 }); // has the charts painted anew, under the eyes of their workers
  for (const share of seeks) {
    await seek(page, share);
    looks.push(await look(page, join(folder, `${name}_${looks.length}`), pictures));
  }
  const asked = pictures ? [[], ""] : [await painted(page), await problems(page)];
  const seen = { looks, painted: asked[0], problems: asked[1], opening, console: lines };
  await page.close();
  return seen;
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
