// Two views of the surface that turn together: the start and a design.

import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, ColorManagement, DirectionalLight, LinearSRGBColorSpace, DoubleSide, LineBasicMaterial, LineLoop,
  LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, OrthographicCamera, Plane, PlaneGeometry, Raycaster, Scene, Vector2, Vector3, WebGLRenderTarget,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

// A colour on the surface is to look like the same colour in the legend.
ColorManagement.enabled = false;

const slowFrame = 20, rest = 250;  // milliseconds: from when on edges stay rough while something moves, and how long after it

const directions = { iso: [-1, -1.1, 0.8], front: [-1, 0, 0], side: [0, -1, 0], top: [0, 0, 1], back: [1, 0, 0], below: [0, 0, -1] };

/** One surface with its patch borders, in a scene of its own. */
class Model {
  constructor(shape, clip) {
    this.shape = shape;
    const corners = 3 * shape.triangles.length;
    this.geometry = new BufferGeometry();
    for (const name of ['position', 'normal']) this.geometry.setAttribute(name, new BufferAttribute(new Float32Array(corners), 3));
    this.geometry.setAttribute('color', new BufferAttribute(new Uint8Array(corners).fill(200), 3, true));
    this.material = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, clippingPlanes: clip });
    this.mesh = new Mesh(this.geometry, this.material);
    this.lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0x222222, clippingPlanes: clip }));
    this.scene = new Scene();
    this.scene.background = new Color(0xffffff);
    this.scene.add(this.mesh, this.lines, new AmbientLight(0xffffff, 1.75));
    this.light = new DirectionalLight(0xffffff, 1.45);
    this.scene.add(this.light, this.light.target);
    this.borders = new Uint32Array(0);
  }

  setPositions(p) {
    this.p = p;
    const { position, normal } = this.geometry.attributes;
    this.shape.corneredInto(p, position.array, normal.array);
    position.needsUpdate = normal.needsUpdate = true;
    this.geometry.computeBoundingSphere();
    this.setBorders(this.borders);
  }

  /** A picture while something is dragged: the borders wait for setPositions. */
  setQuickly(p) {
    this.p = p;
    const { position, normal } = this.geometry.attributes;
    this.shape.quicklyInto(p, position.array, normal.array);
    position.needsUpdate = normal.needsUpdate = true;
    this.lines.visible = false;
  }

  setBorders(borders) {
    this.borders = borders;
    const at = new Float32Array(3 * borders.length);
    borders.forEach((v, k) => { for (let c = 0; c < 3; ++c) at[3 * k + c] = this.p[3 * v + c]; });
    this.lines.geometry.dispose();
    this.lines.geometry = new BufferGeometry();
    this.lines.geometry.setAttribute('position', new BufferAttribute(at, 3));
    this.lines.visible = borders.length > 0;
  }

  /** paint(corner's triangle, corner's vertex, colours, index) for every corner. */
  setColors(paint) {
    const { color } = this.geometry.attributes;
    const T = this.shape.triangles;
    for (let corner = 0; corner < T.length; ++corner) paint(Math.floor(corner / 3), T[corner], color.array, 3 * corner);
    color.needsUpdate = true;
  }
}

/** The axis along which the body is flat, otherwise z: the default for up. */
export function likelyUp(size) {
  const order = [0, 1, 2].sort((a, b) => size[a] - size[b]);
  return size[order[0]] < 0.5 * size[order[1]] ? order[0] : 2;
}

/** A direction given for z up, for another axis; negative: that axis points down. */
function turned(direction, up, isDown = false) {
  const x = direction[0], y = isDown ? -direction[1] : direction[1], z = isDown ? -direction[2] : direction[2];
  if (up === 1) return [x, z, -y];
  return up === 0 ? [z, y, -x] : [x, y, z];
}

