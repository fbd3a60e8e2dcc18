// The stage itself, simulated: 20 mm/s along one axis. Both actions may be done again without harm.
import { setTimeout as pause } from "node:timers/promises";

export class Stage {
  x = 0;
  moving = false;

  status = () => ({ x: this.x, moving: this.moving });

  async move_to({ x }, signal) {
    this.moving = true;
    while (this.moving && Math.abs(x - this.x) > 0.1 && !signal.aborted) {
      this.x += 0.5 * Math.sign(x - this.x);
      await pause(25);
    }
    if (this.moving && !signal.aborted) this.x = x;
    this.moving = false;
    signal.throwIfAborted();
    return { x: this.x };
  }

  async halt() {
    this.moving = false;
    return {};
  }
}
