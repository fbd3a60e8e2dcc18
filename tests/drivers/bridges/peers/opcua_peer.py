"""An oven as asyncua serves it, its nodes named as OPC UA LADS does; what it does is in FOLDER/done.jsonl."""

import asyncio
import json
import sys
from pathlib import Path

from asyncua import Server, ua, uamethod
from asyncua.common.structures104 import new_struct, new_struct_field

folder, habits = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text("utf-8"))
DEGREES = ua.EUInformation(
    "http://www.opcfoundation.org/UA/units/un/cefact", 4408652, ua.LocalizedText("°C")
)


def done(what, **more):
    with (folder / "done.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"done": what, **more}) + "\n")


class Writes:
    """What clients write is seen by the server's own subscription."""

    async def datachange_notification(self, node, value, data):
        done("target", to=value)


async def analog(owner, space, name, value, low, high):
    node = await owner.add_variable(space, name, value, ua.VariantType.Double)
    await node.add_property(0, "EngineeringUnits", DEGREES)
    await node.add_property(0, "EURange", ua.Range(low, high))
    return node


async def main():
    server = Server()
    await server.init()
    server.set_endpoint("opc.tcp://127.0.0.1:0/oven")
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    space = await server.register_namespace("urn:example:oven")
    devices = await server.nodes.objects.add_object(space, "DeviceSet")
    oven = await devices.add_object(space, "Oven")
    await oven.add_property(space, "SerialNumber", "SN-7")
    functions = await (await oven.add_object(space, "FunctionalUnitSet")).add_object(
        space, "Chamber"
    )
    control = await functions.add_object(space, "TemperatureController")
    current = await analog(control, space, "CurrentValue", 21.5, -50.0, 1400.0)
    target = await analog(control, space, "TargetValue", 25.0, 0.0, 1200.0)
    await target.set_writable()
    doses = await functions.add_variable(space, "Doses", 0, ua.VariantType.UInt32)
    busy = await functions.add_variable(space, "Busy", False)
    bad = await functions.add_variable(space, "Broken", float("nan"), ua.VariantType.Float)
    del bad

    async def work(label):
        await asyncio.sleep(habits.get("work_s", 0.3))
        await doses.write_value(await doses.read_value() + 1, ua.VariantType.UInt32)
        done("dispense", given=label)
        await busy.write_value(False)

    @uamethod
    async def dose(parent, label, amount):
        if amount > 100:
            return ua.StatusCode(ua.StatusCodes.BadOutOfRange)
        if amount == 13:
            return ua.StatusCode(ua.StatusCodes.BadInternalError)
        await busy.write_value(True)
        work_on.append(asyncio.get_running_loop().create_task(work(label)))
        return int(await doses.read_value()) + 1

    work_on = []
    inputs = [
        ua.Argument("Label", ua.NodeId(ua.ObjectIds.String), -1),
        ua.Argument("Amount", ua.NodeId(ua.ObjectIds.Double), -1),
    ]
    outputs = [ua.Argument("Number", ua.NodeId(ua.ObjectIds.UInt32), -1)]
    await functions.add_method(space, "Dose", dose, inputs, outputs)
    fields = [
        new_struct_field("Mass", ua.VariantType.Double),
        new_struct_field("Note", ua.VariantType.String),
    ]
    kind, _ = await new_struct(server, space, "Weighed", fields)
    made = (await server.load_data_type_definitions())["Weighed"]
    await functions.add_variable(space, "Last", ua.Variant(made(Mass=1.5, Note="dry")))

    async def weigh(parent):
        return [
            ua.Variant(made(Mass=2.5, Note="wet")),
            ua.Variant([1.0, 2.0], ua.VariantType.Double),
        ]

    outputs = [
        ua.Argument("Result", kind.nodeid, -1),
        ua.Argument("All Masses", ua.NodeId(ua.ObjectIds.Double), 1),
    ]
    await functions.add_method(space, "Weigh", weigh, [], outputs)
    async with server:
        watching = await server.create_subscription(50, Writes())
        await watching.subscribe_data_change(target)
        await current.write_value(22.0)
        done("on")
        port = server.bserver._server.sockets[0].getsockname()[1]
        (folder / "where.part").write_text(f"opc.tcp://127.0.0.1:{port}/oven")
        (folder / "where.part").replace(folder / "where")
        await asyncio.Event().wait()


asyncio.run(main())
