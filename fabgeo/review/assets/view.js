// The 3D view: all parts of a family in one buffer, each part a range of its vertices.
const FAMILIES = ["panels", "cells", "beams", "connectors"];

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}

function decode() {
  const steps = new Uint16Array(bytes(DATA.parts.steps));
  let at = 0;
  return DATA.parts.index.map(([mark, family, n, k, x, y, z, size, nx, ny, nz, row = mark]) => {
    const points = new Float32Array(3 * n * k), step = size / 65535;
    for (let i = 0; i < points.length; i += 3, at += 3) {
      points[i] = x + steps[at] * step;
      points[i + 1] = y + steps[at + 1] * step;
      points[i + 2] = z + steps[at + 2] * step;
    }
    return { mark, family, n, k, points, normal: [nx, ny, nz], row };
  });
}

// Ruled faces between neighbouring rails and the two end caps; vertices are not shared by faces.
function facesOf(part) {
  const { n, k, points } = part, faces = [];
  const rail = (j) => [...Array(k).keys()].map((i) => 3 * (j * k + i));
  const sides = n === 2 ? [[rail(0), rail(1)]]
    : [...Array(n).keys()].map((j) => [rail(j), rail((j + 1) % n)]);
  for (const [a, b] of sides) {
    const triangles = [];
    for (let i = 0; i + 1 < k; i++) triangles.push([i, i + 1, k + i], [i + 1, k + i + 1, k + i]);
    faces.push({ at: [...a, ...b], triangles });
  }
  if (n > 2) {
    for (const end of [0, k - 1]) {
      const at = [...Array(n).keys()].map((j) => 3 * (j * k + end)), triangles = [];
      for (let j = 1; j + 1 < n; j++) triangles.push([0, j, j + 1]);
      faces.push({ at, triangles });
    }
  }
  return faces;
}

function familyMesh(parts, offset) {
  let vertices = 0, corners = 0;
  const faces = parts.map((part) => facesOf(part));
  faces.flat().forEach((f) => { vertices += f.at.length; corners += 3 * f.triangles.length; });
  const base = new Float32Array(3 * vertices), shift = new Float32Array(3 * vertices);
  const normals = new Float32Array(3 * vertices), index = new Uint32Array(corners);
  const owner = new Uint32Array(corners / 3), ranges = [], lines = [], lineShift = [];
  let v = 0, c = 0;
  parts.forEach((part, number) => {
    const first = v;
    for (const face of faces[number]) {
      const start = v, sum = new Float32Array(3 * face.at.length);
      face.at.forEach((from) => {
        for (let d = 0; d < 3; d++) {
          base[3 * v + d] = part.points[from + d] - offset[d];
          shift[3 * v + d] = part.normal[d];
        }
        v++;
      });
      for (const t of face.triangles) {
        const p = t.map((i) => 3 * (start + i));
        const e = [0, 1, 2].map((d) => base[p[1] + d] - base[p[0] + d]);
        const g = [0, 1, 2].map((d) => base[p[2] + d] - base[p[0] + d]);
        const cross = [e[1] * g[2] - e[2] * g[1], e[2] * g[0] - e[0] * g[2], e[0] * g[1] - e[1] * g[0]];
        t.forEach((i) => cross.forEach((value, d) => { sum[3 * i + d] += value; }));
        owner[c / 3] = number;
        t.forEach((i) => { index[c++] = start + i; });
      }
      for (let i = 0; i < face.at.length; i++) {
        const s = Math.hypot(sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]) || 1;
        for (let d = 0; d < 3; d++) normals[3 * (start + i) + d] = sum[3 * i + d] / s;
      }
    }
    ranges.push([first, v]);
    outline(part).forEach((from) => {
      for (let d = 0; d < 3; d++) { lines.push(part.points[from + d] - offset[d]); lineShift.push(part.normal[d]); }
    });
  });
  return { base, shift, normals, index, owner, ranges, lines: new Float32Array(lines), lineShift: new Float32Array(lineShift) };
}

