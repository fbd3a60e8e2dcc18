// What happens on the instrument: one goal at a time, its end on disk before it is told, and the safe state.
export class Device {
  running = null;
  safing = 0; // no goal begins meanwhile

  constructor(name, instrument, contract, ledger, boot, io) {
    Object.assign(this, { name, instrument, contract, ledger, boot, io });
  }

  get busy() { return this.running !== null || this.safing > 0; }

  report = (id) => this.ledger.goals.get(id) ?? null;
  write = (report, change) => this.ledger.write({ goal: this.changed(report, change) });
  changed = (report, change) => Object.assign(report, change, { boot: this.boot, seq: ++this.ledger.seq });
  tell = (change) => this.io.emit("update", this.changed(this.running.report, change));
  tellStatus = () => this.io.emit("status", { device: this.name, ...this.instrument.status() });

  begin({ id, action, params = {}, timeout_s }) {
    const report = { id };
    this.write(report, { state: "EXECUTING" }); // before the instrument hears of it
    const begun = { ...report };
    this.running = { report, action, abort: new AbortController() };
    this.running.done = this.perform(this.running, params, timeout_s);
    return begun;
  }

  async perform(running, params, timeout_s) {
    const { report, action, abort: { signal } } = running;
    const late = { name: "Timeout", message: `${this.name}.${action} took longer than ${timeout_s} s`, happened: "unknown" };
    const clock = timeout_s && setTimeout(() => this.cancel(late), Math.min(1000 * timeout_s, 2 ** 31 - 1));
    const feedback = (progress, message) => Object.assign(report, { progress, message });
    let ending;
    try {
      ending = { state: "SUCCEEDED", result: await this.instrument[action](params, { id: report.id, signal, feedback }) };
    } catch (fault) {
      const error = fault.happened ? fault : { name: "Fault", message: String(fault), happened: "unknown" };
      ending = fault.name === "Canceled" ? { state: "CANCELED" } : { state: "ABORTED", error };
    }
    clearTimeout(clock);
    if (running.cut) ending = { ...ending, state: ending.result ? "SUCCEEDED" : "ABORTED", error: running.cut };
    this.write(report, { ...ending, progress: undefined, message: undefined });
    this.running = null;
    this.io.emit("update", report);
    this.tellStatus();
  }

  cancel(why = { name: "Canceled" }) {
    if (!this.contract.actions[this.running.action].cancel) return;
    this.running.abort.abort(why);
    this.tell({ state: "CANCELING" });
  }

  async makeSafe(name, message) {
    this.safing += 1;
    const running = this.running;
    if (running) running.abort.abort((running.cut ??= { name, message, happened: "unknown" }));
    try {
      await this.instrument.halt();
      await running?.done; // its last act may have undone the halt
      await this.instrument.halt();
      return { safe: true, message: `${this.name} is in its safe state` };
    } catch (fault) {
      return { safe: false, message: `${this.name} may not be safe: ${fault.message}` };
    } finally {
      this.safing -= 1;
      this.tellStatus();
    }
  }
}
