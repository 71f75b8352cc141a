// The page: the pair and the time that it shows.

const SPEEDS = [0.01, 0.1, 0.25, 0.5, 1, 2, 5, 10, 100];

// The pair and the time that all parts of the page show.
class Moment {
  constructor(pairs) {
    this.pairs = pairs;
    [this.pair, this.time] = pairs.data.opens;
    this.listeners = [];
    this.focusers = [];
  }

  listen(listener) {
    this.listeners.push(listener);
  }

  onFocus(focuser) {
    this.focusers.push(focuser);
  }

  tell() {
    for (const listener of this.listeners) listener();
  }

  setTime(time) {
    const { start, end } = this.pairs.data;
    this.time = Math.min(end, Math.max(start, time));
    this.tell();
  }

  // Shows a pair at a time, s; at the time that is shown, if it is not a number.
  set(pair, time) {
    this.pair = pair;
    if (!Number.isNaN(time)) this.setTime(time);
    else this.tell();
  }

  // Shows a pair at a time, and looks at it.
  jump(pair, time) {
    this.set(pair, time);
    for (const focuser of this.focusers) focuser(pair, time);
  }
}

// The slider, the buttons, and the clock that runs.
class Player {
  constructor(moment) {
    this.moment = moment;
    this.slider = document.getElementById("slider");
    this.play = document.getElementById("play");
    this.speed = document.getElementById("speed");
    const { start, end } = moment.pairs.data;
    [this.slider.min, this.slider.max] = [start, end];
    const usual = SPEEDS.find((speed) => (end - start) / speed <= 15) ?? SPEEDS.at(-1);
    for (const speed of SPEEDS) this.speed.add(new Option(`${speed}×`, speed, speed === usual, speed === usual));
    this.slider.addEventListener("input", () => moment.setTime(Number(this.slider.value)));
    this.play.addEventListener("click", () => this.toggle());
    document.getElementById("before").addEventListener("click", () => this.contact(-1));
    document.getElementById("after").addEventListener("click", () => this.contact(1));
    moment.listen(() => this.show());
    this.show();
  }

  show() {
    this.slider.value = this.moment.time;
    document.getElementById("time").textContent = timeText(this.moment.time);
  }

  toggle() {
    const playing = this.play.getAttribute("aria-pressed") !== "true";
    this.play.setAttribute("aria-pressed", String(playing));
    this.play.textContent = playing ? "Pause" : "Play";
    if (!playing) return;
    if (this.moment.time >= this.moment.pairs.data.end) this.moment.setTime(this.moment.pairs.data.start);
    this.last = performance.now();
    requestAnimationFrame((now) => this.tick(now));
  }

  tick(now) {
    if (this.play.getAttribute("aria-pressed") !== "true") return;
    const step = (Math.max(0, now - this.last) / 1000) * Number(this.speed.value);
    this.last = now;
    this.moment.setTime(this.moment.time + step);
    if (this.moment.time >= this.moment.pairs.data.end) this.toggle();
    else requestAnimationFrame((next) => this.tick(next));
  }

  // Goes to the begin of the next contact in a direction.
  contact(direction) {
    const { touchPair, touchTime } = this.moment.pairs.arrays;
    let best = -1;
    for (let touch = 0; touch < touchTime.length; touch++) {
      const ahead = direction * (touchTime[touch] - this.moment.time);
      if (ahead > 0 && (best < 0 || ahead < direction * (touchTime[best] - this.moment.time))) best = touch;
    }
    if (best >= 0) this.moment.jump(touchPair[best], touchTime[best]);
  }
}

// Shows the wakeups of the selected pair by reason.
function showReasons(pairs, pair) {
  const { reasons } = pairs.arrays;
  const kinds = pairs.data.reasons.length;
  for (const cell of document.querySelectorAll("[data-reason]")) {
    cell.textContent = reasons[pair * kinds + pairs.data.reasons.indexOf(cell.dataset.reason)] ?? 0;
  }
}

function startReplay(pairs, moment) {
  if (!pairs.data.replay) {
    for (const id of ["scene", "whole"]) document.getElementById(id).hidden = true;
    return null;
  }
  const { coarser } = pairs.data.replay;
  if (coarser)
    document.getElementById("coarser").textContent =
      ` ${coarser} surfaces are drawn coarser than in the log.`;
  try {
    return new Replay(pairs, moment);
  } catch (fault) {
    const told = Object.assign(document.createElement("p"), {
      className: "note",
      textContent: `3D drawing is not available: ${fault.message}`,
    });
    document.getElementById("scene").replaceWith(told);
    return null;
  }
}

// Draws all parts anew when the theme changes, by hand, by the system, or for print.
function followTheme(redraw) {
  const root = document.documentElement;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  document.getElementById("theme").addEventListener("click", () => {
    const shown = root.dataset.theme ?? (dark.matches ? "dark" : "light");
    root.dataset.theme = shown === "dark" ? "light" : "dark";
    redraw();
  });
  dark.addEventListener("change", redraw);
  let before;
  window.addEventListener("beforeprint", () => {
    before = root.dataset.theme;
    root.dataset.theme = "light";
    root.dataset.printing = "yes";
    printing = true;
    redraw();
  });
  window.addEventListener("afterprint", () => {
    if (before) root.dataset.theme = before;
    else delete root.dataset.theme;
    delete root.dataset.printing;
    printing = false;
    redraw();
  });
}

readPalette();
paintLegend();
const data = await readData(document.getElementById("data").textContent);
Object.assign(lengthUnit, data.unit);
const pairs = new Pairs(data);
const moment = new Moment(pairs);
const map = new PairMap(pairs, moment);
new Player(moment);
const charts = new Charts(pairs, moment);
const replay = startReplay(pairs, moment);
moment.listen(() => showReasons(pairs, moment.pair));
document.getElementById("whole").addEventListener("click", () => replay?.whole());
document.addEventListener("click", (event) => {
  const button = event.target.closest(".jump");
  if (!button) return;
  moment.jump(Number(button.dataset.pair), Number(button.dataset.time));
  map.show(moment.pair);
  document.getElementById("replay").scrollIntoView({ block: "nearest" });
});
followTheme(() => {
  readPalette();
  paintLegend();
  map.layOut();
  charts.draw();
  replay?.fit();
});
moment.tell();
map.show(moment.pair);
document.documentElement.dataset.drawn = "yes";
