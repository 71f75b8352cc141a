// Curves of distance over time: measured points, certified clearances, and the verdicts below.

const WORST = 6;
const RIBBON = 7;
const LINEAR = 1;
const ASINH = 4;

// Returns the columns of a chart, with lengths in the unit of the scene: times; measured distances; certified clearances
// as steps; lower bounds at instants.
function chartData(pairs, pair) {
  const { arrays, data } = pairs;
  const { time, distance, measured, from: first, to: last } = pairs.points(pair);
  const lines = [[], [], [], []]; // times; measured, with gaps at bounds; times of bounds; bounds
  for (let point = first; point < last; point++) {
    lines[0].push(data.start + time[point]);
    lines[1].push(measured[point] ? distance[point] / lengthUnit.metres : null);
    if (measured[point]) continue;
    lines[2].push(data.start + time[point]);
    lines[3].push(distance[point] / lengthUnit.metres);
  }
  const [from, to] = [arrays.spanFrom[pair], arrays.spanFrom[pair + 1]];
  const starts = Array.from(arrays.spanStart.subarray(from, to));
  const clearances = Array.from(arrays.spanClearance.subarray(from, to), (metres) => metres / lengthUnit.metres);
  if (clearances.length > 1) clearances[clearances.length - 1] = clearances[clearances.length - 2];
  return uPlot.join([lines.slice(0, 2), [starts, clearances], lines.slice(2)].map(distinct));
}

// Returns the ticks of an asinh axis that get a label and a line: 0 and powers of ten.
function decades(plot, ticks) {
  if (plot.scales.y.distr !== ASINH) return ticks;
  return ticks.map((tick) =>
    tick === 0 || Math.abs(Math.log10(tick) % 1) < 1e-6 || Math.abs(Math.log10(tick) % 1) > 1 - 1e-6 ? tick : null,
  );
}

// Returns a table with one row per time, the one with the lowest value: uPlot.join needs rising times.
function distinct([times, values]) {
  const kept = [[], []];
  for (let row = 0; row < times.length; row++) {
    const last = kept[0].length - 1;
    if (last >= 0 && times[row] <= kept[0][last])
      kept[1][last] = values[row] === null ? kept[1][last] : Math.min(kept[1][last] ?? Infinity, values[row]);
    else {
      kept[0].push(times[row]);
      kept[1].push(values[row]);
    }
  }
  return kept;
}

class Chart {
  constructor(place, pairs, pair, moment, options) {
    this.pairs = pairs;
    this.pair = pair;
    this.moment = moment;
    this.figure = document.createElement("figure");
    this.figure.className = "chart";
    this.figure.append(this.caption());
    place.append(this.figure);
    this.plot = new uPlot(this.options(options), chartData(pairs, pair), this.figure);
    this.line = document.createElement("div");
    this.line.className = "now-line";
    this.plot.over.append(this.line);
    this.plot.over.addEventListener("click", () => this.jump());
    this.moveLine();
  }

  caption() {
    const caption = document.createElement("figcaption");
    const name = Object.assign(document.createElement("span"), {
      className: "pair",
      textContent: this.pairs.name(this.pair),
    });
    const badge = Object.assign(document.createElement("span"), {
      className: "badge",
      textContent: this.pairs.verdict(this.pair),
    });
    badge.dataset.class = this.pairs.verdict(this.pair);
    const least = Object.assign(document.createElement("span"), {
      className: "hint",
      textContent: this.pairs.leastText(this.pair),
    });
    caption.append(name, badge, least);
    return caption;
  }

  options({ height, spread }) {
    const { start, end, near } = this.pairs.data;
    const axis = { stroke: palette.faint, grid: { stroke: palette.line, width: 1 }, ticks: { stroke: palette.line } };
    const proved = {
      label: "proved",
      stroke: palette.near,
      width: 1,
      fill: this.fill(),
      paths: uPlot.paths.stepped({ align: 1 }),
      spanGaps: true,
      points: { show: false },
    };
    const measured = {
      label: "measured",
      stroke: palette.ink,
      width: 1.5,
      points: { show: true, size: 4, filter: (plot, series, show, gaps) => this.few(plot, series) },
    };
    const bound = {
      label: "at least",
      stroke: palette.near,
      width: 0,
      paths: () => null,
      points: { show: true, size: 4, fill: palette.page, stroke: palette.near },
    };
    return {
      width: this.figure.clientWidth,
      height,
      legend: { show: false },
      cursor: { y: false, drag: { x: true, y: false } },
      scales: {
        x: { time: false, range: (plot, low, high) => (low === null || low === high ? [start, end] : [low, high]) },
        y: {
          distr: spread ? ASINH : LINEAR,
          asinh: Math.max(near / lengthUnit.metres / 10, 1e-9),
          range: (plot, low, high) => [0, Math.max(high, 1e-12) * 1.05],
        },
      },
      axes: [
        { ...axis, values: (plot, ticks) => ticks.map((tick) => `${tick} s`), space: 70 },
        {
          ...axis,
          values: (plot, ticks) => ticks.map((tick) => (tick === null ? "" : numberText(tick))),
          size: 76,
          filter: decades,
          grid: { ...axis.grid, filter: decades },
          ticks: { ...axis.ticks, filter: decades },
        },
      ],
      series: [{}, measured, proved, bound],
      hooks: { draw: [(plot) => this.drawRibbon(plot), (plot) => this.drawLeast(plot)] },
    };
  }

