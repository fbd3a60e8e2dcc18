"""Methods of a new driver and of its twin, one for each action of the contract."""

from ....schemas.contract import Action, Contract
from ....schemas.good_calls import duration_s
from . import parts

SEND_FILES = """\
        sent = {name: b64encode(file.data).decode() for name, file in goal.files.items()}
        given["files"] = sent
"""
GET_FILES = """\
            result = await asking
            for name, text in result.pop("files", {}).items():
                data = b64decode(text)
                digest = sha256(data).hexdigest()
                goal.files[name] = FileContent(path=result[name], sha256=digest, data=data)
            return result
"""
NO_FILES = """\
            return await asking
"""
TAKE_FILES = """\
            for name, sent in params.pop("files", {}).items():
                data = b64decode(sent)
                digest = sha256(data).hexdigest()
                goal.files[name] = FileContent(path=params[name], sha256=digest, data=data)
"""
GIVE_FILES = """\
            made = {name: file for name, file in goal.files.items() if name in result}
            result["files"] = {name: b64encode(file.data).decode() for name, file in made.items()}
"""
FILE_METHOD = '''
    def _write(self, goal, name, path):
        """A file that travels back with the result."""
        data = b"what the instrument measured\\n"
        digest = sha256(data).hexdigest()
        goal.files[name] = FileContent(path=path, sha256=digest, data=data)
'''


def driver_action(name: str, action: Action) -> str:
    """The method of a driver: the request goes over the line."""
    given = "".join(f", {param}={param}" for param in action.param_schemas())
    return (
        f"    async def {name}({parts.signature(action)}):\n"
        f'        return await self._do(goal, "{name}"{given})\n'
    )


def twin_action(name: str, action: Action) -> str:
    """The method of a twin: it takes its time, remembers, and answers from what it remembers."""
    lines = [
        f"    async def {name}({parts.signature(action)}):",
        f'        with self.failing("{name}", goal):',
        f"            await self._take(goal, {duration_s(action):g})",
    ]
    if action.effect == "once":
        lines.append(f'            self.truth.append("{name}", goal=goal.id)')
    read, written = action.path_params()
    kept = [n for n in action.param_schemas() if n not in (*read, *written)]
    if kept:
        lines.append(f"            self._keep({', '.join(f'{n}={n}' for n in kept)})")
    for path in written:
        optional = path not in action.required()
        lines += [f"            if {path} is not None:"] if optional else []
        lines.append(f'            {"    " * optional}self._write(goal, "{path}", {path})')
    return "\n".join([*lines, *_answer(action, written), ""])


def _answer(action: Action, written: list[str]) -> list[str]:
    fields = action.returns.get("properties", {})
    if not fields:
        return ["        return {}"]
    some = any(path not in action.required() for path in written)
    lines = ["        result = {" if some else "        return {"]
    for field in fields:
        match field:
            case "goal_id":
                value = '(self.truth.entry(len(self.truth)) or {"goal": ""})["goal"]'
            case _ if field in written:
                value = field
            case _:
                value = f'self.now["{field}"]'
        lines.append(f'            "{field}": {value},')
    lines.append("        }")
    if some:
        left_out = "{name: value for name, value in result.items() if value is not None}"
        lines.append(f"        return {left_out}")
    return lines


def sent_files(contract: Contract) -> str:
    """The files sent with the valid calls of the test."""
    read = {name for action in contract.actions.values() for name in action.path_params()[0]}
    if not read:
        return ""
    files = ", ".join(f'"{name}": b"190.0,1\\n191.0,2\\n"' for name in sorted(read))
    return f"        files={{{files}}},\n"
