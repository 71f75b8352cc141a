// The verdict and the distance of each pair over time.

const COLUMNS = 320;

class Pairs {
  constructor(data) {
    this.data = data;
    this.arrays = data.arrays;
    this.count = this.arrays.bodyA.length;
    this.near = data.near;
    this.classOfSpan = Object.fromEntries(
      Object.entries(data.spanVerdicts).map(([number, name]) => [number, CLASS[name] ?? CLASS.nothing]),
    );
    this.columns = new Map();
  }

  names(pair) {
    const { bodyA, bodyB } = this.arrays;
    return [this.data.bodies[bodyA[pair]], this.data.bodies[bodyB[pair]]];
  }

  name(pair) {
    return this.names(pair).join(" | ");
  }

  verdict(pair) {
    return this.data.verdicts[this.arrays.verdict[pair]];
  }

  // Sets the distance, m, below which clear pairs count as near.
  setNear(near) {
    this.near = near;
    this.columns.clear();
  }

  // Returns the span of a pair at a time, s: {kind, clearance, from, to}.
  spanAt(pair, time) {
    const { spanFrom, spanStart, spanVerdict, spanClearance } = this.arrays;
    const [from, to] = [spanFrom[pair], spanFrom[pair + 1]];
    let span = lastAtMost(spanStart, time, from, to);
    if (span === to - 1 && span > from && time === spanStart[span]) span -= 1; // the last span includes its end
    if (span < from) return { kind: CLASS.nothing, clearance: 0, from: time, to: time };
    return {
      kind: this.classOfSpan[spanVerdict[span]] ?? CLASS.nothing,
      clearance: spanClearance[span],
      from: spanStart[span],
      to: spanStart[Math.min(span + 1, to - 1)],
    };
  }

  // Returns the distances of a pair at instants: measured, or lower bounds.
  points(pair) {
    const { pointFrom, pointTime, pointDistance, pointMeasured } = this.arrays;
    return {
      time: pointTime,
      distance: pointDistance,
      measured: pointMeasured,
      from: pointFrom[pair],
      to: pointFrom[pair + 1],
    };
  }

  // Tells whether the points around a time, s, were both measured.
  isMeasured(pair, time) {
    const { time: times, measured, from, to } = this.points(pair);
    const before = lastAtMost(times, time - this.data.start, from, to);
    return measured[Math.max(before, from)] === 1 && measured[Math.min(before + 1, to - 1)] === 1;
  }

  // Returns the distance of a pair at a time, s, interpolated between points; NaN if unknown.
  distanceAt(pair, time) {
    const { time: times, distance, from, to } = this.points(pair);
    if (to === from) return NaN;
    const since = time - this.data.start;
    const before = lastAtMost(times, since, from, to);
    if (before < from) return distance[from];
    if (before === to - 1) return distance[before];
    const share = (since - times[before]) / (times[before + 1] - times[before]);
    return distance[before] + share * (distance[before + 1] - distance[before]);
  }

  // Returns the class of a pair at a time.
  classAt(pair, time) {
    const { kind } = this.spanAt(pair, time);
    return kind === CLASS.clear && this.distanceAt(pair, time) < this.near ? CLASS.near : kind;
  }

  // Returns the worst class of a pair in each column of the run's time, however short its span.
  classes(pair) {
    let classes = this.columns.get(pair);
    if (!classes) {
      classes = new Uint8Array(COLUMNS);
      this.addSpans(pair, classes);
      this.addNear(pair, classes);
      this.columns.set(pair, classes);
    }
    return classes;
  }

  column(time) {
    const { start, end } = this.data;
    return Math.min(COLUMNS - 1, Math.max(0, Math.floor(((time - start) / (end - start || 1)) * COLUMNS)));
  }

  addSpans(pair, classes) {
    const { spanFrom, spanStart, spanVerdict } = this.arrays;
    const end = spanFrom[pair + 1] - 1;
    for (let span = spanFrom[pair]; span < end; span++) {
      const kind = this.classOfSpan[spanVerdict[span]] ?? CLASS.nothing;
      const last = this.column(spanStart[span + 1]);
      for (let column = this.column(spanStart[span]); column <= last; column++) {
        if (kind > classes[column]) classes[column] = kind;
      }
    }
  }

  addNear(pair, classes) {
    const { time, distance, from, to } = this.points(pair);
    const { start } = this.data;
    for (let point = from; point < to; point++) {
      const next = point + 1 < to ? point + 1 : point;
      if (Math.min(distance[point], distance[next]) >= this.near) continue;
      const [low, high] = this.nearBetween(time, distance, point, next);
      for (let column = this.column(start + low); column <= this.column(start + high); column++) {
        if (classes[column] === CLASS.clear) classes[column] = CLASS.near;
      }
    }
  }

  // Returns the times between which the line through two points is near; one of the points is near.
  nearBetween(time, distance, point, next) {
    const [from, to] = [time[point], time[next]];
    const [first, last] = [distance[point], distance[next]];
    if (first < this.near && last < this.near) return [from, to];
    const crossing = from + ((this.near - first) / (last - first)) * (to - from);
    return first < this.near ? [from, crossing] : [crossing, to];
  }

  // Returns the worst class of some pairs in each column.
  worst(pairs) {
    const worst = new Uint8Array(COLUMNS);
    for (const pair of pairs) {
      const classes = this.classes(pair);
      for (let column = 0; column < COLUMNS; column++) {
        if (classes[column] > worst[column]) worst[column] = classes[column];
      }
    }
    return worst;
  }

  // Returns the minimum distance of a pair as text, with its time in some digits.
  leastText(pair, digits = 6) {
    const { lower, upper, nearest } = this.arrays;
    if (this.verdict(pair) === "contact") return "contact";
    if (Number.isNaN(upper[pair]))
      return lower[pair] > 0 ? `above ${lengthText(lower[pair], Math.floor)}` : "unknown";
    return `${lengthText(upper[pair])} at ${timeText(nearest[pair], digits)}`;
  }

  // Returns the verdict and the distance of a pair at a time as text.
  textAt(pair, time) {
    const { kind, clearance, from, to } = this.spanAt(pair, time);
    if (kind === CLASS.nothing) return "nothing is proved: the log has no span here";
    const span = `${CLASSES[kind]} from ${timeText(from)} to ${timeText(to)}`;
    const proved = clearance > 0 ? `, proved never closer than ${lengthText(clearance, Math.floor)}` : "";
    const distance = this.distanceAt(pair, time);
    const about = this.isMeasured(pair, time) ? "about" : "above about";
    const now = Number.isNaN(distance) ? "" : `; at this instant ${about} ${lengthText(distance)}`;
    return span + proved + now;
  }
}
