// Stock roslib 2: each line on stdin is `{url, steps}`; a JSON list of what came of the steps on stdout.
import { createInterface } from "node:readline";
import * as ROSLIB from "roslib";

let ros;

const DO = {
  goal: (step) =>
    new Promise((end) => {
      const action = new ROSLIB.Action({ ros, name: step.name, actionType: step.type });
      const feedback = [];
      const id = action.sendGoal(
        step.args,
        (values) => end({ status: "SUCCEEDED", values, feedback }),
        (told) => {
          feedback.push(told);
          if (step.cancel && feedback.length === 1) action.cancelGoal(id);
          if (step.cancelAll && feedback.length === 1) action.cancelAllGoals();
        },
        (error) => end({ error, feedback }),
      );
    }),
  service: (step) =>
    new Promise((end) => {
      const service = new ROSLIB.Service({ ros, name: step.name, serviceType: step.type });
      service.callService(step.args, (values) => end({ values }), (error) => end({ error }));
    }),
  topic: (step) =>
    new Promise((end) => {
      const { name, type: messageType, compression } = step;
      const topic = new ROSLIB.Topic({ ros, name, messageType, compression });
      const messages = [];
      topic.subscribe((message) => {
        messages.push(message);
        if (messages.length === step.count) {
          topic.unsubscribe();
          end({ messages });
        }
      });
    }),
  look: async (step) => {
    const ask = (name, ...given) => new Promise((ok, no) => ros[name](...given, ok, no));
    return {
      topics: (await ask("getTopics")).topics,
      services: await ask("getServices"),
      actions: await ask("getActionServers"),
      type: await ask("getTopicType", step.topic),
      nodes: await ask("getNodes"),
      details: ros.decodeTypeDefs(await ask("getMessageDetails", step.message)),
    };
  },
};

const talk = async ({ url, steps }) => {
  ros = new ROSLIB.Ros({ url });
  await new Promise((open) => ros.on("connection", open));
  const told = [];
  for (const step of steps) told.push(await DO[step.do](step));
  // An Int64Array holds BigInts, which JSON does not know.
  console.log(JSON.stringify(told, (_, value) => (typeof value === "bigint" ? Number(value) : value)));
  ros.close();
};

let last = Promise.resolve();
createInterface({ input: process.stdin }).on("line", (line) => (last = last.then(() => talk(JSON.parse(line)))));
