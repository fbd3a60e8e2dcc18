// A device server for labrun in JavaScript. docs/reference/device-server.md says what each answer has to be.
//   node server.mjs FOLDER PORT [DEVICE]       LABRUN_TOKEN=... HOST=0.0.0.0 for other machines
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import Ajv from "ajv";
import { Server } from "socket.io";
import { Device } from "./device.mjs";
import { Ledger, randomWord } from "./ledger.mjs";
import { Pump } from "./pump.mjs";

const [folder, port, name = "pump"] = process.argv.slice(2);
const { HOST: host = "127.0.0.1", LABRUN_TOKEN: token } = process.env;
if (host !== "127.0.0.1" && !token) throw new Error(`${host} can be reached by others: give LABRUN_TOKEN`);
const contract = JSON.parse(readFileSync(new URL("pump.json", import.meta.url)));
const ajv = new Ajv({ strict: false });
const fits = new Map(Object.entries(contract.actions).map(([action, { params }]) => [action, ajv.compile(params)]));

const http = createServer(); // who has the port has the ledger
await new Promise((resolve, reject) => http.once("error", reject).listen(Number(port), host, resolve));
const io = new Server({
  transports: ["websocket"], pingInterval: 2000, pingTimeout: 2000, maxHttpBufferSize: 64 * 2 ** 20,
  allowRequest: (request, answer) => answer(null, request.headers.origin === undefined), // no pages of browsers
}).of("/action");
const ledger = new Ledger(folder), boot = `${ledger.id}.${randomWord()}`, pump = new Pump(`${folder}/pump.jsonl`);
const device = new Device(name, pump, contract, ledger, boot, io);
const interrupted = { name: "INTERRUPTED", message: "the device server ended during the action", happened: "unknown" };
for (const report of ledger.goals.values()) if (report.state === "EXECUTING") device.write(report, { state: "ABORTED", error: interrupted });
await pump.halt(); // an earlier server may have been killed in the middle of a dose

let lease = null, lapsed = 0, stopped = "", ends = false;
const asked = new Map(), refusals = new Map();
const refuse = (code, message, more) => { throw { code, message, ...more }; };

function endLease(why) {
  clearTimeout(lease.clock);
  lapsed = lease.epoch;
  lease = null;
  void device.makeSafe("Lost", `${name} was made safe: ${why}`);
}

function check({ epoch, action, params = {} }) {
  if (epoch !== lease?.epoch) refuse("STALE_EPOCH", `epoch ${epoch} is over`, { holder: lease?.owner });
  if (stopped) refuse("STOPPED", stopped);
  const fit = fits.get(action) ?? refuse("INVALID", `${name} has no action ${action}`);
  if (!fit(params)) refuse("INVALID", `${name}.${action}${ajv.errorsText(fit.errors, { dataVar: "" })}`);
  if (device.busy) refuse("BUSY", `${name} is busy`);
}

