// SPDX-License-Identifier: Apache-2.0
// The arm from the robot file's own Denavit-Hartenberg numbers: where the encoders say it is (solid, the
// chosen joint lit), and where it is told to be (dashed). A joint in Pos is dragged by hand: its setpoint
// follows. A machine without links is drawn as its motors' dials.
//
// Drawn on a plain canvas: a picture costs a millisecond, and none is drawn while nothing moves.

import { colour, el } from "./dom.js";

const TUBE_M = 0.05;
const FLOOR_M = -0.67; // a PUMA's shoulder stands so high above it
const MIDDLE_M = 0.15; // what the eye looks at
const MOST_ABOVE = 1.5;
const HAND = [[0, 0.09], [0.04, 0.09], [0.04, 0.15], [0.04, 0.09], [-0.04, 0.09], [-0.04, 0.15]]; // x, z
const NEAR_PX = 14; // of a link's line, where it is taken by hand
const WITHIN = 0.85; // of half the picture: the rest is for the thickness of tubes
const STOPS_M = 0.16; // radius of the sector from stop to stop
const STOPS = 24; // chords of it
const BY_PX = Math.PI / 400; // rad that a joint turns for a pixel

const multiply = (a, b) =>
  Array.from({ length: 12 }, (_, n) => {
    const [row, column] = [n >> 2, n & 3];
    const sum = [0, 1, 2].reduce((s, k) => s + a[4 * row + k] * b[4 * k + column], 0);
    return sum + (column === 3 ? a[4 * row + 3] : 0);
  });

/** Positions of the joints' frames, m: the base, then two per link (its bend, its end), then the hand's.
 * angles: rad. */
export function frames(links, angles) {
  let at = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
  const places = [[0, 0, 0]];
  links.forEach(({ alpha, a, d, theta0 }, n) => {
    const [ct, st] = [Math.cos(theta0 + angles[n]), Math.sin(theta0 + angles[n])];
    const [ca, sa] = [Math.cos(alpha), Math.sin(alpha)];
    places.push([0, 4, 8].map(row => at[row + 2] * d + at[row + 3]));
    at = multiply(at, [ct, -st * ca, st * sa, a * ct, st, ct * ca, -ct * sa, a * st, 0, sa, ca, d]);
    places.push([at[3], at[7], at[11]]);
  });
  const ofHand = ([x, z]) => [0, 4, 8].map(row => at[row] * x + at[row + 2] * z + at[row + 3]);
  return [...places, ...HAND.map(ofHand)];
}

/** The sector in which a joint may turn, m: its centre, then an arc from stop to stop about its axis, then
 * where it stands; none without stops. angles: rad. */
export function sector(links, angles, joint, { stop_lo: low, stop_hi: high }) {
  const at = (angle, a) =>
    frames([...links.slice(0, joint), { ...links[joint], a, alpha: 0 }], [...angles.slice(0, joint),
      angle])[2 * joint + 2];
  const arc = Array.from({ length: STOPS + 1 },
    (_, k) => at(low + ((high - low) * k) / STOPS, STOPS_M));
  return low < high ? [at(0, 0), ...arc, at(angles[joint], STOPS_M)] : [];
}

/** Joint angle, rad, of a count. The counter is 0 where the joint stood at power-on. */
function jointAngle(motor, count) {
  return motor.angle0 + (2 * Math.PI * count) / (motor.counts_per_rev * motor.gear);
}

export class Arm {
  #drawn = "";
  seen = []; // {joint, from, to}: links on the screen
  #dragged = null; // {joint, x, setpoint}
  #pen = null;

  constructor(page) {
    this.page = page;
    this.motors = page.about.motors;
    this.links = page.about.links;
    this.canvas = el("canvas", {});
    this.element = el("div", { className: "arm own-keys", tabIndex: 0, role: "img",
      "aria-label": "the arm; arrow keys turn the view" }, this.canvas);
    this.turn = page.turn;
    this.#listen();
  }

