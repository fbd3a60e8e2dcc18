// A device server for labrun in JavaScript. docs/reference/device-server.md says what each answer has to be.
//   node server.mjs FOLDER PORT [DEVICE]       LABRUN_TOKEN=... HOST=0.0.0.0 for other machines
import { createHash, randomBytes } from "node:crypto";
import { fsyncSync, ftruncateSync, mkdirSync, openSync, readFileSync, writeSync } from "node:fs";
import { createServer } from "node:http";
import Ajv from "ajv";
import { Server } from "socket.io";
import { Pump } from "./pump.mjs";

const [folder, port, name = "pump"] = process.argv.slice(2);
const { HOST: host = "127.0.0.1", LABRUN_TOKEN: token } = process.env;
if (host !== "127.0.0.1" && !token) throw new Error(`${host} can be reached by others: give LABRUN_TOKEN`);
const contract = JSON.parse(readFileSync(new URL("pump.json", import.meta.url), "utf8"));
const ajv = new Ajv({ strict: false });
const rules = Object.entries(contract.actions).map(([action, { params, returns }]) => [action, [ajv.compile(params), ajv.compile(returns)]]);
const schemas = new Map(rules);

// Nobody else may write the ledger: whoever has the port has it.
const http = createServer();
await new Promise((resolve, reject) => http.once("error", reject).listen(Number(port), host, resolve));

// The ledger: a line for each change, on disk before anything else happens. A fault of the disk ends the server.
mkdirSync(folder, { recursive: true });
const file = openSync(`${folder}/ledger.jsonl`, "a+");
const text = readFileSync(file, "utf8"), whole = text.slice(0, text.lastIndexOf("\n") + 1);
ftruncateSync(file, Buffer.byteLength(whole)); // the last line may be half written
const goals = new Map(), marks = [];
let ledger = "", epoch = 0, seq = 0;
const take = (line) => {
  marks.push(createHash("sha256").update((marks.at(-1) ?? "") + line).digest("hex"));
  const change = JSON.parse(line);
  ({ ledger = ledger, epoch = epoch } = change);
  if (change.goal) goals.set(change.goal.id, change.goal), (seq = Math.max(seq, change.goal.seq));
};
const write = (change) => {
  const line = JSON.stringify(change);
  writeSync(file, line + "\n");
  fsyncSync(file);
  take(line);
};
whole.split("\n").filter(Boolean).forEach(take);
if (!ledger) write({ ledger: randomBytes(8).toString("hex") });
const boot = `${ledger}.${randomBytes(8).toString("hex")}`;
write({ boot });
const mark = () => `${ledger}:${marks.length}:${marks.at(-1)}`;
const has = (given) => given.split(":")[0] === ledger && marks[given.split(":")[1] - 1] === given.split(":")[2];
const over = (report, state, more = {}) => write({ goal: { ...report, state, boot, seq: ++seq, ...more } });
const interrupted = { name: "INTERRUPTED", message: "the device server ended during the action", happened: "unknown" };
const neverStarted = { name: "NEVER_STARTED", message: "it ended before it began", happened: "no" };
for (const report of [...goals.values()]) if (report.state === "EXECUTING") over(report, "ABORTED", { error: interrupted });

const pump = new Pump(`${folder}/pump.jsonl`);
const io = new Server(http, {
  transports: ["websocket"], pingInterval: 2000, pingTimeout: 2000, maxHttpBufferSize: 64 * 2 ** 20,
  allowRequest: (request, answer) => answer(null, request.headers.origin === undefined), // no pages of browsers
}).of("/action");
let lease = null, lapsed = 0, running = null, stopped = "", safing = 0, ends = false;
const asked = new Map(), refusals = new Map();

const refuse = (code, message, more = {}) => { throw { code, message, ...more }; };
const tellStatus = () => io.emit("status", { device: name, ...pump.status() });
const tell = () => { running.report.seq = ++seq; io.emit("update", running.report); };

