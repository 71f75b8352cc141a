// The map: one row per pair, worst first. Only the visible rows are painted.

const ROW = 22;
const ROWS_IN_PRINT = 25;
const NARROW = 640;
const TIME_DIGITS = 4;

class PairMap {
  constructor(pairs, moment) {
    this.pairs = pairs;
    this.moment = moment;
    this.rows = document.getElementById("rows");
    this.canvas = document.getElementById("rows-canvas");
    this.filter = document.getElementById("filter");
    this.told = document.getElementById("map-told");
    this.listen();
    this.choose();
  }

  listen() {
    this.filter.addEventListener("input", () => this.choose());
    this.rows.addEventListener("scroll", () => this.schedule());
    this.rows.addEventListener("mousemove", (event) => this.tell(this.at(event)));
    this.rows.addEventListener("click", (event) => this.take(this.at(event)));
    this.rows.addEventListener("keydown", (event) => this.key(event));
    document
      .getElementById("any")
      .addEventListener("click", (event) => this.moment.setTime(this.timeAt(event.offsetX + this.left)));
    new ResizeObserver(() => this.layOut()).observe(document.getElementById("map"));
    this.moment.listen(() => this.schedule());
    this.setUpNear();
  }

  // Sets up the field for the distance below which clear pairs are near, in the unit of the scene.
  setUpNear() {
    const field = document.getElementById("near");
    document.getElementById("near-unit").textContent = lengthUnit.name;
    field.value = Number((this.pairs.near / lengthUnit.metres).toPrecision(DIGITS));
    field.addEventListener("change", () => {
      this.pairs.setNear(Math.max(0, Number(field.value)) * lengthUnit.metres);
      this.choose();
      this.moment.tell();
    });
  }

  // Selects the pairs whose names contain all words of the filter.
  choose() {
    const words = this.filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    this.chosen = [];
    for (let pair = 0; pair < this.pairs.count; pair++) {
      const name = this.pairs.name(pair).toLowerCase();
      if (words.every((word) => name.includes(word))) this.chosen.push(pair);
    }
    this.worst = this.pairs.worst(this.chosen);
    this.longest = this.longestName();
    this.rows.scrollTop = 0;
    this.layOut();
  }

  // Returns the approximate width of the longest name.
  longestName() {
    const longest = this.chosen.reduce(
      (most, pair) => (this.pairs.name(pair).length > most.length ? this.pairs.name(pair) : most),
      "",
    );
    return contextOf(this.canvas, 1, 1).measureText(longest).width;
  }

  printed() {
    return Math.min(this.chosen.length, ROWS_IN_PRINT) * ROW;
  }

  layOut() {
    const height = printing ? this.printed() : Math.max(1, this.chosen.length) * ROW;
    document.getElementById("rows-height").style.height = `${height}px`;
    const width = this.rows.clientWidth;
    const narrow = width < NARROW;
    this.width = width;
    this.left = Math.min(Math.max(this.longest, 80) + 24, Math.round(width * (narrow ? 0.5 : 0.36)));
    this.right = narrow ? 0 : 150;
    const inner = width - this.left - this.right;
    this.cellsWidth = inner;
    const any = document.getElementById("any");
    any.previousElementSibling.style.width = `${this.left}px`;
    const context = contextOf(any, inner, 28);
    this.paintClasses(context, this.worst, 0, 2, 24);
    this.paintAxis();
    this.paint();
  }

  schedule() {
    this.frame ??= requestAnimationFrame(() => {
      this.frame = undefined;
      this.paint();
    });
  }

  paint() {
    const height = printing ? this.printed() : Math.max(ROW, this.rows.clientHeight);
    const context = contextOf(this.canvas, this.width, height);
    context.fillStyle = palette.page;
    context.fillRect(0, 0, this.width, height);
    const top = printing ? 0 : this.rows.scrollTop;
    const first = Math.floor(top / ROW);
    for (let row = first; row < this.chosen.length && row * ROW - top < height; row++) {
      this.paintRow(context, this.chosen[row], row * ROW - top);
    }
    const x = this.x(this.moment.time);
    context.fillStyle = palette.accent;
    context.fillRect(x - 1, 0, 2, height);
  }

