"""Actions may be called as what the driver itself is made of: an instrument has `open` and `abort`, too."""

import asyncio
from pathlib import Path

from labrun.drivers.contract_tests import Case
from labrun.drivers.contract_tests.session import connected, serving_in_process, settings
from labrun.drivers.find import find_driver

from .instruments import running_peer


def test_actions_named_open_close_and_status_reach_the_instrument(tmp_path):
    said = {
        name: {"query": "MEAS:VOLT:DC?", "returns": {"v": {}}}
        for name in ("open", "status", "ready")
    }

    async def story(where):
        config = {"resource": where, "actions": said}
        contract = find_driver("scpi", Path()).config_model.model_validate(config).contract("dmm@1")
        case = Case(
            driver="scpi",
            good={name: {} for name in said},
            lasting="open",
            contract=contract,
            device="dmm",
        )
        async with (
            serving_in_process(settings(case, contract, config, tmp_path)) as (_, url, _),
            connected(case, contract, url) as session,
        ):
            return [(await session.do(name)).state for name in said]

    with running_peer(tmp_path / "peer") as peer:
        assert asyncio.run(story(peer.where)) == ["SUCCEEDED"] * 3
