// A triangulated surface as arrays: what every page shows.

const CREASE = Math.cos((40 * Math.PI) / 180);

/** The two other coordinates, to the right and upwards. */
export const acrossOf = (axis) => [[1, 2], [0, 2], [0, 1]][axis];

/** Corners that meet in each vertex, by vertex: [begin, list of 3t + k]. */
function cornersByVertex(triangles, vertices) {
  const begin = new Uint32Array(vertices + 1);
  for (const v of triangles) ++begin[v + 1];
  for (let v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
  const at = begin.slice(0, vertices), list = new Uint32Array(triangles.length);
  triangles.forEach((v, corner) => { list[at[v]++] = corner; });
  return { begin, list };
}

/** Lines through neighbours, those with an end first; each link once. */
function chains(beside) {
  const lines = [];
  const follow = (from) => {
    const line = [from];
    for (let here = from; beside.get(here).length > 0;) {
      const next = beside.get(here).pop(), back = beside.get(next);
      back.splice(back.indexOf(here), 1);
      line.push(next);
      here = next;
    }
    if (line.length > 1) lines.push(line);
  };
  for (const [edge, list] of beside) if (list.length === 1) follow(edge);
  for (const edge of beside.keys()) while (beside.get(edge).length > 0) follow(edge);
  return lines;
}

/** Needs `start` (n x 3, centred on the middle of the box), `triangles` (m x 3), `size` of the box and `diagonal`. */
export class Surface {
  finish() {
    this.corners = cornersByVertex(this.triangles, this.start.length / 3);
    this.normals = this.vertexNormals();
  }

  get vertices() { return this.start.length / 3; }

  /** Area normals of the start at its vertices, unit. */
  vertexNormals() {
    const n = new Float32Array(this.start.length), f = this.faceNormals(this.start);
    this.triangles.forEach((v, corner) => {
      const t = 3 * Math.floor(corner / 3);
      for (let c = 0; c < 3; ++c) n[3 * v + c] += f[t + c];
    });
    for (let v = 0; v < n.length; v += 3) {
      const length = Math.hypot(n[v], n[v + 1], n[v + 2]) || 1;
      for (let c = 0; c < 3; ++c) n[v + c] /= length;
    }
    return n;
  }

  /** Area times normal, m x 3. */
  faceNormals(p) {
    const out = new Float32Array(this.triangles.length);
    for (let t = 0; t < this.triangles.length; t += 3) {
      const a = 3 * this.triangles[t], b = 3 * this.triangles[t + 1], c = 3 * this.triangles[t + 2];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
      out[t] = uy * vz - uz * vy; out[t + 1] = uz * vx - ux * vz; out[t + 2] = ux * vy - uy * vx;
    }
    return out;
  }

  /** Positions and normals per corner, 3m x 3; normals are smooth up to creases of 40 degrees. */
  corneredInto(p, positions, normals) {
    const f = this.faceNormals(p), { begin, list } = this.corners, T = this.triangles;
    const length = new Float32Array(T.length / 3);
    for (let t = 0; t < length.length; ++t) length[t] = Math.hypot(f[3 * t], f[3 * t + 1], f[3 * t + 2]);
    for (let corner = 0; corner < T.length; ++corner) {
      const v = T[corner], t = Math.floor(corner / 3), at = 3 * corner;
      let x = 0, y = 0, z = 0;
      for (let k = begin[v]; k < begin[v + 1]; ++k) {
        const s = Math.floor(list[k] / 3);
        const dot = f[3 * t] * f[3 * s] + f[3 * t + 1] * f[3 * s + 1] + f[3 * t + 2] * f[3 * s + 2];
        if (s !== t && dot < CREASE * length[t] * length[s]) continue;
        x += f[3 * s]; y += f[3 * s + 1]; z += f[3 * s + 2];
      }
      const size = Math.hypot(x, y, z) || 1;
      normals[at] = x / size; normals[at + 1] = y / size; normals[at + 2] = z / size;
      positions[at] = p[3 * v]; positions[at + 1] = p[3 * v + 1]; positions[at + 2] = p[3 * v + 2];
    }
  }

  /** Per corner, the corners of its vertex that share its normal: those reached over edges without a crease, at the start. */
  smoothGroups() {
    if (this.groups) return this.groups;
    const T = this.triangles, f = this.faceNormals(this.start), { begin, list } = this.corners, group = new Uint32Array(T.length).fill(0xffffffff);
    const size = new Float32Array(T.length / 3);
    for (let t = 0; t < size.length; ++t) size[t] = Math.hypot(f[3 * t], f[3 * t + 1], f[3 * t + 2]);
    let count = 0;
    for (let v = 0; v + 1 < begin.length; ++v)
      for (let k = begin[v]; k < begin[v + 1]; ++k) {
        if (group[list[k]] !== 0xffffffff) continue;
        const todo = [list[k]];
        group[list[k]] = count;
        while (todo.length > 0) {
          const t = Math.floor(todo.pop() / 3);
          for (let m = begin[v]; m < begin[v + 1]; ++m) {
            const other = list[m], s = Math.floor(other / 3);
            if (group[other] !== 0xffffffff) continue;
            const dot = f[3 * t] * f[3 * s] + f[3 * t + 1] * f[3 * s + 1] + f[3 * t + 2] * f[3 * s + 2];
            if (dot < CREASE * size[t] * size[s]) continue;
            group[other] = count;
            todo.push(other);
          }
        }
        ++count;
      }
    this.groups = { group, sums: new Float32Array(3 * count) };
    return this.groups;
  }

  /** As `corneredInto`, with the creases of the start: a picture while something is dragged. */
  quicklyInto(p, positions, normals) {
    const { group, sums } = this.smoothGroups(), T = this.triangles;
    sums.fill(0);
    for (let t = 0; t < T.length; t += 3) {
      const a = 3 * T[t], b = 3 * T[t + 1], c = 3 * T[t + 2];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      for (let k = 0; k < 3; ++k) {
        const g = 3 * group[t + k], from = 3 * T[t + k], at = 3 * (t + k);
        sums[g] += x; sums[g + 1] += y; sums[g + 2] += z;
        positions[at] = p[from]; positions[at + 1] = p[from + 1]; positions[at + 2] = p[from + 2];
      }
    }
    for (let corner = 0; corner < T.length; ++corner) {  // the shader makes them unit
      const g = 3 * group[corner], at = 3 * corner;
      normals[at] = sums[g]; normals[at + 1] = sums[g + 1]; normals[at + 2] = sums[g + 2];
    }
  }

  /** Where the plane normal . x = at (unit normal) cuts the surface: lines of points [x, y, z]. */
  sectionBy(p, normal, at) {
    const count = this.vertices, side = new Float64Array(count), point = new Map(), beside = new Map();
    for (let v = 0; v < count; ++v) side[v] = normal[0] * p[3 * v] + normal[1] * p[3 * v + 1] + normal[2] * p[3 * v + 2] - at;
    for (let t = 0; t < this.triangles.length; t += 3) {
      const s = side[this.triangles[t]] < 0, q = side[this.triangles[t + 1]] < 0, r = side[this.triangles[t + 2]] < 0;
      if (s === q && q === r) continue;
      const cut = [];
      for (let k = 0; k < 3; ++k) {
        const i = this.triangles[t + k], j = this.triangles[t + ((k + 1) % 3)], a = Math.min(i, j), b = Math.max(i, j);
        if (side[a] < 0 === side[b] < 0) continue;
        const edge = a * count + b, share = side[a] / (side[a] - side[b]);
        if (!point.has(edge)) point.set(edge, [0, 1, 2].map((c) => p[3 * a + c] + share * (p[3 * b + c] - p[3 * a + c])));
        cut.push(edge);
      }
      if (cut.length !== 2) continue;
      for (const [e, g] of [cut, [cut[1], cut[0]]]) {
        if (!beside.has(e)) beside.set(e, []);
        beside.get(e).push(g);
      }
    }
    return chains(beside).map((line) => line.map((edge) => point.get(edge)));
  }

  /** Where the plane (axis 0 to 2) at `at` cuts the surface: lines of points [u, w] in the two other coordinates. */
  section(p, axis, at) {
    const [u, w] = acrossOf(axis), point = new Map(), beside = new Map();
    for (let t = 0; t < this.triangles.length; t += 3) {
      const cut = [];
      for (let k = 0; k < 3; ++k) {
        const i = this.triangles[t + k], j = this.triangles[t + ((k + 1) % 3)];
        const a = 3 * Math.min(i, j), b = 3 * Math.max(i, j);
        const da = p[a + axis] - at, db = p[b + axis] - at;
        if (da < 0 === db < 0) continue;
        const edge = (a / 3) * this.vertices + b / 3, s = da / (da - db);
        point.set(edge, [p[a + u] + s * (p[b + u] - p[a + u]), p[a + w] + s * (p[b + w] - p[a + w])]);
        cut.push(edge);
      }
      if (cut.length !== 2) continue;
      for (const [e, f] of [cut, [cut[1], cut[0]]]) {
        if (!beside.has(e)) beside.set(e, []);
        beside.get(e).push(f);
      }
    }
    return chains(beside).map((line) => line.map((edge) => point.get(edge)));
  }

  /** Edges between patches of different labels, pairs of vertices. */
  borders(label) {
    const owner = new Map(), out = [];
    for (let t = 0; t < label.length; ++t)
      for (let k = 0; k < 3; ++k) {
        const a = this.triangles[3 * t + k], b = this.triangles[3 * t + ((k + 1) % 3)];
        const edge = Math.min(a, b) * this.vertices + Math.max(a, b);
        const other = owner.get(edge);
        if (other === undefined) owner.set(edge, label[t]);
        else if (other !== label[t]) out.push(a, b);
      }
    return Uint32Array.from(out);
  }
}
