// Stock roslib 1.4, which knows no actions of ROS 2, sends goals by the services behind them.
// Each line on stdin is `{url, steps}`; a JSON list of what came of the steps on stdout.
const { randomBytes } = require("crypto");
const { createInterface } = require("readline");
const ROSLIB = require("roslib1");

let ros;

const call = (name, serviceType, args) =>
  new Promise((ok, no) =>
    new ROSLIB.Service({ ros, name, serviceType }).callService(new ROSLIB.ServiceRequest(args), ok, no),
  );

const DO = {
  goal: async (step) => {
    const goal_id = { uuid: [...randomBytes(16)] };
    const feedback = [];
    const topic = new ROSLIB.Topic({
      ros, name: `${step.name}/_action/feedback`, messageType: `${step.type}_FeedbackMessage`,
    });
    topic.subscribe((told) => {
      if (String(told.goal_id.uuid) !== String(goal_id.uuid)) return;
      feedback.push(told.feedback);
      if (step.cancel && feedback.length === 1)
        call(`${step.name}/_action/cancel_goal`, "action_msgs/CancelGoal", { goal_info: { goal_id } });
    });
    try {
      await call(`${step.name}/_action/send_goal`, `${step.type}_SendGoal`, { goal_id, goal: step.args });
      const { status, result } = await call(
        `${step.name}/_action/get_result`, `${step.type}_GetResult`, { goal_id },
      );
      const words = { 4: "SUCCEEDED", 5: "CANCELED", 6: "ABORTED" };
      return { status: words[status], values: result, feedback };
    } catch (error) {
      return { error, feedback };
    } finally {
      topic.unsubscribe();
    }
  },
  service: (step) => call(step.name, step.type, step.args).then((values) => ({ values }), (error) => ({ error })),
  topic: (step) =>
    new Promise((end) => {
      const { name, type: messageType, compression } = step;
      const topic = new ROSLIB.Topic({ ros, name, messageType, compression });
      const messages = [];
      topic.subscribe((message) => {
        messages.push(message);
        const asked = Object.entries(step.until ?? {}).every(([name, value]) => message[name] === value);
        if (messages.length >= step.count && asked) {
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
  console.log(JSON.stringify(told));
  ros.close();
};

let last = Promise.resolve();
createInterface({ input: process.stdin }).on("line", (line) => (last = last.then(() => talk(JSON.parse(line)))));