async function makeSafe(error, message) {
  safing += 1; // no goal begins meanwhile
  try {
    if (running) running.cut ??= { name: error, message, happened: "unknown" };
    await pump.halt();
    await running?.done; // its last act may have undone the halt
    await pump.halt();
    return [true, `${name} is in its safe state`];
  } catch (fault) {
    return [false, `${name} may not be safe: ${fault.message}`];
  } finally {
    safing -= 1;
    tellStatus();
  }
}

function end(message) {
  clearTimeout(lease.clock);
  lapsed = lease.epoch;
  lease = null;
  void makeSafe("Lost", `${name} was made safe: ${message}`);
}

function cancel(why) {
  if (!contract.actions[running.goal.action].cancel) return;
  running.why ??= why;
  running.report.state = "CANCELING";
  tell();
  void pump.cancel();
}

async function perform(goal, report) {
  const { id, action, params = {}, timeout_s } = goal;
  const deadline = timeout_s === undefined ? 0 : setTimeout(cancel, Math.min(1000 * timeout_s, 2 ** 31 - 1), "Timeout");
  const feedback = (progress, message) => Object.assign(report, { progress, message });
  let ending;
  try {
    const result = await pump[action]({ id, feedback }, params), fits = schemas.get(action)[1];
    if (!fits(result)) throw new Error(`${name}.${action} answered ${ajv.errorsText(fits.errors)}`);
    ending = ["SUCCEEDED", { result }];
  } catch (fault) {
    const { name: error = "Fault", message = String(fault), happened } = fault;
    const known = contract.actions[action].errors?.[error];
    ending = fault.canceled ? ["CANCELED", {}] : ["ABORTED", { error: { name: known ? error : "Fault", message, happened: happened ?? known?.happened ?? "unknown" } }];
  }
  clearTimeout(deadline);
  if (ending[0] === "CANCELED" && running.why === "Timeout") ending = ["ABORTED", { error: { name: "Timeout", message: `${name}.${action} took longer than ${timeout_s} s`, happened: "unknown" } }];
  if (running.cut) ending = [ending[0] === "CANCELED" ? "ABORTED" : ending[0], { ...ending[1], error: running.cut }];
  over({ id }, ...ending); // on disk, then told
  running = null;
  io.emit("update", goals.get(id));
  tellStatus();
}

