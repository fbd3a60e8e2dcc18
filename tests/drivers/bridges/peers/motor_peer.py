"""A soft IOC with a motor record, as caproto serves it: `python motor_peer.py FOLDER HABITS.json`.

A move takes `work_s`; where it has come to is in FOLDER/done.jsonl. Its port is EPICS_CA_SERVER_PORT.
"""

import json
import os
import sys
from pathlib import Path

from caproto.server import PVGroup, pvproperty, run

folder, habits = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text("utf-8"))
LOOK_S = 0.01


def done(what, **more):
    with (folder / "done.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"done": what, **more}) + "\n")


class Stage(PVGroup):
    """One axis of 0 to 100 mm."""

    axis = pvproperty(value=0.0, name="m1", record="motor", precision=3, units="mm")

    @axis.startup
    async def axis(self, instance, async_lib):
        fields, asked = instance.field_inst, []

        async def wanted(_, value):
            asked.append(value)

        fields.value_write_hook = wanted
        await fields.user_low_limit.write(0.0)
        await fields.user_high_limit.write(100.0)
        await fields.engineering_units.write("mm")
        await fields.done_moving_to_value.write(1)
        while True:
            if not asked:
                await async_lib.library.sleep(LOOK_S)
                continue
            to = asked.pop(0)
            await fields.done_moving_to_value.write(0)
            await fields.motor_is_moving.write(1)
            await async_lib.library.sleep(habits.get("work_s", 0.1))
            await fields.user_readback_value.write(to)
            done("move", to=to)
            await fields.motor_is_moving.write(0)
            await fields.done_moving_to_value.write(1)


done("on")
(folder / "where.part").write_text(f"127.0.0.1:{os.environ['EPICS_CA_SERVER_PORT']}")
(folder / "where.part").replace(folder / "where")
run(Stage(prefix="bench:").pvdb, interfaces=["127.0.0.1"], log_pv_names=False)
