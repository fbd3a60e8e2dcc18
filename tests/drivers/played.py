"""A driver without a server: opened, a story happens to it, closed."""

import asyncio


def played(driver, story):
    """What the story returns."""

    async def play():
        await driver.open()
        try:
            return await story(driver)
        finally:
            await driver.close()

    return asyncio.run(play())
