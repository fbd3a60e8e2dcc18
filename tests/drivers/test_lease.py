"""A lease has one holder, epochs that only grow, and an end."""

import asyncio

import pytest

from labrun.drivers.lease import Lease, Refused
from labrun.drivers.ledger import Ledger
from labrun.schemas.messages import LeaseRequest


def story(tmp_path, tell):
    """Run a story with a lease, and close what it used."""

    async def told():
        ledger = Ledger(tmp_path / "ledger.sqlite")
        lapsed = asyncio.Event()
        lease = Lease("arm", ledger, lapsed.set)
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
        first = lease.take(ask(), "s1")
        second = lease.take(ask(), "s2")
        lease.check(second)
        with pytest.raises(Refused, match="epoch 1 is over, run-1 holds it now"):
            lease.check(first)
        with pytest.raises(Refused, match="under epoch 1 is over; take it again"):
            lease.take(ask(epoch=first), "s1")
        return first, second

    assert story(tmp_path, tell) == (1, 2)


def test_a_renewal_keeps_the_epoch_and_moves_the_end(tmp_path):
    async def tell(lease, lapsed):
        epoch = lease.take(ask(ttl_s=0.1), "s1")
        renewed = lease.take(ask(ttl_s=30.0, epoch=epoch), "s2")
        await asyncio.sleep(0.2)
        return epoch == renewed, lapsed.is_set(), lease.holder.session

    assert story(tmp_path, tell) == (True, False, "s2")


def test_a_lease_that_is_not_renewed_lapses_and_says_so(tmp_path):
    async def tell(lease, lapsed):
        epoch = lease.take(ask(ttl_s=0.05), "s1")
        async with asyncio.timeout(10):
            await lapsed.wait()
        with pytest.raises(Refused, match="nobody holds arm under epoch 1"):
            lease.check(epoch)
        return lease.take(ask(owner="page"), "s2")

    assert story(tmp_path, tell) == 2


def test_only_the_holder_releases(tmp_path):
    async def tell(lease, _):
        epoch = lease.take(ask(), "s1")
        wrong = lease.release("page", None), lease.release("run-1", epoch + 1)
        return wrong, lease.release("run-1", epoch), lease.holder

    assert story(tmp_path, tell) == ((False, False), True, None)
