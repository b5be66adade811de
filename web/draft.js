// SPDX-License-Identifier: Apache-2.0
// Controls that show what the driver has. What a person does to one is a draft until the driver has
// taken it, or refused it; then it shows again what the driver has.

/** Drafts of one panel, whose changes come one after another. refused(error) tells people; render()
 * is called when a draft ends. */
export class Drafts {
  #open = new Map(); // control -> how often it was changed and not yet settled
  #turn = Promise.resolve();

  constructor(refused, render) {
    this.refused = refused;
    this.render = render;
  }

  /** The end of the last change that was asked for. */
  get settled() {
    return this.#turn;
  }

  /** take(value) promises that the driver has it; of several by a slider that is dragged, the last.
   * Returns the control. */
  watch(control, take) {
    const isText = control.type === "text" || control.type === "number";
    const value = () => (control.type === "checkbox" ? control.checked : control.value);
    if (isText) {
      control.addEventListener("input", () => this.#mark(control, true));
      control.addEventListener("blur", () => this.#leave(control));
    }
    control.addEventListener("keydown", ({ key }) => key === "Escape" && this.drop(control));
    control.addEventListener(control.type === "range" ? "input" : "change", () => {
      const wanted = value();
      const slides = control.type === "range";
      this.#open.set(control, (this.#open.get(control) ?? 0) + 1);
      control.classList.add("draft");
      this.#turn = this.#turn.then(async () => {
        try {
          if (!slides || value() === wanted) await take(wanted);
        } catch (error) {
          this.refused(error);
        }
        this.#settle(control);
      });
    });
    return control;
  }

  #mark(control, on) {
    control.classList.toggle("draft", on);
    control.dataset.typed = on ? "1" : "";
  }

  /** Left without a change that was asked for. */
  #leave(control) {
    if (!this.#open.has(control)) this.drop(control);
  }

  #settle(control) {
    const left = this.#open.get(control) - 1;
    if (left > 0) this.#open.set(control, left);
    else this.#open.delete(control);
    if (left <= 0) this.drop(control);
  }

  drop(control) {
    this.#mark(control, false);
    this.render();
  }

  /** Shows what the driver has, unless somebody is about to change it. */
  show(control, value) {
    if (this.#open.has(control) || control.dataset.typed) return;
    if (control.type === "checkbox") control.checked = value;
    else if (control.value !== String(value)) control.value = String(value);
  }
}
