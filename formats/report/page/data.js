// The data of the page: arrays of numbers, read from the block that the page carries.

// From libraries.js: uPlot and three.js.
const {
  Box3,
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  Color,
  DirectionalLight,
  DoubleSide,
  Group,
  HemisphereLight,
  InstancedMesh,
  LineMaterial,
  LineSegments2,
  LineSegmentsGeometry,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  OrbitControls,
  PerspectiveCamera,
  Points,
  PointsMaterial,
  Quaternion,
  Raycaster,
  Scene,
  SphereGeometry,
  uPlot,
  Vector2,
  Vector3,
  WebGLRenderer,
} = libraries;

const ARRAYS = {
  "<f8": Float64Array,
  "<f4": Float32Array,
  "<u4": Uint32Array,
  "<i4": Int32Array,
  "<u2": Uint16Array,
  "<i2": Int16Array,
  "<u1": Uint8Array,
};

// Returns the facts of the page, and `arrays` by name.
async function readData(text) {
  const compressed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([compressed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const data = await new Response(stream).arrayBuffer();
  const length = new DataView(data).getUint32(0, true);
  const facts = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  const at = 4 + length;
  facts.arrays = Object.fromEntries(
    facts.arrays.map(([name, kind, offset, count]) => [name, new ARRAYS[kind](data, at + offset, count)]),
  );
  return facts;
}

// Returns the last place in [from, to) of a sorted array whose value is at most `value`; from - 1 if there is none.
function lastAtMost(values, value, from, to) {
  let low = from;
  let high = to;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
