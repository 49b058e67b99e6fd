// The surface in 3D, with arrows, planes and marks around it.

import {
  ArrowHelper, BufferAttribute, BufferGeometry, CanvasTexture, Color, DoubleSide, Group, LineBasicMaterial, LineLoop, LineSegments, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, Points, PointsMaterial, Vector3,
} from 'three';
import { h } from '../../../viewer/page/src/dom.js';
import { Viewer, likelyUp } from '../../../viewer/page/src/viewer.js';
import { categories, colorAt, patchColors, scaleOf } from '../../../viewer/page/src/colors.js';
import { unhidden } from './sight.js';

const grey = [196, 200, 206], chosen = [230, 159, 0], held = [86, 180, 233], region = [0, 158, 115];
const names = ['x', 'y', 'z'];

/** A round dot with a light rim, for handles. */
let dotTexture = null;
function disc() {
  if (dotTexture) return dotTexture;
  const size = 64, canvas = document.createElement('canvas');
  canvas.width = canvas.height = size;
  const pen = canvas.getContext('2d');
  pen.fillStyle = '#fff';
  pen.beginPath(); pen.arc(size / 2, size / 2, 29, 0, 7); pen.fill();
  dotTexture = new CanvasTexture(canvas);
  return dotTexture;
}

/** By the crossings of a ray to the right. */
function isInside(line, x, y) {
  let inside = false;
  for (let k = 0, j = line.length - 1; k < line.length; j = k++) {
    const [ax, ay] = line[k], [bx, by] = line[j];
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  }
  return inside;
}

export class Scene3D {
  constructor(canvas, labels, body) {
    this.body = body;
    this.labels = labels;
    this.viewer = new Viewer(canvas, body);
    this.viewer.both = false;
    this.viewer.margin = 1.12;
    this.model = this.viewer.design;
    this.extras = new Group();
    this.hints = new Group();
    this.model.scene.add(this.extras, this.hints);
    this.handles = [];
    this.field = null;  // {values by vertex, signed, words}: in place of the colours of patches
    this.setBackground();
    this.model.setPositions(body.start);
    this.colour = body.facts.levels.length > 0 ? 'level:0' : 'plain';
    this.chosen = this.held = this.shown = null;
    this.words = [];
    this.viewer.onrender = () => { this.placeLabels(); const { afterDraw } = this.viewer; this.viewer.afterDraw = null; if (afterDraw) afterDraw(); };
    this.arrows();
    this.viewer.around = this.outline();
    this.creases();
    const { axes } = body.facts;
    if (axes) {
      const up = axes.up.map(Math.abs), axis = up.indexOf(Math.max(...up));
      this.viewer.setUp(axis, axes.up[axis] < 0);
    } else this.viewer.setUp(likelyUp(body.size));
    this.paint();
    this.viewer.resize();
  }

  /** Of the theme. */
  setBackground() {
    const words = getComputedStyle(document.documentElement).getPropertyValue('--stage').trim() || '#ffffff';
    this.model.scene.background = new Color(words);
    if (this.creaseLines) this.creaseLines.material.color.set(getComputedStyle(document.documentElement).getPropertyValue('--crease').trim() || '#000000');
    this.viewer.draw();
  }

  /** Things to drag: [{at, along (unit), color, words, moved(length)}], relative to the middle of the box. */
  setHandles(list) {
    this.handles = list;
    if (this.knobs) { this.model.scene.remove(this.knobs); this.knobs.geometry.dispose(); this.knobs = null; }
    if (list.length > 0) {
      const geometry = new BufferGeometry().setFromPoints(list.map((one) => new Vector3(...one.at)));
      geometry.setAttribute('color', new BufferAttribute(new Float32Array(list.flatMap((one) => new Color(one.color ?? 0xb35806).toArray())), 3));
      this.knobs = new Points(geometry, new PointsMaterial({ size: 15, sizeAttenuation: false, depthTest: false, vertexColors: true, map: disc(), transparent: true, alphaTest: 0.3 }));
      this.knobs.renderOrder = 10;
      this.model.scene.add(this.knobs);
    }
    this.viewer.draw();
  }

