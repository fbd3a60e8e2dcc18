"""Stock roslibpy: each line on stdin is `{url, steps}`; a JSON list of what came of the steps on stdout."""

import json
import queue
import sys

import roslibpy

WAIT_S = 500


def goal(ros, step):
    client = roslibpy.ActionClient(ros, step["name"], step["type"])
    heard, ended = [], queue.Queue()

    def feedback(values):
        heard.append(dict(values))
        if step.get("cancel") and len(heard) == 1:
            client.cancel_goal(id)

    id = client.send_goal(
        roslibpy.Goal(step["args"]),
        lambda result: ended.put({"status": result["status"].name, "values": result["values"]}),
        feedback,
        lambda error: ended.put({"error": error["values"]}),
    )
    return {**ended.get(timeout=WAIT_S), "feedback": heard}


def service(ros, step):
    client = roslibpy.Service(ros, step["name"], step["type"])
    answered = queue.Queue()
    client.call(
        roslibpy.ServiceRequest(step["args"]),
        lambda values: answered.put({"values": dict(values)}),
        lambda error: answered.put({"error": error}),
    )
    return answered.get(timeout=WAIT_S)


def topic(ros, step):
    heard = queue.Queue()
    listener = roslibpy.Topic(ros, step["name"], step["type"])
    listener.subscribe(heard.put)
    messages = [heard.get(timeout=WAIT_S) for _ in range(step["count"])]
    listener.unsubscribe()
    return {"messages": messages}


def look(ros, step):
    actions = queue.Queue()
    ros.get_action_servers(lambda found: actions.put(found["action_servers"]))
    return {
        "topics": ros.get_topics(),
        "services": ros.get_services(),
        "actions": actions.get(timeout=WAIT_S),
        "type": ros.get_topic_type(step["topic"]),
        "nodes": ros.get_nodes(),
        "seconds": ros.get_time().secs,
    }


def main():
    ros = None
    for line in sys.stdin:
        asked = json.loads(line)
        ros = roslibpy.Ros(asked["url"])
        ros.run(timeout=WAIT_S)
        told = [globals()[step["do"]](ros, step) for step in asked["steps"]]
        ros.close()
        print(json.dumps(told), flush=True)
    if ros is not None:
        ros.terminate()


main()