  #listen() {
    const move = (around, above) => {
      this.turn.around += around;
      this.turn.above = Math.max(-MOST_ABOVE, Math.min(MOST_ABOVE, this.turn.above + above));
      this.draw();
    };
    this.element.addEventListener("pointerdown", ({ offsetX, offsetY, pointerId }) => {
      this.element.setPointerCapture(pointerId);
      const joint = this.#at(offsetX, offsetY);
      const axis = this.page.axes[joint];
      if (axis) this.page.choose(joint);
      this.#dragged = axis?.param ? { joint, x: offsetX, setpoint: axis.setpoint } : null;
    });
    this.element.addEventListener("pointermove", event => {
      if (!event.buttons) return;
      if (this.#dragged) this.#drag(event.offsetX);
      else move(-event.movementX / 150, event.movementY / 150);
    });
    this.element.addEventListener("wheel", event => {
      event.preventDefault();
      this.turn.away = Math.max(0.8, Math.min(6, this.turn.away * Math.exp(event.deltaY / 800)));
      this.draw();
    });
    this.element.addEventListener("keydown", event => {
      const by =
        { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1],
          ArrowDown: [0, -0.1] }[event.key];
      if (by) event.preventDefault();
      if (by) move(...by);
    });
  }

  /** The joint whose link is under a point of the screen; undefined: none. */
  #at(x, y) {
    const far = ({ from, to }) => {
      const [u, v] = [to.x - from.x, to.y - from.y];
      const part = Math.max(0,
        Math.min(1, ((x - from.x) * u + (y - from.y) * v) / (u * u + v * v || 1)));
      return Math.hypot(from.x + part * u - x, from.y + part * v - y);
    };
    const [near] = this.seen.map(one => ({ ...one, px: far(one) })).sort((a, b) => a.px - b.px);
    return near?.px < NEAR_PX ? near.joint : undefined;
  }

  #drag(x) {
    const { page, motors } = this;
    const { joint, x: began, setpoint } = this.#dragged;
    const axis = page.axes[joint];
    if (!page.mayChange) return undefined;
    if (axis.mode !== "pos") {
      this.#dragged = null;
      return page.machine.say("help", `axis ${joint}: a joint follows the hand in Pos`);
    }
    const { counts_per_rev, gear } = motors[joint];
    const counts = ((x - began) * BY_PX * counts_per_rev * Math.abs(gear)) / (2 * Math.PI);
    const take = value => axis.setSetpoint(value);
    return page.drafts.take("arm", setpoint + Math.round(counts), take, true);
  }

  /** The picture of the moment shown, if it differs from the one that is there. */
  draw() {
    const { motors, canvas } = this;
    const { machine: { history }, row, axis } = this.page;
    if (row < 0) return;
    const counts = field => motors.map((_, n) => history.value(row, history.column(n, field)));
    const [now, told] = [counts("encnow"), counts("demand")];
    const { clientWidth: width, clientHeight: height } = canvas;
    const key = [now, told, width, height, Object.values(this.turn), axis, colour("--ink")].join();
    if (key === this.#drawn || !width) return;
    this.#drawn = key;
    const sharp = Math.min(2, devicePixelRatio);
    if (canvas.width !== width * sharp) canvas.width = width * sharp;
    if (canvas.height !== height * sharp) canvas.height = height * sharp;
    this.#pen = canvas.getContext("2d", { willReadFrequently: true });
    this.#pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    this.#pen.clearRect(0, 0, width, height);
    this.#pen.lineCap = this.#pen.lineJoin = "round";
    const angles = values => motors.map((m, n) => jointAngle(m, values[n]));
    if (this.links.length) this.#arm(width, height, angles(now), angles(told));
    else this.#dials(width, height, angles(now), angles(told));
  }

  /** A line through places of the picture, px. */
  #line(points, name, thick, dash = []) {
    const pen = this.#pen;
    pen.strokeStyle = colour(name);
    pen.lineWidth = thick;
    pen.setLineDash(dash);
    pen.beginPath();
    points.forEach(([x, y]) => pen.lineTo(x, y));
    pen.stroke();
  }

  #disc(x, y, r, name) {
    const pen = this.#pen;
    pen.fillStyle = colour(name);
    pen.beginPath();
    pen.arc(x, y, r, 0, 2 * Math.PI);
    pen.fill();
  }

  /** How a place, m, is seen; `places` are never cut off. */
  #eye(width, height, places) {
    const { around, above, away } = this.turn;
    const [ca, sa, ce, se] = [Math.cos(around), Math.sin(around), Math.cos(above), Math.sin(above)];
    let zoom = Math.min(width, height) * 1.3;
    const see = (/** @type {number[]} */ [x, y, z]) => {
      const [right, ahead] = [-sa * x + ca * y, ca * x + sa * y];
      const depth = away - (ce * ahead + se * (z - MIDDLE_M));
      const up = ce * (z - MIDDLE_M) - se * ahead;
      const scale = zoom / Math.max(0.2, depth);
      return { x: width / 2 + right * scale, y: height / 2 - up * scale, scale, depth };
    };
    const out = places.map(see).map(({ x, y }) =>
      Math.max(Math.abs((2 * x) / width - 1), Math.abs((2 * y) / height - 1))
    );
    zoom *= Math.min(1, WITHIN / Math.max(...out));
    return see;
  }

  #arm(width, height, angles, told) {
    const [places, wanted] = [angles, told].map(all => frames(this.links, all));
    const see = this.#eye(width, height, [...places, ...wanted]);
    const line = (points, ...how) => this.#line(points.map(see).map(({ x, y }) => [x, y]), ...how);
    for (let at = -1; at <= 1; at += 0.25) {
      line([[at, -1, FLOOR_M], [at, 1, FLOOR_M]], "--line", 1);
      line([[-1, at, FLOOR_M], [1, at, FLOOR_M]], "--line", 1);
    }
    line(places.map(([x, y]) => [x, y, FLOOR_M]), "--shade", 9); // its shadow
    const tubes = [{ joint: -1, from: [0, 0, FLOOR_M], to: [0, 0, 0], r: TUBE_M * 1.5 }];
    for (let n = 1; n < places.length; n++) {
      const [from, to] = [places[n - 1], places[n]];
      const joint = Math.min((n - 1) >> 1, this.links.length - 1);
      if (Math.hypot(...from.map((v, k) => v - to[k])) > 1e-4)
        tubes.push({ joint, from, to, r: TUBE_M * (1.15 - (0.95 * n) / places.length) });
    }
    const onScreen = ({ joint, from, to }) => ({ joint, from: see(from), to: see(to) });
    this.seen = tubes.slice(1).map(onScreen);
    const depth = ({ from, to }) => see(from.map((v, k) => (v + to[k]) / 2)).depth;
    for (const { joint, from, to, r } of tubes.sort((a, b) => depth(b) - depth(a))) {
      const thick = 2 * r * see(from).scale;
      line([from, to], "--arm-edge", thick + 2);
      line([from, to], joint === this.page.axis ? "--told" : "--arm", thick);
      line([from, to], "--arm-light", thick * 0.3);
      const { x, y, scale } = see(to);
      this.#disc(x, y, r * 0.9 * scale, "--arm-edge");
    }
    line(wanted, "--told", 2, [5, 4]);
    const { axis } = this.page;
    const [centre, ...arc] = this.links[axis] ? sector(this.links, angles, axis, this.motors[axis])
      : [];
    if (!centre) return;
    line([centre, ...arc.slice(0, -1), centre], "--ink", 1);
    line([centre, arc.at(-1)], "--ink", 2);
  }

  #dials(width, height, angles, told) {
    const room = width / angles.length;
    const r = Math.min(room, height) * 0.38;
    angles.forEach((angle, n) => {
      const [x, y] = [room * (n + 0.5), height / 2];
      const at = (turn, far) => [x + far * r * Math.sin(turn), y - far * r * Math.cos(turn)];
      const hand = (turn, from, to, ...how) => this.#line([at(turn, from), at(turn, to)], ...how);
      this.#disc(x, y, r + 2, "--arm-edge");
      this.#disc(x, y, r - 1, "--sheet");
      for (let k = 0; k < 36; k++)
        hand((k * Math.PI) / 18, k % 9 ? 0.94 : 0.86, 1, "--arm-edge", 1);
      hand(told[n], 0, 0.92, "--told", 2, [5, 4]);
      hand(angle, 0, 0.92, n === this.page.axis ? "--c2" : "--arm", 7);
      this.#pen.fillStyle = colour("--ink");
      this.#pen.fillText(`motor ${n}`, x - 20, y + r + 14);
    });
  }
}
