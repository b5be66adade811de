// SPDX-License-Identifier: Apache-2.0
// What numbers are shown and typed in: the driver's own units, or degrees, amperes and volts.
//
// quantity: position (counts), current and code (D/A units), adc (A/D units). A number that is shown is
// the driver's times `by`; what is typed is divided by it and rounded to what the driver can have.

export const DAC_V = 10 / 2048; // ±10 V
const OWN = { position: "counts", current: "D/A units", code: "D/A units", adc: "A/D units" };

export class Units {
  physical = false;

  constructor(motors = []) {
    this.motors = motors;
  }

  /** {by, unit, digits} of a quantity of an axis. */
  scale(axis, quantity) {
    const motor = this.motors[axis];
    if (!this.physical || !motor || quantity === "adc")
      return { by: 1, unit: OWN[quantity] ?? "", digits: 0 };
    if (quantity === "position")
      return { by: 360 / (motor.counts_per_rev * motor.gear), unit: "°", digits: 3 };
    if (quantity === "current") return { by: DAC_V * motor.amp_gain, unit: "A", digits: 3 };
    return { by: DAC_V, unit: "V", digits: 3 };
  }

  /** Text and unit of a number of the driver's. */
  show(axis, quantity, value) {
    const { by, digits } = this.scale(axis, quantity);
    return (value * by).toFixed(digits);
  }
}
