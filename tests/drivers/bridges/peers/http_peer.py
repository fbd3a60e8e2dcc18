"""A shaker with an HTTP interface, in a process of its own; what it does is in FOLDER/done.jsonl."""

import asyncio
import hashlib
import json
import ssl
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
    place = {"Location": f"http://{request.host}/api/moved/{number}"}
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


async def note(request):
    """What it is sent, as it came."""
    return web.Response(text=await request.text())


async def enter(request):
    """A form, and who sends it."""
    form, given = await request.post(), request.headers
    names = {"who": "Authorization", "match": "If-Match", "key": "Idempotency-Key"}
    told = {one: given.get(name, "") for one, name in names.items()}
    return web.json_response({"form": dict(form), **told})


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


async def cookie(request):
    """A page lets in who knows the password, by a cookie that is good for two commands."""
    if (await request.post()).get("password") != "secret":
        return web.Response(text="<html>wrong</html>")
    tokens.append(f"C{len(tokens) + 1}")
    left[tokens[-1]] = 2
    answer = web.Response(text="<html>hello</html>")
    answer.set_cookie("SID", tokens[-1])
    return answer


async def command(request):
    """What is in its path and its question, for whoever has a cookie; others are led to a page."""
    token = request.cookies.get("SID", "")
    if left.get(token, 0) < 1:
        raise web.HTTPFound("/api/page")
    left[token] -= 1
    done("command", to=request.match_info["to"], **request.query)
    return web.json_response({"peaks": [{"area": 12.5}, {"area": 0.5}]})


async def page(request):
    return web.Response(text="<form>password?</form>", content_type="text/html")


async def digest(request):
    """RFC 7616 with MD5, as small servers have it."""
    given = request.headers.get("Authorization", "")
    told = {
        one.split("=", 1)[0].strip(): one.split("=", 1)[1].strip('"')
        for one in given[7:].split(", ")
        if one
    }
    parts = [told.get(name, "") for name in ("nonce", "nc", "cnonce", "qop")]
    if told.get("response") != md5(md5("ada:box:x"), *parts, md5(f"GET:{request.path}")):
        wants = 'Digest realm="box", nonce="n1", qop="auth", algorithm=MD5'
        return web.Response(status=401, headers={"WWW-Authenticate": wants})
    return web.json_response({"t": 21.5})


def md5(*parts):
    return hashlib.md5(":".join(parts).encode()).hexdigest()


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
    app.router.add_post("/api/note", note)
    app.router.add_post("/api/login", log_in)
    app.router.add_post("/api/guarded", guarded)
    app.router.add_post("/api/jobs", post_job)
    app.router.add_get("/api/jobs/{number}", get_job)
    app.router.add_get("/api/moved/{number}", moved)
    app.router.add_post("/api/cookie", cookie)
    app.router.add_get("/api/command/{to}", command)
    app.router.add_get("/api/page", page)
    app.router.add_get("/api/digest", digest)
    app.router.add_get("/api/odd/{text:.*}", odd)
    runner = web.AppRunner(app)
    await runner.setup()
    context = None
    if pair := habits.get("certificate"):
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.load_cert_chain(pair)
    site = web.TCPSite(runner, "127.0.0.1", 0, ssl_context=context)
    await site.start()
    done("on")
    (folder / "where.part").write_text(
        f"http{'s' if context else ''}://127.0.0.1:{site._server.sockets[0].getsockname()[1]}/api"
    )
    (folder / "where.part").replace(folder / "where")
    await asyncio.Event().wait()


asyncio.run(main())
