// The camera: turns around a target (orbit) or looks around (fly); mouse, touch and keyboard.
import { PerspectiveCamera, Quaternion, Spherical, Vector3 } from "three";

const NEAR_POLE = 0.02;
/** Time for which a tap on a key moves the camera [s]. */
const FIRST_STEP = 0.04;

export class Camera {
  /**
   * @param {HTMLElement} element receives pointers and keys
   * @param {Vector3} up unit
   * @param {() => void} onChange
   * @param {(x: number, y: number) => void} onClick a pointer went down and up in one place [CSS pixels of the element]
   */
  constructor(element, up, onChange, onClick) {
    this.view = new PerspectiveCamera(50, 1, 0.1, 100);
    /** Turns the axis that points up to y, about which three.js has its angles. */
    this.upright = new Quaternion();
    this.setUp(up);
    this.target = new Vector3();
    this.isFlying = false;
    this.size = 1;
    this.element = element;
    this.onChange = onChange;
    this.onClick = onClick;
    /** @type {Map<number, { x: number, y: number }>} */
    this.pointers = new Map();
    this.moved = 0;
    /** @type {Set<string>} */
    this.keys = new Set();
    this.flight = 0;
    this.listen();
  }

  /** @param {Vector3} up unit */
  setUp(up) {
    this.view.up.copy(up);
    this.upright.setFromUnitVectors(up, new Vector3(0, 1, 0));
  }

