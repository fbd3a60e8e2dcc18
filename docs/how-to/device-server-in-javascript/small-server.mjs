// A device server for labrun in a hundred lines, for an instrument whose actions may all be done again: it remembers nothing when
// it ends. Where an action must never happen twice, take server.mjs, which has a ledger. The instrument is in stage.mjs.
//   node small-server.mjs PORT                LABRUN_TOKEN=... HOST=0.0.0.0 for other machines
import { randomUUID } from "node:crypto";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import Ajv from "ajv";
import { Server } from "socket.io";
import { Stage } from "./stage.mjs";

const name = "stage", instrument = new Stage(), contract = JSON.parse(readFileSync(new URL("stage.json", import.meta.url)));
const { HOST: host = "127.0.0.1", LABRUN_TOKEN: token } = process.env;
if (host !== "127.0.0.1" && !token) throw new Error(`${host} can be reached by others: give LABRUN_TOKEN`);
const http = createServer(), io = new Server(http, {
  transports: ["websocket"], pingInterval: 2000, pingTimeout: 2000,
  allowRequest: (request, answer) => answer(null, request.headers.origin === undefined), // no pages of browsers
}).of("/action");
const ledger = randomUUID(), boot = `${ledger}.1`, mark = `${ledger}:1:1`; // by a new one clients see that all is forgotten
const ajv = new Ajv({ strict: false }), goals = new Map(), refused = new Set();
let lease = null, lapsed = 0, epoch = Date.now(), seq = 0, running = null, safing = 0, stopped = "";

const refuse = (code, message, more) => { throw { code, message, ...more }; };
const tell = (goal, change) => io.emit("update", Object.assign(goal, change, { seq: ++seq }));
const tellStatus = () => io.emit("status", { device: name, ...instrument.status() });

async function perform(goal, params, timeout_s) {
  running = { goal, abort: new AbortController(), cut: null };
  const { abort } = running, fault = (name, message) => ({ name, message, happened: "unknown" });
  const clock = timeout_s && setTimeout(() => abort.abort(fault("Timeout", `it took longer than ${timeout_s} s`)), 1000 * timeout_s);
  const end = await instrument[goal.action](params, abort.signal).then(
    (result) => ({ state: "SUCCEEDED", result }),
    (why) => (why === "cancel" ? { state: "CANCELED" } : { state: "ABORTED", error: why.happened ? why : fault("Fault", String(why)) }));
  clearTimeout(clock);
  const { cut } = running;
  running = null;
  tell(goal, cut ? { ...end, state: end.result ? "SUCCEEDED" : "ABORTED", error: cut } : end);
}
async function makeSafe(error, message) {
  safing += 1;
  if (running) running.abort.abort((running.cut = { name: error, message, happened: "unknown" }));
  const halted = instrument.halt().then(() => true, () => false);
  while (running) await new Promise((resolve) => setTimeout(resolve, 10)); // its last act may undo the halt
  const safe = (await halted) && (await instrument.halt().then(() => true, () => false));
  safing -= 1;
  tellStatus();
  return { safe, message: `${name} ${safe ? "is" : "may not be"} in its safe state` };
}
function endLease(why) {
  clearTimeout(lease.clock);
  [lapsed, lease] = [lease.epoch, null];
  void makeSafe("Lost", `${name} was made safe: ${why}`);
}