export class Viewer {
  /** @throws if there is no WebGL. */
  constructor(canvas, shape) {
    this.canvas = canvas;
    this.shape = shape;
    // Edges are smoothed in a picture of their own: where a processor draws, that costs four fifths of a frame, and waits.
    this.renderer = new WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: true });
    this.sheet = new Mesh(new PlaneGeometry(2, 2), new MeshBasicMaterial({ depthTest: false, depthWrite: false }));
    this.sheetCamera = new OrthographicCamera(-1, 1, 1, -1, -1, 1);
    this.smoothTimes = [];
    this.hurriedUntil = 0;
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.localClippingEnabled = true;
    this.renderer.setScissorTest(true);
    this.clip = [];
    this.start = new Model(shape, this.clip);
    this.design = new Model(shape, this.clip);
    this.camera = new OrthographicCamera(-1, 1, 1, -1, -50, 50);
    this.radius = shape.diagonal / 2;
    this.both = true;
    this.overlay = false;
    this.margin = 1;  // more leaves room around the body
    this.around = null;  // points to fit in place of the body's
    this.setUp(likelyUp(shape.size));
    canvas.addEventListener('keydown', (e) => this.key(e));
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.makeFrame();
  }

  /** 0, 1, 2: x, y, z. */
  setUp(axis, isDown = false) {
    this.up = axis;
    this.isDown = isDown;
    this.camera.up.set(...turned([0, 0, 1], axis, isDown));
    if (this.controls) this.controls.dispose();
    this.controls = new OrbitControls(this.camera, this.canvas);  // they keep the `up` of their creation
    this.controls.enableDamping = false;
    this.controls.addEventListener('change', () => { this.hurry(); this.draw(); });
    this.look('iso');
  }

  /** The rectangle of the section plane. */
  makeFrame() {
    this.frames = [this.start, this.design].map((model) => {
      const loop = new LineLoop(new BufferGeometry(), new LineBasicMaterial({ color: 0xb35806 }));
      loop.visible = false;
      model.scene.add(loop);
      return loop;
    });
  }

  setPlane(axis, at, shown, cut) {
    const half = this.shape.size.map((s) => 0.54 * s + 0.01 * this.shape.diagonal);
    const u = (axis + 1) % 3, w = (axis + 2) % 3;
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].flatMap(([a, b]) => {
      const point = [0, 0, 0];
      point[axis] = at; point[u] = a * half[u]; point[w] = b * half[w];
      return point;
    });
    for (const loop of this.frames) {
      loop.visible = shown;
      loop.geometry.dispose();
      loop.geometry = new BufferGeometry();
      loop.geometry.setAttribute('position', new BufferAttribute(new Float32Array(corners), 3));
    }
    this.clip.length = 0;
    if (cut) {
      const normal = [0, 0, 0];
      normal[axis] = -1;
      this.clip.push(new Plane(new Vector3(...normal), at));
    }
    for (const model of [this.start, this.design]) {
      model.material.clippingPlanes = model.lines.material.clippingPlanes = [...this.clip];
      model.material.needsUpdate = model.lines.material.needsUpdate = true;
    }
    this.draw();
  }

  look(name) {
    const [x, y, z] = directions[name];
    const size = Math.hypot(x, y, z);
    this.controls.target.set(0, 0, 0);
    this.camera.up.set(...turned(Math.abs(z) === size ? [0, 1, 0] : [0, 0, 1], this.up, this.isDown));
    this.camera.position.set(...turned([x, y, z], this.up, this.isDown)).multiplyScalar((4 * this.radius) / size);
    this.camera.zoom = 1;
    this.controls.update();
    this.fit();
    this.resize();
  }

  /** Centres the start and stores the half width and half height that must fit. */
  fit() {
    this.camera.updateMatrixWorld();
    const right = new Vector3().setFromMatrixColumn(this.camera.matrix, 0), up = new Vector3().setFromMatrixColumn(this.camera.matrix, 1);
    const range = (axis) => {
      let low = Infinity, high = -Infinity;
      const p = this.around || this.shape.start, step = 3 * Math.ceil(p.length / 60000);
      for (let v = 0; v < p.length; v += step) {
        const x = p[v] * axis.x + p[v + 1] * axis.y + p[v + 2] * axis.z;
        low = Math.min(low, x); high = Math.max(high, x);
      }
      return [(low + high) / 2, Math.max((high - low) / 2, 1e-3 * this.radius)];
    };
    const [x, halfWidth] = range(right), [y, halfHeight] = range(up);
    const shift = right.multiplyScalar(x).addScaledVector(up, y);
    this.span = [halfWidth, halfHeight];
    this.controls.target.add(shift);
    this.camera.position.add(shift);
    this.controls.update();
  }

  /** From where another view of the same box looked, its camera at `position`. */
  lookAs(other, position) {
    this.controls.target.copy(other.controls.target);
    this.camera.position.copy(position);
    this.camera.up.copy(other.camera.up);
    this.camera.zoom = other.camera.zoom;
    this.span = other.span;
    this.controls.update();
    this.draw();
  }

  /** Length per pixel at which the start fits into a pane. */
  lengthPerPixel(w, h) { return this.margin * Math.max((2.3 * this.span[1]) / h, (2.15 * this.span[0]) / w); }

  /** Arrow keys rotate, plus and minus zoom. */
  key(event) {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const zoom = { '+': 1.2, '=': 1.2, '-': 1 / 1.2 }[event.key];
    if (!turn && !zoom && event.key !== 'Home') return;
    event.preventDefault();
    if (event.key === 'Home') return this.look('iso');
    if (zoom) this.camera.zoom = Math.min(60, Math.max(0.3, this.camera.zoom * zoom));
    if (turn) {
      const right = new Vector3().setFromMatrixColumn(this.camera.matrix, 0);
      this.camera.position.applyAxisAngle(this.camera.up, (turn[0] * Math.PI) / 18);
      const next = this.camera.position.clone().applyAxisAngle(right, (turn[1] * Math.PI) / 18);
      if (Math.abs(next.clone().normalize().dot(this.camera.up)) < 0.995) this.camera.position.copy(next);
    }
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  /** [x, y, width, height] of each view in CSS pixels, from the top left. */
  get panes() {
    const { width, height } = this;
    if (!this.both) return [[this.design, 0, 0, width, height]];
    if (this.lengthPerPixel(width / 2, height) <= this.lengthPerPixel(width, height / 2)) {
      const half = Math.floor(width / 2);
      return [[this.start, 0, 0, half, height], [this.design, half, 0, width - half, height]];
    }
    const half = Math.floor(height / 2);
    return [[this.start, 0, 0, width, half], [this.design, 0, half, width, height - half]];
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.width = clientWidth;
    this.height = clientHeight;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.renderer.setSize(clientWidth, clientHeight, false);
    const { width, height } = this.canvas;
    if (!this.smoothed || this.smoothed.width !== width || this.smoothed.height !== height) {
      if (this.smoothed) this.smoothed.dispose();
      this.smoothed = new WebGLRenderTarget(width, height, { samples: 4 });
      this.sheet.material.map = this.smoothed.texture;
      this.smoothTimes = [];
    }
    if (this.onresize) this.onresize();
    this.draw();
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.render(); });
  }

  /** Something moves: for so long a frame that takes long is drawn without smoothing. */
  hurry(time = rest) {
    this.hurriedUntil = performance.now() + time;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => { if (this.isRough) this.draw(); }, time + 1);
  }

  /** Smoothing takes long here, by the least of the last three frames with it. */
  get isSlow() { return this.smoothTimes.length > 0 && Math.min(...this.smoothTimes) > slowFrame; }

  render() {
    if (!this.width || !this.design.p) return;
    const begin = performance.now();
    this.isRough = this.isSlow && begin < this.hurriedUntil;
    this.canvas.dataset.edges = this.isRough ? 'rough' : 'smooth';
    this.renderer.setRenderTarget(this.isRough ? null : this.smoothed);
    this.drawPanes();
    this.renderer.setRenderTarget(null);
    if (!this.isRough) this.showSmoothed(begin);
    if (this.onrender) this.onrender();
  }

  showSmoothed(begin) {
    this.renderer.setViewport(0, 0, this.width, this.height);
    this.renderer.setScissor(0, 0, this.width, this.height);
    this.renderer.render(this.sheet, this.sheetCamera);
    if (this.smoothTimes.length > 2) return;
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // a pixel that is read is drawn
    this.smoothTimes.push(performance.now() - begin);
  }

  /** Where the renderer draws now, in CSS pixels from the lower left. */
  setPane(x, y, w, h) {
    const target = this.renderer.getRenderTarget(), ratio = this.renderer.getPixelRatio();
    if (!target) {
      this.renderer.setViewport(x, y, w, h);
      this.renderer.setScissor(x, y, w, h);
      return;
    }
    target.viewport.set(x, y, w, h).multiplyScalar(ratio).round();  // panes reach the edge
    target.scissor.copy(target.viewport);
    target.scissorTest = true;
    this.renderer.setRenderTarget(target);
  }

  drawPanes() {
    for (const [model, x, y, w, h] of this.panes) {
      const half = this.lengthPerPixel(w, h) / 2;
      Object.assign(this.camera, { left: -half * w, right: half * w, top: half * h, bottom: -half * h });
      this.camera.near = -20 * this.radius;
      this.camera.far = 20 * this.radius;
      this.camera.updateProjectionMatrix();
      model.light.position.copy(this.camera.position).add(new Vector3(0, 0, this.radius));
      this.setPane(x, this.height - y - h, w, h);
      const ghost = this.overlay && model === this.design;
      if (ghost) this.showGhost();
      this.renderer.render(model.scene, this.camera);
      if (ghost) model.scene.remove(this.ghost);
    }
  }

  /** The start as a wireframe over the design. */
  showGhost() {
    if (!this.ghost) {
      const material = new MeshLambertMaterial({ color: 0x000000, wireframe: true, transparent: true, opacity: 0.18 });
      this.ghost = new Mesh(this.start.geometry, material);
    }
    this.design.scene.add(this.ghost);
  }

  /** The triangle under a point of the canvas, or -1. */
  triangleAt(x, y) {
    const hit = this.hitAt(x, y);
    return hit ? hit.faceIndex : -1;
  }

  /** The nearest place of the surface under a point of the canvas: {faceIndex, point}, or null. */
  hitAt(x, y) {
    for (const [model, left, top, w, h] of this.panes) {
      if (x < left || x >= left + w || y < top || y >= top + h) continue;
      const caster = new Raycaster();
      caster.setFromCamera(new Vector2((2 * (x - left)) / w - 1, 1 - (2 * (y - top)) / h), this.camera);
      const hit = caster.intersectObject(model.mesh, false)
        .find(({ point }) => this.clip.every((plane) => plane.distanceToPoint(point) >= 0));
      return hit || null;
    }
    return null;
  }

  /** Where a point is on the canvas of a single view, [x, y] in CSS pixels. */
  placeOf(point) {
    const p = new Vector3(...point).project(this.camera);
    return [((p.x + 1) / 2) * this.width, ((1 - p.y) / 2) * this.height];
  }

  /** Moves the view so that a point is in its middle, and closer. */
  flyTo(point, zoom) {
    const shift = new Vector3(...point).sub(this.controls.target);
    this.controls.target.add(shift);
    this.camera.position.add(shift);
    this.camera.zoom = zoom;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }
}