// Segments (pairs of point addresses) along the outer rails and across both ends.
function outline({ n, k }) {
  const at = [], rails = n === 2 ? [0, 1] : n === 4 ? [2, 3] : [...Array(n).keys()];
  for (const j of rails) for (let i = 0; i + 1 < k; i++) at.push(3 * (j * k + i), 3 * (j * k + i + 1));
  for (const end of [0, k - 1]) {
    for (let r = 0; r < rails.length - (rails.length === 2 ? 1 : 0); r++) {
      at.push(3 * (rails[r] * k + end), 3 * (rails[(r + 1) % rails.length] * k + end));
    }
  }
  return at;
}

class View {
  constructor(host, onPick) {
    this.host = host;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.debug.checkShaderErrors = false; // to check waits for the driver
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    host.append(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 1, 1e7);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    this.sun = new THREE.DirectionalLight(0xffffff, 1.9);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f96, 1.9), this.sun);
    this.plane = new THREE.Plane(new THREE.Vector3(1, 0, 0), 0);
    this.build();
    this.listen(onPick);
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
    this.fit();
  }

  build() {
    const parts = decode();
    const box = new THREE.Box3(), p = new THREE.Vector3();
    parts.forEach((part) => {
      for (let i = 0; i < part.points.length; i += 3) box.expandByPoint(p.set(part.points[i], part.points[i + 1], part.points[i + 2]));
    });
    this.centre = box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3());
    this.size = box.isEmpty() ? 1 : box.getSize(new THREE.Vector3()).length();
    this.half = box.isEmpty() ? new THREE.Vector3(1, 1, 1) : box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    const offset = this.centre.toArray();
    this.layers = new Map();
    this.place = new Map();
    FAMILIES.forEach((name, number) => {
      const own = parts.filter((part) => part.family === number);
      if (own.length) this.addLayer(name, own, offset);
    });
    this.addConnectors(offset);
  }

  addLayer(name, parts, offset) {
    const data = familyMesh(parts, offset);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(data.base.slice(), 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(data.normals, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(data.base.length), 3));
    geometry.setIndex(new THREE.BufferAttribute(data.index, 1));
    const material = new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    if (name === "cells") { material.transparent = true; material.opacity = 0.55; }
    const mesh = new THREE.Mesh(geometry, material);
    const lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0x22303a, transparent: true, opacity: 0.55 }));
    lines.geometry.setAttribute("position", new THREE.BufferAttribute(data.lines.slice(), 3));
    this.scene.add(mesh, lines);
    this.layers.set(name, { mesh, lines, data, parts });
    parts.forEach((part, number) => this.place.set(part.mark, { layer: name, number }));
    parts.forEach((part, number) => { if (!this.place.has(part.row)) this.place.set(part.row, { layer: name, number }); });
  }

  addConnectors(offset) {
    const rows = [...ROWS].filter(([, row]) => row.table === "connectors"), marks = rows.map(([mark]) => mark);
    if (!marks.length) return;
    const r = Math.min(Math.max(this.size / 900, 12), 60);
    const geometry = new THREE.CylinderGeometry(r, r, 5 * r, 8);
    const mesh = new THREE.InstancedMesh(geometry, new THREE.MeshLambertMaterial({ color: 0xffffff }), marks.length);
    const up = new THREE.Vector3(0, 1, 0), matrix = new THREE.Matrix4(), grey = new THREE.Color(0x6b4fa0);
    rows.forEach(([mark, { values }], i) => {
      const at = ["x", "y", "z"].map((d, k) => values[`${d}_mm`] - offset[k]);
      const axis = new THREE.Vector3(values.axis_x, values.axis_y, values.axis_z);
      matrix.makeRotationFromQuaternion(new THREE.Quaternion().setFromUnitVectors(up, axis.normalize()));
      matrix.setPosition(...at);
      mesh.setMatrixAt(i, matrix);
      mesh.setColorAt(i, grey);
      this.place.set(mark, { layer: "connectors", number: i, at });
    });
    this.scene.add(mesh);
    this.layers.set("connectors", { mesh, marks });
  }

  colour(scheme, selected) {
    const tint = new THREE.Color();
    const plain = { cells: "#9fb4c4", beams: "#7b8794" };
    for (const [name, { mesh, data, parts }] of this.layers) {
      if (!data) continue;
      const array = mesh.geometry.attributes.color.array;
      parts.forEach((part, number) => {
        const row = ROWS.get(part.row)?.values;
        const own = name === "panels" || (row?.verdict === "fail" && scheme.words?.has("fail"));
        tint.set(part.mark === selected || part.row === selected ? "#d0006f" : own ? scheme.colour(row) : plain[name] ?? scheme.colour(row));
        const [from, to] = data.ranges[number];
        for (let v = from; v < to; v++) tint.toArray(array, 3 * v);
      });
      mesh.geometry.attributes.color.needsUpdate = true;
    }
    const connectors = this.layers.get("connectors");
    if (connectors) {
      connectors.marks.forEach((mark, i) => connectors.mesh.setColorAt(i, tint.set(mark === selected ? "#d0006f" : "#6b4fa0")));
      connectors.mesh.instanceColor.needsUpdate = true;
    }
    this.draw();
  }

  explode(amount) {
    const way = amount * this.size * 0.18;
    const reach = { panels: 1, connectors: 0, cells: 0.45, beams: 0 };
    for (const [name, { mesh, lines, data }] of this.layers) {
      if (!data) continue;
      for (const [target, base, shift] of [[mesh, data.base, data.shift], [lines, data.lines, data.lineShift]]) {
        const attribute = target.geometry.attributes.position, array = attribute.array;
        for (let i = 0; i < array.length; i++) array[i] = base[i] + way * reach[name] * shift[i];
        attribute.needsUpdate = true;
        target.geometry.computeBoundingSphere();
      }
    }
    // The model grows: step back as far, so that what was seen stays in view.
    const grown = (1 + 0.7 * amount) / (1 + 0.7 * (this.exploded ?? 0));
    this.exploded = amount;
    this.camera.position.sub(this.controls.target).multiplyScalar(grown).add(this.controls.target);
    this.draw();
  }

  section(axis, fraction) {
    const d = "xyz".indexOf(axis);
    this.renderer.clippingPlanes = d < 0 ? [] : [this.plane];
    if (d >= 0) {
      this.plane.normal.set(d === 0 ? -1 : 0, d === 1 ? -1 : 0, d === 2 ? -1 : 0);
      this.plane.constant = (2 * fraction - 1) * this.half.getComponent(d) * 1.01;
    }
    this.draw();
  }

  show(layer, on) {
    const { mesh, lines } = this.layers.get(layer);
    mesh.visible = on;
    if (lines) lines.visible = on;
    this.draw();
  }

  boxOf(mark) {
    const found = this.place.get(mark);
    if (!found) return null;
    const box = new THREE.Box3(), p = new THREE.Vector3();
    if (found.at) return box.setFromCenterAndSize(p.set(...found.at), new THREE.Vector3(800, 800, 800));
    const { data, mesh } = this.layers.get(found.layer), [from, to] = data.ranges[found.number];
    for (let v = from; v < to; v++) box.expandByPoint(p.fromBufferAttribute(mesh.geometry.attributes.position, v));
    return box;
  }

  fly(mark) {
    const box = this.boxOf(mark);
    if (!box) return;
    const centre = box.getCenter(new THREE.Vector3()), found = this.place.get(mark);
    const reach = Math.max(box.getSize(new THREE.Vector3()).length() * 3.2, this.size / 60);
    const part = found.at ? null : this.layers.get(found.layer).parts[found.number];
    const away = part ? new THREE.Vector3(...part.normal) : this.camera.position.clone().sub(centre);
    const side = this.camera.position.clone().sub(this.controls.target).normalize();
    away.normalize().multiplyScalar(1.2).add(side).normalize();
    this.glide(centre, centre.clone().addScaledVector(away, reach));
  }

  // The nearest place along the standard direction from which every part is seen, in the middle.
  fit() {
    const way = new THREE.Vector3(-0.62, -0.55, 0.56).normalize();
    const right = new THREE.Vector3(0, 0, 1).cross(way).normalize(), up = way.clone().cross(right);
    const high = Math.tan(THREE.MathUtils.degToRad(17.5)) * 0.92, wide = high * this.camera.aspect;
    // The middle between the two lines of sight, leaning by `slope`, that touch the model; how far
    // off they meet.
    const touch = (side, slope) => {
      let [one, other] = [-Infinity, -Infinity];
      for (const { data } of this.layers.values()) {
        const base = data?.base ?? []; // connectors are instances of one product: they have none
        for (let i = 0; i < base.length; i += 3) {
          const out = slope * (base[i] * way.x + base[i + 1] * way.y + base[i + 2] * way.z);
          const along = base[i] * side.x + base[i + 1] * side.y + base[i + 2] * side.z;
          [one, other] = [Math.max(one, out + along), Math.max(other, out - along)];
        }
      }
      return one > -Infinity ? [(one - other) / 2, (one + other) / 2 / slope] : [0, this.size / slope];
    };
    const [x, across] = touch(right, wide), [y, upright] = touch(up, high);
    const target = right.clone().multiplyScalar(x).addScaledVector(up, y);
    this.glide(target, target.clone().addScaledVector(way, Math.max(across, upright)), true);
  }

  glide(target, position, now = false) {
    const [t0, p0] = [this.controls.target.clone(), this.camera.position.clone()];
    const still = now || matchMedia("(prefers-reduced-motion: reduce)").matches;
    const begin = performance.now(), turn = (this.turn = (this.turn ?? 0) + 1);
    const step = (time) => {
      if (turn !== this.turn) return;
      const f = still ? 1 : Math.min((time - begin) / 450, 1), s = f * f * (3 - 2 * f);
      this.controls.target.lerpVectors(t0, target, s);
      this.camera.position.lerpVectors(p0, position, s);
      this.controls.update();
      this.draw();
      if (f < 1) requestAnimationFrame(step);
    };
    step(begin);
  }

  pick(x, y) {
    const area = this.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2((x - area.left) / area.width * 2 - 1, 1 - (y - area.top) / area.height * 2);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const shown = [...this.layers.values()].filter((l) => l.mesh.visible);
    const clip = this.renderer.clippingPlanes;
    const hits = ray.intersectObjects(shown.map((l) => l.mesh), false)
      .filter((hit) => clip.every((plane) => plane.distanceToPoint(hit.point) >= 0));
    if (!hits.length) return null;
    const layer = shown.find((l) => l.mesh === hits[0].object);
    if (layer.marks) return layer.marks[hits[0].instanceId];
    const part = layer.parts[layer.data.owner[hits[0].faceIndex]];
    return ROWS.has(part.mark) ? part.mark : part.row;
  }

  listen(onPick) {
    const canvas = this.renderer.domElement;
    let down = null;
    canvas.addEventListener("pointerdown", (e) => { down = [e.clientX, e.clientY]; });
    canvas.addEventListener("pointerup", (e) => {
      if (!down || Math.hypot(e.clientX - down[0], e.clientY - down[1]) > 4) return;
      const mark = this.pick(e.clientX, e.clientY);
      if (mark) onPick(mark);
    });
    this.host.addEventListener("keydown", (e) => {
      const turns = { ArrowLeft: [0.12, 0], ArrowRight: [-0.12, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
      const zooms = { "+": 0.85, "=": 0.85, "-": 1.18 };
      const way = this.camera.position.clone().sub(this.controls.target);
      if (turns[e.key]) {
        const [a, b] = turns[e.key], r = way.length();
        const azimuth = Math.atan2(way.y, way.x) + a;
        const polar = Math.min(Math.max(Math.acos(way.z / r) + b, 0.05), Math.PI - 0.05);
        way.set(Math.cos(azimuth) * Math.sin(polar), Math.sin(azimuth) * Math.sin(polar), Math.cos(polar)).multiplyScalar(r);
      } else if (zooms[e.key]) way.multiplyScalar(zooms[e.key]);
      else return;
      e.preventDefault();
      this.camera.position.copy(this.controls.target).add(way);
      this.controls.update();
      this.draw();
    });
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.host;
    if (!w || !h || (this.width === w && this.height === h)) return;
    [this.width, this.height] = [w, h];
    this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    this.draw();
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const distance = this.camera.position.distanceTo(this.controls.target);
      this.camera.near = Math.max(distance / 500, 1);
      this.camera.far = distance + 3 * this.size;
      this.camera.updateProjectionMatrix();
      this.sun.position.copy(this.camera.position).add(new THREE.Vector3(-0.3, 0.2, 0.8).multiplyScalar(distance));
      this.scene.background = new THREE.Color(getComputedStyle(document.body).getPropertyValue("--stage").trim() || "#e9edf0");
      this.renderer.render(this.scene, this.camera);
    });
  }
}