const requests = {
  describe: ({ mark: seen }) => ({
    boot, ledger: ledger.id, mark: ledger.mark, continues: !seen || ledger.marks.has(seen),
    devices: { [name]: { contract, driver: "Pump", limits: {}, status: pump.status(), holder: lease?.owner ?? "", stopped, stop_grace_s: 10 } },
  }),
  lease({ owner, ttl_s, epoch: renewed, ask, again }, socket) {
    if (!(ttl_s > 0 && ttl_s <= 3600)) refuse("INVALID", "ttl_s: a lease lasts for up to 3600 s");
    if (lease && lease.owner !== owner) refuse("HELD", `${name} is held by ${lease.owner}`, { holder: lease.owner });
    const known = renewed ?? asked.get(ask);
    if (known !== undefined && known !== lease?.epoch) refuse("STALE_EPOCH", `the lease under epoch ${known} is over`);
    if (known === undefined) {
      ledger.write({ epoch: ledger.epoch + 1 });
      if (ask) asked.set(ask, ledger.epoch);
      if (!again) stopped = "";
    }
    clearTimeout(lease?.clock);
    const clock = setTimeout(endLease, 1000 * ttl_s, "its lease was over");
    lease = { owner, epoch: known ?? ledger.epoch, session: socket.id, clock };
    return { epoch: lease.epoch, boot, device: name, lapsed };
  },
  release({ owner, epoch }) {
    const released = lease?.owner === owner && (epoch ?? lease.epoch) === lease.epoch;
    if (released && device.running) endLease("its lease was released");
    else if (released) clearTimeout(lease.clock), (lease = null);
    return { released };
  },
  goal(goal) {
    const known = device.report(goal.id), key = `${goal.epoch} ${goal.id}`;
    if (known) return { dup: true, mark: ledger.mark, ...known };
    if (goal.boot !== boot) refuse("STALE_BOOT", "the device server has been restarted since");
    try {
      if (refusals.has(key)) throw refusals.get(key); // a refusal is final: a late copy does not begin either
      check(goal);
    } catch (refusal) {
      refusals.set(key, refusal);
      throw refusal;
    }
    return { ...device.begin(goal), mark: ledger.mark };
  },
  cancel({ id, boot: given = boot }) {
    if (id === device.running?.report.id) device.cancel();
    else if (!device.report(id) && given !== boot) refuse("STALE_BOOT", "the device server has been restarted since");
    else if (!device.report(id)) device.write({ id }, { state: "CANCELED", error: { name: "NEVER_STARTED", message: "it had not begun", happened: "no" } });
    return { state: device.report(id).state };
  },
  query({ ids, since }) {
    const wanted = ids ?? [...ledger.goals.keys()].filter((id) => device.report(id).seq > since);
    return { boot, ledger: ledger.id, goals: Object.fromEntries(wanted.map((id) => [id, device.report(id)])) };
  },
  async stop({ timeout_s = 10, by }, socket) {
    const message = `${name} was stopped by ${by || "another client"} at ${new Date().toTimeString().slice(0, 8)}`;
    const others = lease?.session !== socket.id;
    if (others) stopped = message;
    const safe = device.makeSafe("Stopped", message); // the pump hears of it before the disk does
    if (others) io.emit("stopped", { device: name, message }), ledger.write({ epoch: ledger.epoch + 1 });
    const late = { safe: false, message: `${name} did not confirm its safe state within ${timeout_s} s` };
    const answer = await Promise.race([safe, new Promise((resolve) => setTimeout(resolve, 1000 * timeout_s, late))]);
    return { ...answer, devices: { [name]: answer } };
  },
};

io.use((socket, next) => next(token && socket.handshake.auth.token !== token ? new Error("the token is wrong") : undefined));
io.on("connection", (socket) => socket.onAny(async (event, data, answer) => {
  try {
    if (!Object.hasOwn(requests, event)) refuse("EXCEPTION", `there is no request ${event}`);
    if ((data.device ?? name) !== name) refuse("UNKNOWN_DEVICE", `there is no device ${data.device} here; there is ${name}`);
    if (["goal", "cancel"].includes(event) && !(data.id && typeof data.id === "string")) refuse("INVALID", "id must be a string");
    if (ends && ["goal", "lease"].includes(event)) refuse("ENDING", `the device server of ${name} is shutting down`);
    answer({ ok: true, ...(await requests[event](data, socket)) });
  } catch (fault) {
    if (fault.syscall) throw fault; // a disk that does not take the ledger ends this server
    answer({ ok: false, code: "EXCEPTION", message: fault.message, ...fault });
  }
}));
setInterval(() => { device.tellStatus(); if (device.running) device.tell({}); }, 1000);
for (const signal of ["SIGTERM", "SIGINT"]) process.once(signal, async () => {
  ends = true;
  io.emit("ending", { device: name });
  await device.makeSafe("Lost", `${name} was made safe: its server ended`);
  setTimeout(process.exit, 100, 0); // what was told is on its way
});
process.on("uncaughtException", async (fault) => { console.error(fault); await pump.halt(); process.exit(1); });
io.server.attach(http); // from here on it is heard
console.log(JSON.stringify({ ready: true, url: `http://${host}:${http.address().port}` }));