  paintRow(context, pair, top) {
    if (pair === this.moment.pair) {
      context.fillStyle = palette.raised;
      context.fillRect(0, top, this.width, ROW);
      context.fillStyle = palette.accent;
      context.fillRect(0, top, 3, ROW);
    }
    context.save();
    context.beginPath();
    context.rect(0, top, this.left - 8, ROW);
    context.clip();
    context.fillStyle = palette.ink;
    context.fillText(this.pairs.name(pair), 8, top + ROW / 2);
    context.restore();
    this.paintClasses(context, this.pairs.classes(pair), this.left, top + 2, ROW - 4);
    context.fillStyle = palette.faint;
    if (this.right)
      context.fillText(this.pairs.leastText(pair, TIME_DIGITS), this.width - this.right + 8, top + ROW / 2);
  }

  paintClasses(context, classes, left, top, height) {
    for (let from = 0; from < COLUMNS;) {
      let to = from + 1;
      while (to < COLUMNS && classes[to] === classes[from]) to++;
      const [x, end] = [from, to].map((column) => left + (column / COLUMNS) * this.cellsWidth);
      paintClass(context, classes[from], x, top, Math.max(end - x, 1), height);
      from = to;
    }
  }

  paintAxis() {
    const { start, end } = this.pairs.data;
    const context = contextOf(document.getElementById("axis"), this.width, 22);
    context.fillStyle = palette.faint;
    const ticks = Math.max(2, Math.floor(this.cellsWidth / 130));
    for (let tick = 0; tick <= ticks; tick++) {
      const time = start + (tick / ticks) * (end - start);
      context.textAlign = tick === 0 ? "left" : tick === ticks ? "right" : "center";
      context.fillText(timeText(Number(time.toPrecision(4))), this.x(time), 12);
    }
  }

  x(time) {
    const { start, end } = this.pairs.data;
    return this.left + ((time - start) / (end - start || 1)) * this.cellsWidth;
  }

  timeAt(x) {
    const { start, end } = this.pairs.data;
    const share = Math.min(1, Math.max(0, (x - this.left) / this.cellsWidth));
    return start + share * (end - start);
  }

  // Returns the pair and the time at the mouse; the time is null beside the cells.
  at(event) {
    const box = this.rows.getBoundingClientRect();
    const x = event.clientX - box.left - this.rows.clientLeft;
    const row = Math.floor((event.clientY - box.top - this.rows.clientTop + this.rows.scrollTop) / ROW);
    const inside = x >= this.left && x <= this.left + this.cellsWidth;
    return { pair: this.chosen[row], time: inside ? this.timeAt(x) : null };
  }

  tell({ pair, time }) {
    if (pair === undefined) return;
    const when = time === null ? this.pairs.leastText(pair) : `at ${timeText(time)}: ${this.pairs.textAt(pair, time)}`;
    this.told.textContent = `${this.pairs.name(pair)}, ${when}`;
  }

  take({ pair, time }) {
    if (pair === undefined) return;
    this.moment.set(pair, time ?? this.pairs.arrays.nearest[pair]);
  }

  key(event) {
    const steps = { ArrowUp: -1, ArrowDown: 1 };
    const moves = { ArrowLeft: -1, ArrowRight: 1 };
    const { start, end } = this.pairs.data;
    if (event.key in steps) {
      const row = this.chosen.indexOf(this.moment.pair) + steps[event.key];
      const pair = this.chosen[Math.min(this.chosen.length - 1, Math.max(0, row))];
      if (pair === undefined) return;
      this.moment.set(pair, NaN);
      this.show(pair);
    } else if (event.key in moves) {
      this.moment.setTime(this.moment.time + (moves[event.key] * (end - start)) / COLUMNS);
    } else if (event.key === "Enter") {
      this.take({ pair: this.moment.pair, time: null });
    } else {
      return;
    }
    event.preventDefault();
    this.tell({ pair: this.moment.pair, time: this.moment.time });
  }

  // Scrolls a pair into view.
  show(pair) {
    const top = this.chosen.indexOf(pair) * ROW;
    if (top < 0) return;
    const { scrollTop, clientHeight } = this.rows;
    if (top < scrollTop || top + ROW > scrollTop + clientHeight) this.rows.scrollTop = top - clientHeight / 2;
  }
}
