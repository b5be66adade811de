// SPDX-License-Identifier: Apache-2.0
// What people do to controls is a draft until the driver has taken it, or refused it; then the control
// shows again what the driver has. Changes come one after another.

export class Drafts {
  #drafts = new Map(); // id of a control -> {value, waiting}: how many changes are not yet settled
  #turn = Promise.resolve();

  /** refused(error) tells people; changed() draws. */
  constructor(refused, changed) {
    this.refused = refused;
    this.changed = changed;
  }

  /** The end of the last change that was asked for. */
  get settled() {
    return this.#turn;
  }

  has(id) {
    return this.#drafts.has(id);
  }

  /** What a control shows while the driver has `known`. */
  value(id, known) {
    return this.#drafts.has(id) ? this.#drafts.get(id).value : known;
  }

  type(id, value) {
    this.#drafts.set(id, { waiting: this.#drafts.get(id)?.waiting ?? 0, value });
    this.changed();
  }

  /** A change that was asked for: take(value) promises that the driver has it; of several by a slider
   * that is dragged, the last. */
  take(id, value, take, slides = false) {
    this.type(id, value);
    this.#drafts.get(id).waiting++;
    this.#turn = this.#turn.then(async () => {
      try {
        if (!slides || this.value(id) === value) await take(value);
      } catch (error) {
        this.refused(error);
      }
      const draft = this.#drafts.get(id);
      if (draft && --draft.waiting <= 0) this.drop(id);
    });
  }

  /** Left without a change that was asked for. */
  leave(id) {
    if (!this.#drafts.get(id)?.waiting) this.drop(id);
  }

  drop(id) {
    if (this.#drafts.delete(id)) this.changed();
  }
}
