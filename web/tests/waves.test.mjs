// SPDX-License-Identifier: Apache-2.0
// What is told of waveforms, without a browser: node --test.

import assert from "node:assert/strict";
import { test } from "node:test";

import { duration, Net, tickStep, Waves } from "../wave_data.js";

const net = (more, clocks, values) =>
  new Net({ name: "n", width: 8, form: "hex", curve: false, names: {}, ...more }, { clocks,
    values });

test("a net has the value of its last change, and changes are found both ways", () => {
  const one = net({}, [100, 200, 300], [1, 2, 3]);
  assert.deepEqual([99, 100, 199, 200, 299, 300, 999].map((c) => one.at(c)), [1, 1, 1, 2, 2, 3, 3]);
  assert.deepEqual([100, 199, 200, 299, 300].map((c) => one.next(c, true)), [200, 200, 300, 300,
    null]);
  assert.deepEqual([100, 200, 201, 300, 999].map((c) => one.next(c, false)), [null, null, 200, 200,
    300]);
  assert.equal(net({}, [100], [1]).next(500, false), null);
});

test("values are told as bits, hexadecimal, signed numbers, and by name", () => {
  assert.equal(net({ width: 12 }, [0], [0x0a]).text(0x0a), "0x00A");
  assert.equal(net({ width: 3, form: "bits" }, [0], [2]).text(2), "010");
  assert.equal(net({ width: 1, form: "bits" }, [0], [1]).text(1), "1");
  assert.deepEqual(net({ width: 16, form: "signed" }, [0, 1, 2], [0xffff, 0x8000, 0x7fff]).values, [
    -1,
    -32768,
    32767,
  ]);
  assert.deepEqual(net({ width: 16, form: "signed" }, [0], [0xabcd0001]).values, [1]); // a half of a port
  assert.deepEqual(net({ width: 32 }, [0], [0xffffffff]).values, [0xffffffff]);
  assert.equal(net({ names: { 5: "PCCSR" } }, [0], [5]).text(5), "PCCSR");
});

test("the answer's nets come to their groups in order", () => {
  const signal = (name) => ({ name, width: 1, form: "bits", curve: false, names: {} });
  const made = new Waves({ clk_hz: 8e6, from: 8, to: 16,
    groups: [{ name: "a", signals: [signal("x"), signal("y")] }, { name: "b",
      signals: [signal("z")] }],
    nets: [0, 1, 1].map((value) => ({ clocks: [8], values: [value] })) });
  assert.deepEqual(made.groups.map((g) => g.nets.map((n) => n.at(9))), [[0, 1], [1]]);
  assert.equal(made.seconds(16), 2e-6);
});

test("ticks are 1, 2 or 5 of a power of ten; differences have their unit", () => {
  const near = (a, b) => assert.ok(Math.abs(a / b - 1) < 1e-9, `${a} ${b}`);
  near(tickStep(1, 10), 0.1);
  near(tickStep(2e-3, 4), 5e-4);
  near(tickStep(3e-6, 4), 1e-6);
  for (let n = 1; n < 400; n++) {
    const count = (n * 1e-7) / tickStep(n * 1e-7, 5);
    assert.ok(count > 1.9 && count <= 5.01, `${n}: ${count}`);
  }
  assert.deepEqual([1.25e-7, -4.875e-6, 0.0015, 0].map(duration), ["125 ns", "-4.875 µs", "1.5 ms",
    "0 ns"]);
});