const requests = {
  describe: ({ mark: seen }) => ({
    boot, ledger, mark: mark(), continues: !seen || has(seen),
    devices: { [name]: { contract, driver: "Pump", limits: {}, status: pump.status(), holder: lease?.owner ?? "", stopped, stop_grace_s: 10 } },
  }),
  lease({ owner, ttl_s, epoch: renewed, ask, again }, socket) {
    if (ends) refuse("ENDING", `the device server of ${name} is shutting down`);
    if (!(ttl_s > 0 && ttl_s <= 3600)) refuse("INVALID", "ttl_s: a lease lasts for up to 3600 s");
    if (lease && lease.owner !== owner) refuse("HELD", `${name} is held by ${lease.owner}`, { holder: lease.owner });
    const known = renewed ?? asked.get(ask);
    if (known !== undefined && known !== lease?.epoch) refuse("STALE_EPOCH", `the lease under epoch ${known} is over`);
    if (known === undefined) {
      write({ epoch: epoch + 1 });
      if (ask) asked.set(ask, epoch);
      if (!again) stopped = "";
    }
    clearTimeout(lease?.clock);
    lease = { owner, epoch: known ?? epoch, session: socket.id, clock: setTimeout(end, 1000 * ttl_s, "its lease was over") };
    return { epoch: lease.epoch, boot, device: name, lapsed };
  },
  release({ owner, epoch: given }) {
    const released = lease?.owner === owner && (given ?? lease.epoch) === lease.epoch;
    if (released && running) end("its lease was released");
    else if (released) clearTimeout(lease.clock), (lease = null);
    return { released };
  },
  goal(goal) {
    const { id, action, params = {}, epoch: sent } = goal, known = id === running?.goal.id ? running.report : goals.get(id);
    if (known) return { dup: true, mark: mark(), ...known };
    if (ends) refuse("ENDING", `the device server of ${name} is shutting down`);
    if (goal.boot !== boot) refuse("STALE_BOOT", "the device server has been restarted since");
    const before = refusals.get(`${sent} ${id}`); // a refusal is final: a late copy does not begin either
    if (before) throw before;
    try {
      if (!lease || sent !== lease.epoch) refuse("STALE_EPOCH", `epoch ${sent} is over`, lease ? { holder: lease.owner } : {});
      if (stopped) refuse("STOPPED", stopped);
      if (!schemas.has(action)) refuse("INVALID", `${name} has no action ${action}`);
      const [fits] = schemas.get(action);
      if (!fits(params)) refuse("INVALID", `${name}.${action}${ajv.errorsText(fits.errors, { dataVar: "" })}`);
      if (running || safing) refuse("BUSY", `${name} is busy`);
    } catch (refusal) {
      refusals.set(`${sent} ${id}`, refusal);
      throw refusal;
    }
    const report = { id, state: "EXECUTING", seq: ++seq, boot };
    write({ goal: report }); // before the pump hears of it
    running = { goal, report: { ...report } };
    running.done = perform(goal, running.report);
    return { ...report, mark: mark() };
  },
  cancel({ id, boot: given = boot }) {
    if (id === running?.goal.id) cancel("asked for");
    else if (!goals.has(id) && given !== boot) refuse("STALE_BOOT", "the device server has been restarted since");
    else if (!goals.has(id)) over({ id }, "CANCELED", { error: neverStarted }); // it can never start
    return { state: (id === running?.goal.id ? running.report : goals.get(id)).state };
  },
  query({ ids, since }) {
    const wanted = ids ?? [...goals.values()].filter((report) => report.seq > since).map((report) => report.id);
    const newest = (id) => (id === running?.goal.id ? running.report : goals.get(id) ?? null);
    return { boot, ledger, goals: Object.fromEntries(wanted.map((id) => [id, newest(id)])) };
  },
  async stop({ timeout_s = 10, by }, socket) {
    const message = `${name} was stopped by ${by || "another client"} at ${new Date().toTimeString().slice(0, 8)}`;
    const others = lease?.session !== socket.id;
    if (others) stopped = message;
    const safe = makeSafe("Stopped", message); // the pump hears of it before the disk does
    if (others) io.emit("stopped", { device: name, message }), write({ epoch: epoch + 1 });
    const late = new Promise((resolve) => setTimeout(resolve, 1000 * timeout_s, [false, `${name} did not confirm its safe state within ${timeout_s} s`]));
    const [done, words] = await Promise.race([safe, late]);
    return { safe: done, message: words, devices: { [name]: { safe: done, message: words } } };
  },
};

io.use((socket, next) => next(token && socket.handshake.auth.token !== token ? new Error("the token is wrong or missing") : undefined));
io.on("connection", (socket) => socket.onAny(async (event, ...given) => {
  const answer = given.pop(), data = given[0] ?? {};
  try {
    if (!Object.hasOwn(requests, event)) refuse("EXCEPTION", `there is no request ${event}`);
    if (data.device !== undefined && data.device !== name) refuse("UNKNOWN_DEVICE", `there is no device ${data.device} here; there is ${name}`);
    if (["goal", "cancel"].includes(event) && !(typeof data.id === "string" && data.id)) refuse("INVALID", "id must be a string");
    answer({ ok: true, ...(await requests[event](data, socket)) });
  } catch (fault) {
    if (fault.syscall) throw fault; // a disk that does not take the ledger ends this server
    answer({ ok: false, code: fault.code ?? "EXCEPTION", ...fault, message: fault.message });
  }
}));
setInterval(() => { tellStatus(); if (running) tell(); }, 1000);
for (const signal of ["SIGTERM", "SIGINT"]) process.once(signal, async () => {
  ends = true;
  io.emit("ending", { device: name });
  await makeSafe("Lost", `${name} was made safe: its server ended`);
  setTimeout(process.exit, 100, 0); // what was told is on its way
});
process.on("uncaughtException", async (fault) => { console.error(fault); await pump.halt(); process.exit(1); });
await pump.halt(); // an earlier server may have been killed in the middle of a dose
console.log(JSON.stringify({ ready: true, url: `http://${host}:${http.address().port}` }));