  /** The handle under a point of the canvas, or null. */
  handleAt(x, y) {
    let best = null, nearest = 16;
    for (const one of this.handles) {
      const [u, w] = this.viewer.placeOf(one.at), distance = Math.hypot(u - x, w - y);
      if (distance < nearest) { nearest = distance; best = one; }
    }
    return best;
  }

  /** By how much a handle goes along its direction when the pointer goes by these pixels; 0 where that points at the eye. */
  lengthAlong(handle, dx, dy) {
    const step = 0.01 * this.body.diagonal, a = this.viewer.placeOf(handle.at), b = this.viewer.placeOf(handle.at.map((v, c) => v + step * handle.along[c]));
    const u = (b[0] - a[0]) / step, w = (b[1] - a[1]) / step, size = u * u + w * w;
    return size * step * step < 0.02 ? 0 : (dx * u + dy * w) / size;
  }

  /** Lines through points relative to the middle of the box; replaces those of this name. */
  setLines(name, lines, color, dashed) {
    this.named = this.named || new Map();
    const before = this.named.get(name);
    if (before) { this.model.scene.remove(before); before.geometry.dispose(); this.named.delete(name); }
    const pairs = lines.flatMap((line) => line.slice(1).flatMap((p, k) => (dashed && k % 2 ? [] : [...line[k], ...p])));
    if (pairs.length > 0) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(new Float32Array(pairs), 3));
      const drawn = new LineSegments(geometry, new LineBasicMaterial({ color, depthTest: false, transparent: true, opacity: 0.95 }));
      drawn.renderOrder = 5;
      this.named.set(name, drawn);
      this.model.scene.add(drawn);
    }
    this.viewer.draw();
  }

  /** Two translucent surfaces: how far any shape within the limits may go; null: none. */
  setEnvelope(outward, inward) {
    for (const one of this.shells || []) { this.model.scene.remove(one); one.geometry.dispose(); }
    this.shells = [];
    if (outward) {
      const { start, normals, triangles } = this.body;
      for (const [by, sign, color] of [[outward, 1, 0x0072b2], [inward, -1, 0xd55e00]]) {
        const at = new Float32Array(start.length);
        for (let k = 0; k < at.length; ++k) at[k] = start[k] + sign * by[Math.floor(k / 3)] * normals[k];
        const geometry = new BufferGeometry();
        geometry.setAttribute('position', new BufferAttribute(at, 3));
        geometry.setIndex(new BufferAttribute(triangles, 1));
        geometry.computeVertexNormals();
        const shell = new Mesh(geometry, new MeshLambertMaterial({ color, transparent: true, opacity: 0.24, side: DoubleSide, depthWrite: false }));
        shell.renderOrder = 3;
        this.shells.push(shell);
        this.model.scene.add(shell);
      }
    }
    this.viewer.draw();
  }

  dispose() { clearTimeout(this.viewer.timer); this.viewer.controls.dispose(); this.viewer.renderer.dispose(); this.viewer.onrender = null; this.labels.replaceChildren(); }

  label(text, at, kind) { this.words.push({ at, element: h('span', { class: kind }, text) }); }

  /** What the view is to hold: the body, by some thousand of its vertices, and the arrows with their words. */
  outline() {
    const { start } = this.body, step = 3 * Math.ceil(start.length / 9000), points = [];
    for (let v = 0; v < start.length; v += step) points.push(start[v], start[v + 1], start[v + 2]);
    return Float32Array.from([...points, ...this.words.flatMap((word) => word.at)]);
  }

  /** Coordinate axes at the corner of the box, stream and up before and above the body, the plane of symmetry. */
  arrows() {
    const { body } = this, half = body.size.map((s) => s / 2), long = 0.14 * body.diagonal;
    const arrow = (direction, from, color, words, kind, share = 1.12) => {  // share: where along it the words stand
      const d = new Vector3(...direction).normalize(), o = new Vector3(...from);
      this.extras.add(new ArrowHelper(d, o, long, color, 0.22 * long, 0.12 * long));
      this.label(words, o.clone().addScaledVector(d, share * long).toArray(), kind);
    };
    const corner = half.map((s) => -s);
    for (let c = 0; c < 3; ++c) arrow([0, 1, 2].map((k) => (k === c ? 1 : 0)), corner, [0xc0392b, 0x2e7d32, 0x1f5fbf][c], names[c], 'axis');
    const { axes, symmetry } = body.facts;
    if (axes) {
      const reach = (d) => half.reduce((sum, s, c) => sum + s * Math.abs(d[c]), 0);
      const guess = axes.is_stated ? '' : ' (guess)';
      arrow(axes.downstream, axes.downstream.map((v) => -v * (reach(axes.downstream) + 1.25 * long)), 0x0072b2, `stream${guess}`, 'stream', -0.12);
      arrow(axes.up, axes.up.map((v) => v * (reach(axes.up) + 0.1 * long)), 0xd55e00, `up${guess}`, 'up');
    }
    if (symmetry) this.extras.add(...this.planeOf(symmetry.normal, symmetry.offset, 0x7b3fa0, 0.06, symmetry.is_half ? 'plane of symmetry (half a body)' : 'plane of symmetry'));
  }

  /** A rectangle of the plane normal . x = at of the file's coordinates, around the body. */
  planeOf(normal, at, color, opacity, words) {
    const n = new Vector3(...normal).normalize(), { body } = this;
    const distance = at - n.dot(new Vector3(...body.center));
    const other = Math.abs(n.x) < 0.7 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
    const u = new Vector3().crossVectors(n, other).normalize(), w = new Vector3().crossVectors(n, u);
    const reach = (d) => 0.56 * (body.size[0] * Math.abs(d.x) + body.size[1] * Math.abs(d.y) + body.size[2] * Math.abs(d.z)) + 0.02 * body.diagonal;
    const corner = (a, b) => n.clone().multiplyScalar(distance).addScaledVector(u, a * reach(u)).addScaledVector(w, b * reach(w));
    const points = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
    const loop = new LineLoop(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ color }));
    const face = new BufferGeometry().setFromPoints([points[0], points[1], points[2], points[0], points[2], points[3]]);
    const sheet = new Mesh(face, new MeshBasicMaterial({ color, transparent: true, opacity, side: DoubleSide, depthWrite: false }));
    if (words) this.label(words, points[2].toArray(), 'symmetry');
    return [loop, sheet];
  }

  boxOf(low, high) {
    const c = this.body.center, point = (k) => [0, 1, 2].map((a) => ((k >> a) & 1 ? high[a] : low[a]) - c[a]);
    const ends = [];
    for (let k = 0; k < 8; ++k) for (let a = 0; a < 3; ++a) if (!((k >> a) & 1)) ends.push(...point(k), ...point(k | (1 << a)));
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(ends), 3));
    return new LineSegments(geometry, new LineBasicMaterial({ color: 0xb35806 }));
  }

  /** Shows a plane or a box that is being dragged; nothing: none. */
  hint(plane, box) {
    for (const one of [...this.hints.children]) { this.hints.remove(one); one.geometry.dispose(); }
    if (plane) this.hints.add(...this.planeOf(plane.normal, plane.at, 0xb35806, 0.12));
    if (box) this.hints.add(this.boxOf(box[0], box[1]));
    this.viewer.draw();
  }

  /** Points of the ruler. */
  setKnots(points) {
    if (this.knots) { this.model.scene.remove(this.knots); this.knots.geometry.dispose(); this.knots = null; }
    if (points.length > 0) {
      this.knots = new Points(new BufferGeometry().setFromPoints(points.map((p) => new Vector3(...p))), new PointsMaterial({ color: 0x7b3fa0, size: 10, sizeAttenuation: false, depthTest: false, map: disc(), transparent: true, alphaTest: 0.3 }));
      this.knots.renderOrder = 10;
      this.model.scene.add(this.knots);
    }
    this.viewer.draw();
  }

  /** Border of the plane of a section; nothing: none. */
  cutPlane(plane) {
    for (const one of this.cutSheet || []) { this.model.scene.remove(one); one.geometry.dispose(); }
    this.cutSheet = plane ? this.planeOf(plane.normal, plane.at, 0xd5005e, 0.07) : [];
    if (plane) this.model.scene.add(...this.cutSheet);
    this.viewer.draw();
  }

  creases() {
    const lines = (pairs, color) => {
      const at = new Float32Array(3 * pairs.length);
      pairs.forEach((v, k) => { for (let c = 0; c < 3; ++c) at[3 * k + c] = this.body.start[3 * v + c]; });
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(at, 3));
      return new LineSegments(geometry, new LineBasicMaterial({ color }));
    };
    this.creaseLines = lines(this.body.array('creases'), 0x000000);
    this.extras.add(this.creaseLines);
    const trailing = this.body.array('trailing');
    if (trailing && trailing.length >= 6) {
      const points = [];
      for (let k = 0; k + 2 < trailing.length; k += 3) points.push(new Vector3(trailing[k], trailing[k + 1], trailing[k + 2]));
      const pairs = points.slice(1).flatMap((p, k) => [points[k], p]);
      this.trailingLine = new LineSegments(new BufferGeometry().setFromPoints(pairs), new LineBasicMaterial({ color: 0xd55e00, depthTest: false }));
      this.extras.add(this.trailingLine);
    }
  }

  /** Points of the file's coordinates as marks; the view goes to the first. */
  mark(places) {
    if (this.marks) { this.extras.remove(this.marks); this.marks.geometry.dispose(); this.marks = null; }
    if (places.length > 0) {
      const at = places.map((p) => new Vector3(...p.map((v, c) => v - this.body.center[c])));
      this.marks = new Points(new BufferGeometry().setFromPoints(at), new PointsMaterial({ color: 0xd5005e, size: 9, sizeAttenuation: false, depthTest: false }));
      this.extras.add(this.marks);
      this.viewer.flyTo(at[0].toArray(), 6);
    }
    this.viewer.draw();
  }

  placeLabels() {
    if (this.labels.childElementCount !== this.words.length) this.labels.replaceChildren(...this.words.map((w) => w.element));
    for (const { at, element } of this.words) {
      const [x, y] = this.viewer.placeOf(at);
      element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
    }
  }

  /** The label of each triangle and the names, of what the colours show. */
  labelling() {
    const { body } = this, [kind, level] = this.colour.split(':');
    if (kind === 'level') return { label: body.array(body.facts.levels[level].array), names: body.facts.levels[level].patches };
    if (kind === 'part') return { label: body.array('part'), names: body.facts.parts };
    if (kind === 'component') return { label: body.array('component'), names: null };
    return null;
  }

  /** Two shapes beside each other with the same colours; null: one again. */
  pair(first, second, field) {
    const { viewer } = this, left = viewer.start;
    viewer.both = Boolean(first);
    this.compared = first || null;
    this.labels.hidden = viewer.both;
    if (first) {
      left.setPositions(first);
      this.setPositions(second);
      this.setField(field);
      left.geometry.attributes.color.array.set(this.model.geometry.attributes.color.array);
      left.geometry.attributes.color.needsUpdate = true;
      left.scene.background = this.model.scene.background;
    } else {
      this.setField(null);
      this.setPositions(this.body.start);
    }
    viewer.draw();
  }

  /** Numbers at vertices as colours, with their scale for the legend; null: patches again. */
  setField(field) {
    this.field = field && { ...field, scale: scaleOf(field.values, field.signed, true) };
    this.paint();
    if (this.onfield) this.onfield(this.field);
  }

  paintField() {
    const { values, scale } = this.field, one = [0, 0, 0], table = new Uint8Array(3 * values.length);
    for (let v = 0; v < values.length; ++v) { colorAt(scale, values[v], one, 0); table.set(one, 3 * v); }
    this.model.setColors((t, v, out, at) => { for (let k = 0; k < 3; ++k) out[at + k] = table[3 * v + k]; });
    this.model.setBorders(new Uint32Array(0));
    this.viewer.draw();
  }

  paint() {
    if (this.field) { if (this.onmarks) this.onmarks({}); return this.paintField(); }
    if (this.onmarks) this.onmarks({ chosen: this.chosen, held: this.held, region: this.shown });
    const shown = this.labelling(), isMarked = this.chosen || this.held || this.shown;
    let colors = null;
    if (shown) {
      this.known = this.known || new Map();
      if (!this.known.has(this.colour)) {
        const count = shown.names ? shown.names.length : 1 + shown.label.reduce((a, b) => Math.max(a, b), 0);
        this.known.set(this.colour, count > 4000 ? Array.from({ length: count }, (_, k) => categories[k % categories.length]) : patchColors(shown.label, count, this.body.triangles));
        this.known.set(`${this.colour} borders`, this.body.borders(shown.label));
      }
      colors = this.known.get(this.colour);
    }
    this.model.setColors((t, v, out, at) => {
      let c = colors ? colors[shown.label[t]] : grey, fade = isMarked && colors ? 0.72 : 0;
      if (this.held && this.held[t]) { c = held; fade = 0; }
      if (this.shown && this.shown[t]) { c = region; fade = 0; }
      if (this.chosen && this.chosen[t]) { c = chosen; fade = 0; }
      for (let k = 0; k < 3; ++k) out[at + k] = (1 - fade) * c[k] + fade * 214;
    });
    this.model.setBorders(shown ? this.known.get(`${this.colour} borders`) : new Uint32Array(0));
    this.viewer.draw();
    return undefined;
  }

  /** To first order, while a slider is dragged. */
  preview(p) {
    this.model.setQuickly(p);
    this.creaseLines.visible = false;
    if (this.trailingLine) this.trailingLine.visible = false;
    this.viewer.hurry(2000);  // or until the exact shape is there
    this.viewer.draw();
  }

  /** Lines of the start are not those of another shape. */
  setPositions(p) {
    this.model.setPositions(p);
    if (this.onshape) this.onshape(p);
    this.creaseLines.visible = p === this.body.start;
    if (this.trailingLine) this.trailingLine.visible = p === this.body.start;
    this.viewer.draw();
  }

  /** What is at a point of the canvas, in the file's coordinates. */
  at(x, y) {
    const hit = this.viewer.hitAt(x, y);
    if (!hit) return null;
    const point = hit.point.toArray().map((v, c) => v + this.body.center[c]);
    return { triangle: hit.faceIndex, point };
  }

  /** Triangles whose middle lies in a closed line of the canvas, [[x, y], ...]; unless `through`, only those that are
   * seen: they face the eye and nothing hides them. */
  inLasso(line, through) {
    const { body, viewer } = this, found = [], eye = viewer.camera.getWorldDirection(new Vector3());
    const f = body.faceNormals(this.model.p), e = viewer.camera.matrixWorldInverse, p = viewer.camera.projectionMatrix;
    const xs = line.map((q) => q[0]), ys = line.map((q) => q[1]), v = new Vector3();
    const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    for (let t = 0; t < body.count; ++t) {
      if (!through && f[3 * t] * eye.x + f[3 * t + 1] * eye.y + f[3 * t + 2] * eye.z >= 0) continue;
      v.set(0, 0, 0);
      for (let k = 0; k < 3; ++k) {
        const at = 3 * body.triangles[3 * t + k];
        v.x += this.model.p[at] / 3; v.y += this.model.p[at + 1] / 3; v.z += this.model.p[at + 2] / 3;
      }
      v.applyMatrix4(e).applyMatrix4(p);
      const x = ((v.x + 1) / 2) * viewer.width, y = ((1 - v.y) / 2) * viewer.height;
      if (x < left || x > right || y < top || y > bottom || !isInside(line, x, y)) continue;
      found.push(t);
    }
    return through ? found : this.seen(found);
  }

  /** Those of the triangles whose middle is seen: nothing lies between it and the eye. */
  seen(triangles) {
    const { body, model, viewer } = this, p = model.p, e = viewer.camera.matrixWorldInverse.elements, view = new Float64Array(p.length);
    for (let v = 0; v < p.length; v += 3) for (let r = 0; r < 3; ++r) view[v + r] = e[r] * p[v] + e[4 + r] * p[v + 1] + e[8 + r] * p[v + 2] + e[12 + r];
    return unhidden(view, body.triangles, triangles, 1e-6 * body.diagonal);
  }
}
