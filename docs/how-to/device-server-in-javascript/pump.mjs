// The pump itself, simulated. It has a field for a comment, as many instruments do: the goal's id goes there, and is
// read back by `last_dose`. `memory` is what it knows when its server has died; a real one keeps that itself.
import { appendFileSync, existsSync, readFileSync } from "node:fs";
import { setTimeout as pause } from "node:timers/promises";

export class Pump {
  constructor(memory) {
    this.memory = memory;
    this.flowing = false;
    this.dosed = 0;
  }

  status = () => ({ flowing: this.flowing, dosed: this.dosed });

  async dose({ volume, rate = 1 }, goal) {
    this.note(goal, "dose", { volume });
    this.flowing = true;
    const began = Date.now(), lasts = (1000 * volume) / rate;
    while (this.flowing && !goal.signal.aborted && Date.now() - began < lasts) {
      goal.feedback((Date.now() - began) / lasts, "dosing");
      await pause(20);
    }
    const whole = this.flowing && !goal.signal.aborted;
    this.flowing = false;
    const given = whole ? volume : Math.min(volume, ((Date.now() - began) * rate) / 1000);
    this.dosed += given;
    goal.signal.throwIfAborted();
    return { volume: given };
  }

  async last_dose(params, goal) {
    this.note(goal, "last_dose");
    const last = this.notes().findLast((note) => note.action === "dose");
    return last === undefined ? { goal_id: null } : { goal_id: last.goal, volume: last.volume };
  }

  async halt(params, goal) {
    if (goal !== undefined) this.note(goal, "halt"); // without a goal it is the server's way into the safe state
    this.flowing = false;
    return {};
  }

  note = (goal, action, more = {}) => appendFileSync(this.memory, JSON.stringify({ goal: goal.id, action, ...more }) + "\n");
  notes = () => (existsSync(this.memory) ? readFileSync(this.memory, "utf8").trim().split("\n").map((line) => JSON.parse(line)) : []);
}
