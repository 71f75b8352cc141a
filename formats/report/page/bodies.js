// The bodies of the replay: their surfaces, and where they are at a time.

const TURN = 32767;
const BALL_SEGMENTS = [32, 16];
const SAMPLES = 24;

class Bodies {
  constructor(data) {
    this.arrays = data.arrays;
    this.tracks = new Map(data.replay.tracks.map((name, track) => [name, track]));
    this.geometries = { box: new BoxGeometry(1, 1, 1), sphere: new SphereGeometry(0.5, ...BALL_SEGMENTS) };
    this.group = new Group();
    this.byName = new Map();
    for (const body of data.replay.bodies) this.add(body);
    this.addCrowd();
    this.bounds = this.reach(data.start, data.end);
  }

  add({ name, parts, there }) {
    const material = new MeshLambertMaterial({ side: DoubleSide });
    const group = new Group();
    for (const { model, place, turn, size } of parts) {
      const mesh = new Mesh(this.geometry(model), material);
      mesh.position.set(...place);
      mesh.quaternion.set(...turn).normalize();
      mesh.scale.set(...size);
      mesh.userData.body = name;
      group.add(mesh);
    }
    const bounds = new Box3().setFromObject(group);
    const radius = bounds.isEmpty() ? 0 : bounds.getSize(new Vector3()).length() / 2;
    const centre = bounds.isEmpty() ? new Vector3() : bounds.getCenter(new Vector3());
    this.byName.set(name, { name, group, material, there, radius, centre, track: this.tracks.get(name) });
    this.group.add(group);
  }

  geometry(model) {
    if (!this.geometries[model]) {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(this.arrays[`points${model}`], 3));
      geometry.setIndex(new BufferAttribute(this.arrays[`triangles${model}`], 1));
      // Faces keep their edges: no corner is shared, so that each face has a normal of its own.
      const flat = geometry.toNonIndexed();
      flat.computeVertexNormals();
      this.geometries[model] = flat;
    }
    return this.geometries[model];
  }

  // Bodies that are too many to have names here: boxes, as many at each tick as there are bodies then.
  addCrowd() {
    const { boxFrom } = this.arrays;
    let most = 0;
    for (let tick = 0; tick + 1 < boxFrom.length; tick++) most = Math.max(most, boxFrom[tick + 1] - boxFrom[tick]);
    if (!most) return;
    this.crowd = new InstancedMesh(this.geometries.box, new MeshLambertMaterial(), most);
    this.crowd.frustumCulled = false;
    this.group.add(this.crowd);
  }

  // Puts all bodies where they are at a time, s; those that do not exist then are not shown.
  place(time) {
    for (const body of this.byName.values()) {
      body.group.visible = body.there.some(
        (from, index) => index % 2 === 0 && from <= time && time <= body.there[index + 1],
      );
      if (body.track !== undefined) this.placeTrack(body.track, time, body.group);
    }
    if (this.crowd) this.placeCrowd(time);
    this.group.updateMatrixWorld(true);
  }

  placeTrack(track, time, object) {
    const { poseFrom, poseTime, posePlace, poseTurn } = this.arrays;
    const [from, to] = [poseFrom[track], poseFrom[track + 1]];
    const before = Math.max(from, lastAtMost(poseTime, time, from, to));
    const after = Math.min(before + 1, to - 1);
    const length = poseTime[after] - poseTime[before];
    const share = length > 0 ? Math.min(1, Math.max(0, (time - poseTime[before]) / length)) : 0;
    blend(object.position, object.quaternion, posePlace, poseTurn, before, after, share);
  }

  placeCrowd(time) {
    const { boxFrom, boxTime, boxPlace, boxTurn, boxSize } = this.arrays;
    const tick = Math.max(0, lastAtMost(boxTime, time, 0, boxTime.length));
    const next = Math.min(tick + 1, boxTime.length - 1);
    const [from, to, other] = [boxFrom[tick], boxFrom[tick + 1], boxFrom[next]];
    const same = boxFrom[next + 1] - other === to - from && next !== tick;
    const share = same ? Math.min(1, (time - boxTime[tick]) / (boxTime[next] - boxTime[tick])) : 0;
    const [place, turn, size, matrix] = [new Vector3(), new Quaternion(), new Vector3(), new Matrix4()];
    for (let box = from; box < to; box++) {
      blend(place, turn, boxPlace, boxTurn, box, same ? other + box - from : box, share);
      this.crowd.setMatrixAt(box - from, matrix.compose(place, turn, size.fromArray(boxSize, 3 * box)));
    }
    this.crowd.count = to - from;
    this.crowd.instanceMatrix.needsUpdate = true;
  }

  // Returns where a point of the world at one time, s, is in the end if a body carries it to where it is placed now.
  carried(name, point, then) {
    const body = this.byName.get(name);
    if (body?.track === undefined) return point;
    const placed = new Group();
    this.placeTrack(body.track, then, placed);
    placed.updateMatrix();
    return point.applyMatrix4(placed.matrix.invert()).applyMatrix4(body.group.matrixWorld);
  }

  // Yields the middle, the radius and the colour of each body that is there.
  *visible() {
    for (const { group, centre, radius, material } of this.byName.values()) {
      if (group.visible)
        yield { middle: centre.clone().applyMatrix4(group.matrixWorld), radius, colour: material.color };
    }
    const { boxSize } = this.arrays;
    const matrix = new Matrix4();
    for (let box = 0; box < (this.crowd?.count ?? 0); box++) {
      this.crowd.getMatrixAt(box, matrix);
      const middle = new Vector3().setFromMatrixPosition(matrix);
      yield {
        middle,
        radius: new Vector3().fromArray(boxSize, 3 * box).length() / 2,
        colour: this.crowd.material.color,
      };
    }
  }

  // Returns the middle and the radius of what holds the bodies at some times of the run.
  reach(start, end) {
    const [box, seen] = [new Box3(), []];
    for (let sample = 0; sample <= SAMPLES; sample++) {
      this.place(start + (sample / SAMPLES) * (end - start));
      for (const { middle, radius } of this.visible()) {
        box.expandByPoint(middle);
        seen.push({ middle, radius });
      }
    }
    const middle = box.isEmpty() ? new Vector3() : box.getCenter(new Vector3());
    return {
      middle,
      radius: seen.reduce((most, body) => Math.max(most, body.middle.distanceTo(middle) + body.radius), 1e-9),
    };
  }

  paint(colours) {
    for (const { name, material } of this.byName.values()) material.color.setStyle(colours(name));
    this.crowd?.material.color.setStyle(palette.body);
  }
}

// Sets a place and a turn between rows `before` and `after` of arrays.
function blend(place, turn, places, turns, before, after, share) {
  const mix = (values, width, axis) =>
    values[width * before + axis] * (1 - share) + values[width * after + axis] * share;
  place.set(mix(places, 3, 0), mix(places, 3, 1), mix(places, 3, 2));
  let same = 0;
  for (let axis = 0; axis < 4; axis++) same += (turns[4 * before + axis] / TURN) * (turns[4 * after + axis] / TURN);
  const sign = same < 0 ? -1 : 1;
  const turned = [0, 1, 2, 3].map(
    (axis) => turns[4 * before + axis] * (1 - share) + sign * turns[4 * after + axis] * share,
  );
  turn.set(...turned).normalize();
}
