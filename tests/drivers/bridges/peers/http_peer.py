"""A shaker with an HTTP interface, in a process of its own; what it does is in FOLDER/done.jsonl."""

import asyncio
import json
import sys
from pathlib import Path

from aiohttp import web

folder, habits = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text("utf-8"))
jobs, tokens, left = {}, [], {}
state = {"speed": 0, "count": 0, "busy": False}


def done(what, **more):
    with (folder / "done.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"done": what, **more}) + "\n")


async def get_state(request):
    return web.json_response({"data": {**state, "list": [1, 2]}, "speed": f"{state['speed']} rpm"})


async def set_speed(request):
    speed = (await request.json())["speed"]
    if speed > 1000:
        return web.Response(status=422, text="too fast")
    state["speed"] = speed
    done("speed", to=speed)
    return web.Response(status=204)


async def shake(request):
    if state["busy"]:
        return web.Response(status=423, text="locked")
    given = await request.json()
    state["busy"] = True
    asyncio.get_running_loop().create_task(work(given))
    return web.json_response({"accepted": True}, status=202)


async def work(given):
    await asyncio.sleep(habits.get("work_s", 0.2))
    if state["busy"]:
        state["count"] += 1
        done("dispense", given=given["goal"])
    state["busy"] = False


async def post_job(request):
    """It has a number, by which it is asked for; `fails`: then it says so with status 200."""
    number = len(jobs) + 1
    jobs[number] = [0, (await request.json()).get("fails", False)]
    done("job", number=number)
    place = {"Location": f"/api/moved/{number}"}
    return web.json_response({"job": {"id": number}}, status=201, headers=place)


async def moved(request):
    raise web.HTTPSeeOther(f"/api/jobs/{request.match_info['number']}")


async def get_job(request):
    number = int(request.match_info["number"])
    if number not in jobs:
        return web.json_response(
            {"error": {"code": "NO_JOB", "message": "no such job"}}, status=404
        )
    jobs[number][0] += 1
    if jobs[number][1]:
        return web.json_response({"status": "error", "message": "the lid is open"})
    return web.json_response({"state": "done" if jobs[number][0] > 2 else "running"})


async def odd(request):
    """What a path says, as an answer."""
    return web.Response(text=request.match_info["text"])


async def enter(request):
    """A form, and who sends it."""
    form, who = await request.post(), request.headers.get("Authorization", "")
    return web.json_response({"form": dict(form), "who": who})


async def log_in(request):
    if (await request.json()).get("password") != "secret":
        return web.json_response({"error": "wrong password"}, status=403)
    tokens.append(f"T{len(tokens) + 1}")
    left[tokens[-1]] = 2
    return web.json_response({"data": {"token": tokens[-1]}})


async def guarded(request):
    """A token is good for two doses."""
    token = request.headers.get("Authorization", "").removeprefix("Bearer ")
    if left.get(token, 0) < 1:
        return web.json_response({"error": "token expired"}, status=401)
    left[token] -= 1
    done("guarded", token=token)
    return web.Response()


async def stop(request):
    state["busy"] = False
    done("stop")
    return web.Response()


async def broken(request):
    return web.Response(status=500, text="broken")


async def main():
    app = web.Application()
    app.router.add_get("/api/state", get_state)
    app.router.add_put("/api/speed", set_speed)
    app.router.add_post("/api/shake", shake)
    app.router.add_post("/api/stop", stop)
    app.router.add_get("/api/broken", broken)
    app.router.add_post("/api/enter", enter)
    app.router.add_post("/api/login", log_in)
    app.router.add_post("/api/guarded", guarded)
    app.router.add_post("/api/jobs", post_job)
    app.router.add_get("/api/jobs/{number}", get_job)
    app.router.add_get("/api/moved/{number}", moved)
    app.router.add_get("/api/odd/{text:.*}", odd)
    runner = web.AppRunner(app)
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", 0)
    await site.start()
    done("on")
    (folder / "where.part").write_text(
        f"http://127.0.0.1:{site._server.sockets[0].getsockname()[1]}/api"
    )
    (folder / "where.part").replace(folder / "where")
    await asyncio.Event().wait()


asyncio.run(main())
