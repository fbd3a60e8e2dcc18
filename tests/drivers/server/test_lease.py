"""A lease has one holder, epochs that only grow, and an end."""

import asyncio

import pytest

from labrun.drivers.server.lease import Lease, Refused
from labrun.drivers.server.ledger import Ledger
from labrun.schemas.messages import LeaseRequest


def story(tmp_path, tell):
    """Run a story with a lease, and close what it used."""

    async def told():
        ledger = Ledger(tmp_path / "ledger.sqlite")
        lapsed = asyncio.Event()
        lease = Lease("arm", ledger, lambda epoch: lapsed.set())
        try:
            return await tell(lease, lapsed)
        finally:
            lease.close()
            ledger.close()

    return asyncio.run(told())


def ask(owner="run-1", ttl_s=30.0, epoch=None):
    return LeaseRequest(device="arm", owner=owner, ttl_s=ttl_s, epoch=epoch)


def test_only_the_newest_epoch_is_good(tmp_path):
    async def tell(lease, _):
        first = await lease.take(ask(), "s1")
        second = await lease.take(ask(), "s2")
        lease.check(second)
        with pytest.raises(Refused, match="epoch 1 is over, run-1 holds it now"):
            lease.check(first)
        with pytest.raises(Refused, match="under epoch 1 is over; take it again"):
            await lease.take(ask(epoch=first), "s1")
        return first, second

    assert story(tmp_path, tell) == (1, 2)


def test_a_late_copy_of_a_request_fences_nobody_and_a_new_one_does(tmp_path):
    async def tell(lease, _):
        first = ask().model_copy(update={"ask": "t1"})
        granted = await lease.take(first, "s1"), await lease.take(first, "s1")
        return granted, await lease.take(ask().model_copy(update={"ask": "t2"}), "s1")

    assert story(tmp_path, tell) == ((1, 1), 2)


def test_a_renewal_keeps_the_epoch_and_moves_the_end(tmp_path):
    async def tell(lease, lapsed):
        epoch = await lease.take(ask(ttl_s=0.1), "s1")
        renewed = await lease.take(ask(ttl_s=30.0, epoch=epoch), "s2")
        await asyncio.sleep(0.2)
        return epoch == renewed, lapsed.is_set(), lease.holder.session

    assert story(tmp_path, tell) == (True, False, "s2")


def test_a_lease_that_is_not_renewed_lapses_and_says_so(tmp_path):
    async def tell(lease, lapsed):
        epoch = await lease.take(ask(ttl_s=0.05), "s1")
        async with asyncio.timeout(500):
            await lapsed.wait()
        with pytest.raises(Refused, match="no lease on arm has epoch 1"):
            lease.check(epoch)
        return await lease.take(ask(owner="page"), "s2")

    assert story(tmp_path, tell) == 2


def test_only_the_holder_releases(tmp_path):
    async def tell(lease, _):
        epoch = await lease.take(ask(), "s1")
        wrong = await lease.release("page", None), await lease.release("run-1", epoch + 1)
        return wrong, await lease.release("run-1", epoch) == epoch, lease.holder

    assert story(tmp_path, tell) == ((None, None), True, None)


def test_a_second_take_stops_the_clock_of_the_first(tmp_path):
    async def tell(lease, _):
        await lease.take(ask(), "s1")
        first = lease.holder.timer
        await lease.take(ask(), "s1")
        return first.cancelled(), lease.holder.timer.cancelled()

    assert story(tmp_path, tell) == (True, False)
