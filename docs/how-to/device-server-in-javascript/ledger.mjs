// What a device server must not forget: goals and epochs, a line for each change, on disk before anything else happens.
import { randomBytes } from "node:crypto";
import { fsyncSync, ftruncateSync, mkdirSync, openSync, readFileSync, writeSync } from "node:fs";

export const randomWord = () => randomBytes(8).toString("hex");

export class Ledger {
  goals = new Map(); // id -> the newest report
  marks = new Set(); // of all changes: an older copy that went another way has others
  epoch = 0;
  seq = 0;

  constructor(folder) {
    mkdirSync(folder, { recursive: true });
    this.file = openSync(`${folder}/ledger.jsonl`, "a+");
    const text = readFileSync(this.file, "utf8"), whole = text.slice(0, text.lastIndexOf("\n") + 1);
    ftruncateSync(this.file, Buffer.byteLength(whole)); // the last line may be half written
    for (const line of whole.split("\n").filter(Boolean)) this.take(JSON.parse(line));
    this.write({ ledger: this.id ?? randomWord() });
    this.seq += 1e6; // what was told of a goal under way is not on disk, and `seq` must grow
  }

  write(change) {
    const whole = { ...change, mark: `${this.id ?? change.ledger}:${randomWord()}` };
    writeSync(this.file, JSON.stringify(whole) + "\n");
    fsyncSync(this.file);
    this.take(whole);
  }

  take({ ledger = this.id, mark, epoch = this.epoch, goal }) {
    Object.assign(this, { id: ledger, mark, epoch });
    this.marks.add(mark);
    if (goal) this.goals.set(goal.id, goal), (this.seq = Math.max(this.seq, goal.seq));
  }
}