  listen() {
    const { element } = this;
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      element.focus({ preventScroll: true });
      this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (this.pointers.size === 1) this.moved = 0;
      else this.moved = Infinity;
      this.stop();
      element.classList.add("dragging");
    });
    element.addEventListener("pointermove", (event) => this.drag(event));
    for (const type of ["pointerup", "pointercancel"])
      element.addEventListener(type, (event) => {
        const pointer = /** @type {PointerEvent} */ (event);
        if (!this.pointers.delete(pointer.pointerId)) return;
        if (this.pointers.size === 0) element.classList.remove("dragging");
        if (type === "pointerup" && this.moved < 5 && pointer.button === 0) {
          const box = element.getBoundingClientRect();
          this.onClick(pointer.clientX - box.left, pointer.clientY - box.top);
        }
      });
    element.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.stop();
      this.dolly(Math.exp(Math.max(-1, Math.min(1, event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)))));
    }, { passive: false });
    element.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (!MOVES[event.code]) return;
      event.preventDefault();
      if (this.keys.has(event.code)) return;
      this.stop();
      const isFirst = this.keys.size === 0;
      this.keys.add(event.code);
      this.step(FIRST_STEP);
      if (isFirst) this.run();
    });
    element.addEventListener("keyup", (event) => this.keys.delete(event.code));
    element.addEventListener("blur", () => this.keys.clear());
  }

  /** @param {PointerEvent} event */
  drag(event) {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return;
    const dx = event.clientX - pointer.x, dy = event.clientY - pointer.y;
    const middle = () => {
      const all = [...this.pointers.values()];
      return { x: (all[0].x + all[1].x) / 2, y: (all[0].y + all[1].y) / 2, apart: Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) };
    };
    const before = this.pointers.size === 2 ? middle() : null;
    pointer.x = event.clientX;
    pointer.y = event.clientY;
    this.moved += Math.abs(dx) + Math.abs(dy);
    if (this.moved < 5) return;
    if (before) {
      const after = middle();
      this.pan(after.x - before.x, after.y - before.y);
      this.dolly(before.apart / Math.max(after.apart, 1));
    } else if (event.shiftKey || event.buttons & 6) this.pan(dx, dy);
    else this.turn(dx, dy);
  }

  /** @param {number} dx [pixels] @param {number} dy [pixels] */
  turn(dx, dy) {
    const perPixel = (this.isFlying ? 1 : -1) * (1.6 / Math.max(this.element.clientHeight, 1));
    const { position } = this.view, pivot = this.isFlying ? position : this.target, arm = this.isFlying ? this.target : position;
    const angles = new Spherical().setFromVector3(arm.clone().sub(pivot).applyQuaternion(this.upright));
    angles.theta += perPixel * dx * 1.4;
    angles.phi = Math.min(Math.max(angles.phi + (this.isFlying ? -1 : 1) * perPixel * dy * 1.4, NEAR_POLE), Math.PI - NEAR_POLE);
    arm.copy(pivot).add(new Vector3().setFromSpherical(angles).applyQuaternion(this.upright.clone().conjugate()));
    this.update();
  }

  /** Moves with the picture. @param {number} dx [pixels] @param {number} dy [pixels] */
  pan(dx, dy) {
    const distance = this.view.position.distanceTo(this.target);
    const step = (2 * distance * Math.tan((this.view.fov * Math.PI) / 360)) / Math.max(this.element.clientHeight, 1);
    const right = new Vector3().setFromMatrixColumn(this.view.matrix, 0), up = new Vector3().setFromMatrixColumn(this.view.matrix, 1);
    this.shift(right.multiplyScalar(-dx * step).addScaledVector(up, dy * step));
  }

  /** @param {number} factor of the distance to the target */
  dolly(factor) {
    const arm = this.view.position.clone().sub(this.target);
    if (this.isFlying) this.shift(arm.normalize().multiplyScalar(0.3 * this.size * Math.log(factor)));
    else {
      arm.setLength(Math.min(Math.max(arm.length() * factor, 0.002 * this.size), 20 * this.size));
      this.view.position.copy(this.target).add(arm);
      this.update();
    }
  }

  /** @param {Vector3} by */
  shift(by) {
    this.view.position.add(by);
    this.target.add(by);
    this.update();
  }

  /** Moves by the keys that are held. @param {number} seconds */
  step(seconds) {
    const by = new Vector3();
    for (const key of this.keys) {
      const [column, sign] = MOVES[key];
      by.addScaledVector(new Vector3().setFromMatrixColumn(this.view.matrix, column), sign);
    }
    this.shift(by.multiplyScalar(0.35 * this.size * seconds));
  }

  /** Moves while keys are held. */
  run() {
    let last = performance.now();
    const frame = (/** @type {number} */ now) => {
      if (this.keys.size === 0) return;
      this.step(Math.min(Math.max(now - last, 0) / 1000, 0.1));
      last = now;
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  stop() {
    cancelAnimationFrame(this.flight);
  }

  /** Flies to a place, or jumps where motion is unwanted. @param {Vector3} position @param {Vector3} target */
  flyTo(position, target) {
    this.stop();
    const from = this.view.position.clone(), fromTarget = this.target.clone(), start = performance.now();
    const duration = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 450;
    const step = (/** @type {number} */ now) => {
      const t = duration === 0 ? 1 : Math.min(Math.max((now - start) / duration, 0), 1), eased = t * t * (3 - 2 * t);
      this.view.position.lerpVectors(from, position, eased);
      this.target.lerpVectors(fromTarget, target, eased);
      this.update();
      if (t < 1) this.flight = requestAnimationFrame(step);
    };
    step(start);
  }

  /** Shows all of a box. @param {import("three").Box3} box */
  frame(box) {
    const centre = box.getCenter(new Vector3()), towards = new Vector3(0.55, 0.35, 1).normalize().applyQuaternion(this.upright.clone().conjugate());
    this.size = Math.max(box.getSize(new Vector3()).length(), 1e-6);
    const right = this.view.up.clone().cross(towards).normalize(), up = towards.clone().cross(right);
    const tangent = Math.tan((this.view.fov * Math.PI) / 360), margin = 1.08;
    let distance = 0;
    for (let i = 0; i < 8; ++i) {
      const corner = new Vector3(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z).sub(centre);
      const across = Math.max(Math.abs(corner.dot(right)) / this.view.aspect, Math.abs(corner.dot(up)));
      distance = Math.max(distance, corner.dot(towards) + (margin * across) / tangent);
    }
    this.target.copy(centre);
    this.view.position.copy(centre).addScaledVector(towards, distance);
    this.update();
  }

  /** @param {number} aspect */
  setAspect(aspect) {
    this.view.aspect = aspect;
    this.update();
  }

  update() {
    const distance = this.view.position.distanceTo(this.target);
    this.view.near = Math.min(0.001 * this.size, 0.1 * distance);
    this.view.far = 3 * this.size + 2 * distance;
    this.view.lookAt(this.target);
    this.view.updateMatrix();
    this.view.updateMatrixWorld();
    this.view.updateProjectionMatrix();
    this.onChange();
  }
}

/** Column of the camera's matrix and sign, by key. @type {Record<string, [number, number]>} */
const MOVES = {
  KeyW: [2, -1], ArrowUp: [2, -1], KeyS: [2, 1], ArrowDown: [2, 1], KeyA: [0, -1], ArrowLeft: [0, -1], KeyD: [0, 1], ArrowRight: [0, 1],
  KeyQ: [1, -1], PageDown: [1, -1], KeyE: [1, 1], PageUp: [1, 1],
};
