// SPDX-License-Identifier: Apache-2.0
// The arm in three dimensions from the robot file's own Denavit-Hartenberg numbers: where the
// encoders say it is (solid), and where it is told to be (wire).

import * as THREE from "./lib/three/three.module.js";
import { el } from "./dom.js";

const TUBE_M = 0.04;
const SOLID = 0x0072b2;
const WIRE = 0xd55e00;

/** Positions of the joints' frames, m: the base, then one per link. angles: rad. */
export function frames(links, angles) {
  const at = new THREE.Matrix4();
  const places = [new THREE.Vector3()];
  links.forEach(({ alpha, a, d, theta0 }, n) => {
    const [ct, st] = [Math.cos(theta0 + angles[n]), Math.sin(theta0 + angles[n])];
    const [ca, sa] = [Math.cos(alpha), Math.sin(alpha)];
    const bend = new THREE.Vector3(0, 0, d).applyMatrix4(at);
    at.multiply(
      new THREE.Matrix4().set(
        ct, -st * ca, st * sa, a * ct,
        st, ct * ca, -ct * sa, a * st,
        0, sa, ca, d,
        0, 0, 0, 1,
      ),
    );  // prettier-ignore
    places.push(bend, new THREE.Vector3().setFromMatrixPosition(at));
  });
  return places;
}

/** Joint angle, rad, of a count. The counter is 0 where the joint stood at power-on. */
export function jointAngle(motor, count) {
  return motor.angle0 + (2 * Math.PI * count) / (motor.counts_per_rev * motor.gear);
}

export class Arm {
  constructor(machine) {
    this.machine = machine;
    this.element = el("div", { className: "arm", tabIndex: 0, role: "img",
      "aria-label": "the arm; arrow keys turn the view" });  // prettier-ignore
    this.turn = { around: 0.8, above: 0.4, away: 3 };
    machine.try(machine.link.request("machine")).then((about) => this.#build(about));
  }

  #build(about) {
    if (!about?.links?.length) {
      this.element.replaceChildren("This machine is no arm: its robot file has no links.");
      return;
    }
    this.links = about.links;
    this.motors = about.motors;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xf4f4f2);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x777766, 3));
    const floor = new THREE.GridHelper(2, 10);
    floor.rotateX(Math.PI / 2);
    floor.position.z = -0.67; // a PUMA's shoulder stands so high above it
    this.scene.add(floor);
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.05, 20);
    this.camera.up.set(0, 0, 1);
    this.solid = new THREE.Group();
    this.wire = new THREE.Group();
    this.scene.add(this.solid, this.wire);
    try {
      this.renderer = new THREE.WebGLRenderer({ antialias: true });
    } catch {
      this.element.replaceChildren("This browser draws no three-dimensional pictures (WebGL).");
      return;
    }
    this.element.append(this.renderer.domElement);
    this.#listen();
    this.resize();
  }

  #listen() {
    this.element.addEventListener("pointermove", (event) => {
      if (!event.buttons) return;
      this.turn.around -= event.movementX / 150;
      this.turn.above = Math.max(-1.5, Math.min(1.5, this.turn.above + event.movementY / 150));
      this.update();
    });
    this.element.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.turn.away = Math.max(0.8, Math.min(6, this.turn.away * Math.exp(event.deltaY / 800)));
      this.update();
    });
    this.element.addEventListener("keydown", ({ key }) => {
      const by = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[key];
      if (!by) return;
      this.turn.around += by[0];
      this.turn.above = Math.max(-1.5, Math.min(1.5, this.turn.above + by[1]));
      this.update();
    });
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!this.renderer || !width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.update();
  }

  update() {
    if (!this.renderer) return;
    const latest = this.motors.map((_, axis) => this.machine.history.latest(axis));
    if (latest.some((values) => values === null)) return;
    const angles = (field) => this.motors.map((m, n) => jointAngle(m, latest[n][field]));
    this.#tubes(this.solid, frames(this.links, angles("encnow")), SOLID, false);
    this.#tubes(this.wire, frames(this.links, angles("demand")), WIRE, true);
    const { around, above, away } = this.turn;
    this.element.dataset.away = away.toFixed(2); // seen by tests
    this.camera.position.set(
      away * Math.cos(above) * Math.cos(around),
      away * Math.cos(above) * Math.sin(around),
      away * Math.sin(above) + 0.2,
    );
    this.camera.lookAt(0, 0, 0.2);
    this.renderer.render(this.scene, this.camera);
  }

  #tubes(group, places, colour, wireframe) {
    for (const mesh of group.children) mesh.geometry.dispose();
    group.clear();
    const material = new THREE.MeshLambertMaterial({ color: colour, wireframe });
    for (let n = 1; n < places.length; n++) {
      const [from, to] = [places[n - 1], places[n]];
      const length = from.distanceTo(to);
      if (length < 1e-4) continue;
      const radius = TUBE_M * (1 - (0.7 * n) / places.length) * (wireframe ? 1.1 : 1);
      const tube = new THREE.Mesh(new THREE.CapsuleGeometry(radius, length, 3, 10), material);
      tube.position.copy(from).lerp(to, 0.5);
      tube.quaternion.setFromUnitVectors(
        new THREE.Vector3(0, 1, 0),
        to.clone().sub(from).divideScalar(length),
      );
      group.add(tube);
    }
  }
}