const requests = {
  describe: ({ mark: seen }) => ({ boot, ledger, mark, continues: !seen || seen === mark,
    devices: { [name]: { contract, driver: "Stage", status: instrument.status(), holder: lease?.owner ?? "", stopped } } }),
  lease({ owner, ttl_s, epoch: renewed, ask, again }, { id }) {
    if (!(ttl_s > 0 && ttl_s <= 3600)) refuse("INVALID", "ttl_s: a lease lasts for up to 3600 s");
    if (lease && lease.owner !== owner) refuse("HELD", `${name} is held by ${lease.owner}`, { holder: lease.owner });
    const same = lease && (renewed ? renewed === lease.epoch : ask && ask === lease.ask);
    if (renewed && !same) refuse("STALE_EPOCH", `the lease under epoch ${renewed} is over`);
    clearTimeout(lease?.clock);
    if (!same && !again) stopped = "";
    if (!same) lease = { owner, ask, epoch: ++epoch };
    Object.assign(lease, { session: id, clock: setTimeout(endLease, 1000 * ttl_s, "its lease was over") });
    return { epoch: lease.epoch, boot, device: name, lapsed };
  },
  release({ owner, epoch: of = lease?.epoch }) {
    const released = lease?.owner === owner && lease.epoch === of;
    if (released) endLease("its lease was released");
    return { released };
  },
  goal({ id, boot: of, epoch: under, action, params = {}, timeout_s }) {
    if (goals.has(id)) return { dup: true, mark, ...goals.get(id) };
    const seen = refused.has(`${under} ${id}`), known = Object.hasOwn(contract.actions, action);
    refused.add(`${under} ${id}`); // until it has begun; a late copy of what was refused never begins
    if (of !== boot) refuse("STALE_BOOT", "the device server has been restarted since");
    if (under !== lease?.epoch || seen) refuse("STALE_EPOCH", `epoch ${under} is over, or it was refused`, { holder: lease?.owner });
    if (stopped) refuse("STOPPED", stopped);
    if (!known || !ajv.validate(contract.actions[action].params, params)) refuse("INVALID", `${name}.${action}${ajv.errorsText()}`);
    if (running || safing) refuse("BUSY", `${name} is busy`);
    console.error(`${id}: ${name}.${action}`);
    goals.set(id, { id, action, boot, state: "EXECUTING", seq: ++seq });
    void perform(goals.get(id), params, timeout_s);
    return { ...goals.get(id), mark };
  },
  cancel({ id, boot: of = boot }) {
    if (!goals.has(id) && of !== boot) refuse("STALE_BOOT", "the device server has been restarted since");
    if (!goals.has(id)) goals.set(id, { id, boot, seq: ++seq, state: "CANCELED", error: { name: "NEVER_STARTED", message: "it had not begun", happened: "no" } });
    if (running?.goal.id === id && contract.actions[running.goal.action].cancel) tell(running.goal, { state: "CANCELING" }), running.abort.abort("cancel");
    return { state: goals.get(id).state };
  },
  query: ({ ids, since }) => ({ boot, ledger, mark, goals: Object.fromEntries(
    (ids ?? [...goals.keys()].filter((id) => goals.get(id).seq > since)).map((id) => [id, goals.get(id) ?? null])) }),
  async stop({ by }, { id }) {
    const message = `${name} was stopped by ${by || "another client"}`;
    if (lease?.session !== id) (stopped = message), (epoch += 1), io.emit("stopped", { device: name, message });
    const safe = await makeSafe("Stopped", message);
    return { ...safe, devices: { [name]: safe } };
  },
};

io.use((socket, next) => next(token && socket.handshake.auth.token !== token ? new Error("the token is wrong") : undefined));
io.on("connection", (socket) => socket.onAny(async (event, data, answer) => {
  try {
    if (!Object.hasOwn(requests, event)) refuse("EXCEPTION", `there is no request ${event}`);
    if ((data.device ?? name) !== name) refuse("UNKNOWN_DEVICE", `there is no device ${data.device} here; there is ${name}`);
    answer({ ok: true, ...(await requests[event](data, socket)) });
  } catch (fault) {
    answer({ ok: false, code: "EXCEPTION", message: fault.message, ...fault });
  }
}));
setInterval(() => { tellStatus(); if (running) tell(running.goal, {}); }, 1000);
for (const signal of ["SIGTERM", "SIGINT"]) process.once(signal, () => makeSafe("Lost", `${name}'s server ended`).then(() => process.exit(0)));
http.listen(Number(process.argv[2] ?? 4107), host, () => console.log(JSON.stringify({ ready: true, url: `http://${host}:${http.address().port}` })));
