// The replay: the bodies at one time, coloured by their worst pair, with lines between closest points.

const EYE = [1.1, -1.6, 0.9];
const FIELD_OF_VIEW = 40;
const LISTED = 6;
const WHOLE = 1;
const CLOSE_UP = 3.5;
const LINE_PIXELS = 2;
const MARK_PIXELS = 14;
const DOT_PIXELS = 7;

class Replay {
  constructor(pairs, moment) {
    this.pairs = pairs;
    this.moment = moment;
    this.canvas = document.getElementById("scene-canvas");
    this.label = document.getElementById("scene-label");
    this.bodies = new Bodies(pairs.data);
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, preserveDrawingBuffer: true });
    this.scene = new Scene();
    this.scene.add(this.bodies.group, new HemisphereLight(0xffffff, 0x8890a0, 2.2));
    this.sun = new DirectionalLight(0xffffff, 1.6);
    this.scene.add(this.sun);
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.schedule());
    this.addLines();
    this.addMarks();
    this.dots = new Points(
      new BufferGeometry(),
      new PointsMaterial({ size: DOT_PIXELS, sizeAttenuation: false, vertexColors: true }),
    );
    this.dots.frustumCulled = false;
    this.scene.add(this.dots);
    this.whole();
    this.canvas.addEventListener("mousemove", (event) => this.name(event));
    this.canvas.addEventListener("mouseleave", () => (this.label.hidden = true));
    new ResizeObserver(() => this.fit()).observe(this.canvas.parentElement);
    moment.listen(() => this.schedule());
    moment.onFocus((pair, time) => this.focus(pair, time));
    this.fit();
  }

  addLines() {
    this.lines = new LineSegments2(
      new LineSegmentsGeometry(),
      new LineMaterial({ linewidth: LINE_PIXELS, depthTest: false, vertexColors: true, transparent: true }),
    );
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 1;
    this.scene.add(this.lines);
  }

  addMarks() {
    this.marks = new Points(
      new BufferGeometry(),
      new PointsMaterial({
        size: MARK_PIXELS,
        sizeAttenuation: false,
        depthTest: false,
        transparent: true,
        alphaTest: 0.3,
        map: ring(),
      }),
    );
    this.marks.frustumCulled = false;
    this.marks.renderOrder = 2;
    this.scene.add(this.marks);
  }

  // Looks at the whole scene.
  whole() {
    const { middle, radius } = this.bodies.bounds;
    this.size = radius;
    this.look(middle, WHOLE * radius, new Vector3(...EYE));
  }

  // Looks at a place (m), from a direction, so that all within a radius (m) is seen.
  look(place, radius, direction) {
    const distance = radius / Math.sin((FIELD_OF_VIEW * Math.PI) / 360);
    this.controls.target.copy(place);
    this.camera.position.copy(place).addScaledVector(direction.normalize(), distance);
    this.camera.near = Math.min(distance, this.size) / 500;
    this.camera.far = distance + 20 * this.size;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.schedule();
  }

  // Looks at where a pair touches or is nearest.
  focus(pair, time) {
    const place = this.placeOf(pair, time);
    if (!place) return;
    const radii = this.pairs.names(pair).map((name) => this.bodies.byName.get(name)?.radius ?? 0);
    const least = Math.min(...radii.filter((radius) => radius > 0));
    if (!Number.isFinite(least)) return;
    const distance = this.pairs.distanceAt(pair, time) || 0;
    const direction = this.camera.position.clone().sub(this.controls.target);
    this.look(place, Math.min(CLOSE_UP * least + distance, this.size), direction);
  }

  placeOf(pair, time) {
    const { touchPair, touchTime, touchPoint, witnesses } = this.pairs.arrays;
    for (let touch = 0; touch < touchPair.length; touch++) {
      if (touchPair[touch] === pair && touchTime[touch] === time) return new Vector3().fromArray(touchPoint, 3 * touch);
    }
    const [a, b] = [0, 1].map((end) => new Vector3().fromArray(witnesses, 6 * pair + 3 * end));
    return Number.isNaN(a.x) ? null : a.add(b).multiplyScalar(0.5);
  }

  schedule() {
    this.frame ??= requestAnimationFrame(() => {
      this.frame = undefined;
      this.draw();
    });
  }

  draw() {
    const { time } = this.moment;
    this.bodies.place(time);
    this.judge(time);
    this.setLines(time);
    this.setMarks(time);
    this.setDots();
    this.sun.position.copy(this.camera.position).sub(this.controls.target);
    this.scene.background = new Color().setStyle(palette.raised);
    this.renderer.render(this.scene, this.camera);
  }

  // Colours each body by its worst pair, and lists the nearest pairs.
  judge(time) {
    const worst = new Uint8Array(this.pairs.data.bodies.length);
    const { bodyA, bodyB } = this.pairs.arrays;
    const near = [];
    for (let pair = 0; pair < this.pairs.count; pair++) {
      const kind = this.pairs.classAt(pair, time);
      worst[bodyA[pair]] = Math.max(worst[bodyA[pair]], kind);
      worst[bodyB[pair]] = Math.max(worst[bodyB[pair]], kind);
      if (kind !== CLASS.nothing)
        near.push({ pair, kind, distance: kind === CLASS.contact ? 0 : this.pairs.distanceAt(pair, time) });
    }
    this.kinds = new Map(this.pairs.data.bodies.map((name, body) => [name, worst[body]]));
    this.bodies.paint((name) =>
      (this.kinds.get(name) ?? 0) > CLASS.clear ? palette[CLASSES[this.kinds.get(name)]] : palette.body,
    );
    near.sort((a, b) => b.kind - a.kind || (a.distance || 0) - (b.distance || 0) || a.pair - b.pair);
    this.list(near.slice(0, LISTED));
  }

  list(near) {
    const rows = near.map(({ pair, kind, distance }) => {
      const row = document.createElement("li");
      const texts = [this.pairs.name(pair), CLASSES[kind], this.about(pair, kind, distance)];
      row.append(...texts.map((text) => Object.assign(document.createElement("span"), { textContent: text })));
      row.children[1].className = "badge";
      row.children[1].dataset.class = CLASSES[kind];
      row.addEventListener("click", () => this.moment.set(pair, NaN));
      return row;
    });
    document.getElementById("now").replaceChildren(...rows);
  }

  about(pair, kind, distance) {
    if (kind === CLASS.contact || Number.isNaN(distance)) return "";
    return `${this.pairs.isMeasured(pair, this.moment.time) ? "about" : "above"} ${lengthText(distance)}`;
  }

  // Draws the lines between witness points that the log has, moved between two ticks.
  setLines(time) {
    const { lineTime, linePair, linePoints } = this.pairs.arrays;
    const last = lastAtMost(lineTime, time, 0, lineTime.length);
    const places = [];
    const colours = [];
    const add = (pair, points) => {
      const { r, g, b } = new Color().setStyle(pair === this.moment.pair ? palette.accent : palette.ink);
      places.push(...points);
      colours.push(r, g, b, r, g, b);
    };
    for (let row = last; row >= 0 && lineTime[row] === lineTime[last]; row--) {
      const points = linePoints.subarray(6 * row, 6 * row + 6);
      add(linePair[row], this.moved(row, last, time) ?? points);
    }
    this.lines.visible = places.length > 0;
    if (!places.length) return;
    this.lines.geometry.dispose();
    this.lines.geometry = new LineSegmentsGeometry().setPositions(places).setColors(colours);
  }

  // Returns the ends of a line between its tick and the next, if its pair has a line there too.
  moved(row, last, time) {
    const { lineTime, linePair, linePoints } = this.pairs.arrays;
    const next = last + 1;
    for (let other = next; other < lineTime.length && lineTime[other] === lineTime[next]; other++) {
      if (linePair[other] !== linePair[row]) continue;
      const share = (time - lineTime[last]) / (lineTime[next] - lineTime[last]);
      return Array.from(
        { length: 6 },
        (_, axis) => linePoints[6 * row + axis] * (1 - share) + linePoints[6 * other + axis] * share,
      );
    }
    return null;
  }

  // Marks where the contacts that stand have begun; the first body carries the mark.
  setMarks(time) {
    const { touchPair, touchTime, touchPoint } = this.pairs.arrays;
    const latest = new Map();
    for (let touch = 0; touch < touchPair.length; touch++) {
      if (touchTime[touch] > time || this.pairs.classAt(touchPair[touch], time) !== CLASS.contact) continue;
      const known = latest.get(touchPair[touch]);
      if (known === undefined || touchTime[touch] > touchTime[known]) latest.set(touchPair[touch], touch);
    }
    const places = Array.from(latest).flatMap(([pair, touch]) => {
      const point = new Vector3().fromArray(touchPoint, 3 * touch);
      return this.bodies.carried(this.pairs.names(pair)[0], point, touchTime[touch]).toArray();
    });
    this.marks.visible = places.length > 0;
    this.marks.geometry.dispose();
    this.marks.geometry = new BufferGeometry().setAttribute(
      "position",
      new BufferAttribute(new Float32Array(places), 3),
    );
    this.marks.material.color.setStyle(palette.ink);
  }

  // Puts a dot on each body that is too small to be seen from here.
  setDots() {
    const perPixel = (2 * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / Math.max(1, this.canvas.clientHeight);
    const places = [];
    const colours = [];
    for (const { middle, radius, colour } of this.bodies.visible()) {
      if (2 * radius > DOT_PIXELS * perPixel * middle.distanceTo(this.camera.position)) continue;
      places.push(middle.x, middle.y, middle.z);
      colours.push(colour.r, colour.g, colour.b);
    }
    this.dots.geometry.dispose();
    this.dots.geometry = new BufferGeometry()
      .setAttribute("position", new BufferAttribute(new Float32Array(places), 3))
      .setAttribute("color", new BufferAttribute(new Float32Array(colours), 3));
  }

  // Names the body under the mouse.
  name(event) {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * x) / box.width - 1, 1 - (2 * y) / box.height), this.camera);
    const shown = this.bodies.group.children.filter((group) => group.visible && group !== this.bodies.crowd);
    const name = ray.intersectObjects(shown)[0]?.object.userData.body;
    this.label.hidden = name === undefined;
    if (name === undefined) return;
    const kind = CLASSES[this.kinds.get(name) ?? 0];
    this.label.textContent = kind === "nothing" ? name : `${name}: ${kind}`;
    this.label.style.left = `${x + 14}px`;
    this.label.style.top = `${y + 10}px`;
  }

  fit() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
    this.copyForPrint();
  }

  // Paper shows what a plain canvas holds; of this one, what was last on the screen.
  copyForPrint() {
    this.copy?.remove();
    if (!printing) return;
    this.copy = document.createElement("canvas");
    [this.copy.width, this.copy.height] = [this.canvas.width, this.canvas.height];
    this.copy.getContext("2d").drawImage(this.canvas, 0, 0);
    this.canvas.after(this.copy);
  }
}

// Returns a ring as a texture.
function ring() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const context = canvas.getContext("2d");
  context.strokeStyle = "white";
  context.lineWidth = 12;
  context.beginPath();
  context.arc(32, 32, 24, 0, 2 * Math.PI);
  context.stroke();
  return new CanvasTexture(canvas);
}
