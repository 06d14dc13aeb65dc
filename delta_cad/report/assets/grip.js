"use strict";

const NEAR_PX = { mouse: 14, pen: 20, touch: 32 }; // of the handle's middle, beside which a press takes hold of it

// Moves the handle with a mouse or a finger that takes the platform, the knob or what is near the handle's middle: in
// the plane through that point that faces the viewer.
class Grip {
  // moved(position in mm): where the pointer wants the handle.
  constructor(viewer, moved) {
    this.viewer = viewer;
    this.moved = moved;
    this.held = null; // pointer, plane, and the handle's place from the point that was taken
    this.pulled = false; // since it was taken last
    const on = (name, act) => viewer.canvas.addEventListener(name, act, true); // before the camera's own
    on("pointerdown", (event) => this.take(event));
    on("pointermove", (event) => (this.held ? this.pull(event) : this.hover(event)));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) on(end, (event) => this.leave(event));
    on("click", (event) => this.pulled && event.stopImmediatePropagation()); // the end of a pull
  }

  // The point that a pointer takes hold of; null beside the handle, and where the machine is apart.
  point(event) {
    const { viewer } = this;
    if (viewer.apart > 0 || viewer.parts.length === 0) return null;
    const [x, y] = viewer.pixel(event);
    const hit = viewer.hit(x, y);
    if (hit?.part.link === "platform") return hit.point;
    const middle = viewer.handle.position.clone();
    const { clientWidth: w, clientHeight: h } = viewer.canvas;
    const seen = middle.clone().project(viewer.camera);
    const away = Math.hypot(((seen.x + 1) * w) / 2 - x, ((1 - seen.y) * h) / 2 - y);
    return away <= (NEAR_PX[event.pointerType] ?? NEAR_PX.mouse) ? middle : null;
  }

  hover(event) {
    if (event.buttons) return;
    this.viewer.canvas.style.cursor = this.point(event) ? "grab" : "";
  }

  take(event) {
    if (this.held || !event.isPrimary || event.button !== 0) return;
    this.pulled = false;
    const point = this.point(event);
    if (!point) return;
    const { viewer } = this;
    const facing = viewer.camera.getWorldDirection(new THREE.Vector3());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(facing, point);
    this.held = { pointer: event.pointerId, plane, from: viewer.handle.position.clone().sub(point) };
    viewer.controls.enabled = false;
    viewer.canvas.setPointerCapture(event.pointerId);
    viewer.canvas.style.cursor = "grabbing";
  }

  pull(event) {
    if (event.pointerId !== this.held.pointer) return;
    const at = this.viewer.ray(...this.viewer.pixel(event)).ray.intersectPlane(this.held.plane, new THREE.Vector3());
    this.pulled = true;
    if (at) this.moved(at.add(this.held.from).toArray());
  }

  leave(event) {
    if (event.pointerId !== this.held?.pointer) return;
    this.held = null;
    this.viewer.controls.enabled = true;
    this.viewer.canvas.style.cursor = "";
  }
}
