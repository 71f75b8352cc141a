// The colours and patterns of classes, worst last, in the theme that is shown.

const CLASSES = ["nothing", "clear", "near", "possible", "unresolved", "breach", "contact"];
const CLASS = Object.fromEntries(CLASSES.map((name, index) => [name, index]));

// How much of a row's height a class takes, so that it is told by more than its colour.
const HEIGHTS = { nothing: 0, clear: 0.25, near: 0.5, possible: 0.7, unresolved: 0.8, breach: 0.9, contact: 1 };
// How far stripes lean to the right, in heights of theirs.
const STRIPES = { possible: 0, unresolved: 1, breach: -1 };
const STRIPE_PIXELS = 5;

const probe = document.createElement("span");
probe.hidden = true;
document.body.append(probe);

// Returns a colour of the style sheet as the browser resolves it now, `rgb(r, g, b)`.
function colourOf(name) {
  probe.style.color = `var(--${name})`;
  return getComputedStyle(probe).color;
}

// The colours of the theme, read anew when it changes.
const palette = {};
function readPalette() {
  for (const name of [...CLASSES.slice(1), "page", "raised", "ink", "faint", "line", "accent", "body"]) {
    palette[name] = colourOf(name);
  }
}

// Paints a class into a row of a canvas.
function paintClass(context, kind, x, top, width, rowHeight) {
  const name = CLASSES[kind];
  const height = Math.round(HEIGHTS[name] * rowHeight);
  if (height === 0) return;
  const y = Math.round(top + (rowHeight - height) / 2);
  context.fillStyle = palette[name];
  context.fillRect(x, y, width, height);
  if (!(name in STRIPES) || width < STRIPE_PIXELS) return;
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  context.strokeStyle = palette.page;
  context.lineWidth = 1.5;
  context.beginPath();
  for (let at = x - (x % STRIPE_PIXELS) - height; at < x + width + height; at += STRIPE_PIXELS) {
    context.moveTo(at, y + height);
    context.lineTo(at + STRIPES[name] * height, y);
  }
  context.stroke();
  context.restore();
}

// Sizes a canvas to CSS pixels and returns its context, in which lengths are CSS pixels.
function contextOf(canvas, width, height) {
  const ratio = Math.max(window.devicePixelRatio || 1, printing ? 2 : 1);
  canvas.width = Math.max(1, Math.round(width * ratio));
  canvas.height = Math.max(1, Math.round(height * ratio));
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.font = "13px system-ui, sans-serif";
  context.textBaseline = "middle";
  return context;
}

function paintLegend() {
  for (const swatch of document.querySelectorAll(".swatch")) {
    const context = contextOf(swatch, 32, 16);
    paintClass(context, CLASS[swatch.dataset.class], 0, 0, 32, 16);
  }
}

// Whether the page is being printed: in light colours, and sharper.
let printing = false;