  fill() {
    const [red, green, blue] = palette.near.match(/[\d.]+/g);
    return `rgba(${red}, ${green}, ${blue}, 0.22)`;
  }

  // Returns the points to mark, or none if they are too dense to tell apart.
  few(plot, series) {
    const [low, high] = plot.series[0].idxs;
    const shown = [];
    for (let row = low; row <= high; row++) if (plot.data[series][row] != null) shown.push(row);
    return shown.length * 6 < plot.bbox.width / devicePixelRatio ? shown : [];
  }

  // Paints the verdicts along the foot.
  drawRibbon(plot) {
    const { ctx, bbox } = plot;
    const ratio = window.devicePixelRatio || 1;
    const { spanFrom, spanStart, spanVerdict } = this.pairs.arrays;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (let span = spanFrom[this.pair]; span < spanFrom[this.pair + 1] - 1; span++) {
      const kind = this.pairs.classOfSpan[spanVerdict[span]] ?? CLASS.nothing;
      if (kind <= CLASS.clear) continue;
      const [x, end] = [spanStart[span], spanStart[span + 1]].map((time) => plot.valToPos(time, "x", true));
      paintClass(ctx, kind, x, bbox.top + bbox.height - RIBBON * ratio, Math.max(end - x, ratio), RIBBON * ratio);
    }
    ctx.restore();
  }

  // Marks the least distance measured.
  drawLeast(plot) {
    const { upper, nearest } = this.pairs.arrays;
    if (Number.isNaN(upper[this.pair])) return;
    const x = plot.valToPos(nearest[this.pair], "x", true);
    const y = plot.valToPos(upper[this.pair] / lengthUnit.metres, "y", true);
    if (x < plot.bbox.left || x > plot.bbox.left + plot.bbox.width) return;
    const { ctx } = plot;
    ctx.save();
    ctx.strokeStyle = palette.contact;
    ctx.lineWidth = 2 * (window.devicePixelRatio || 1);
    ctx.beginPath();
    ctx.arc(x, y, 5 * (window.devicePixelRatio || 1), 0, 2 * Math.PI);
    ctx.stroke();
    ctx.restore();
  }

  jump() {
    if (this.plot.cursor.left >= 0) this.moment.set(this.pair, this.plot.posToVal(this.plot.cursor.left, "x"));
  }

  moveLine() {
    const x = this.plot.valToPos(this.moment.time, "x");
    const shown = x >= 0 && x <= this.plot.over.clientWidth;
    this.line.hidden = !shown;
    this.line.style.transform = `translateX(${shown ? x : 0}px)`;
  }

  remove() {
    this.plot.destroy();
    this.figure.remove();
  }
}

// The chart of the selected pair, and those of the worst.
class Charts {
  constructor(pairs, moment) {
    this.pairs = pairs;
    this.moment = moment;
    this.spread = document.getElementById("spread");
    this.spread.addEventListener("change", () => this.draw());
    moment.listen(() => this.follow());
    new ResizeObserver(() => this.fit()).observe(document.getElementById("charts"));
    this.draw();
  }

  draw() {
    for (const chart of this.all ?? []) chart.remove();
    this.all = [];
    this.shown = this.moment.pair;
    this.width = document.getElementById("charts").clientWidth;
    if (!this.pairs.count) return;
    this.add("selected", this.shown, 240);
    const worst = Array.from({ length: this.pairs.count }, (_, pair) => pair).filter((pair) => pair !== this.shown);
    for (const pair of worst.slice(0, WORST)) this.add("charts", pair, 170);
  }

  add(place, pair, height) {
    const options = { height, spread: this.spread.checked };
    this.all.push(new Chart(document.getElementById(place), this.pairs, pair, this.moment, options));
  }

  follow() {
    if (this.moment.pair !== this.shown) this.draw();
    else for (const chart of this.all) chart.moveLine();
  }

  fit() {
    if (document.getElementById("charts").clientWidth !== this.width) this.draw();
  }
}
