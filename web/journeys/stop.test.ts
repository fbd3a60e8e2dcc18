// STOP ALL and broken connections: stopped devices confirm, silent ones are named, nothing is done later.
import { rm } from 'node:fs/promises'
import type { Browser, Page } from 'playwright-core'
import { afterAll, afterEach, beforeAll, describe, expect, it } from 'vitest'
import { aGantryAlone, ask, type Bench, orderFault, startBench } from './bench'
import { allOnline, aPerson, isLive, openBrowser, releaseControl, tidy } from './browser'
import { axe, picture } from './look'

interface Device { name: string; status: Record<string, number> }

let bench: Bench
let browser: Browser
beforeAll(async () => {
  ;[bench, browser] = await Promise.all([startBench({ speed: 20 }), openBrowser()])
})
afterEach(() => {
  bench.signal('SIGCONT')
  return tidy(browser, bench)
})
afterAll(async () => {
  await browser.close()
  await bench.close()
})

const stop = (page: Page) => page.getByRole('button', { name: 'Stop all devices' })
const x = async (): Promise<number> => (await ask<Device>(bench, '/devices/gantry')).status['x'] ?? Number.NaN

async function atGantry(page: Page): Promise<void> {
  await page.goto('/devices/gantry')
  await allOnline(page)
}

describe('STOP ALL', () => {
  it('shows that each device confirmed, from any page, by button and by Esc Esc', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await atGantry(page)
    await page.goto('/settings')
    await isLive(page)
    await stop(page).click()
    const outcome = page.getByRole('status', { name: 'Stop', exact: true })
    await outcome.getByText(/gantry ✓/).waitFor()
    await outcome.getByText(/libs ✓/).waitFor()
    await picture(page, 'stopped')
    await page.goto('/runs')
    await isLive(page)
    await page.keyboard.press('Escape')
    await page.keyboard.press('Escape')
    await outcome.getByText(/gantry ✓/).waitFor()

    expect(faults).toEqual([])

    await context.close()
  })

  it('reaches through an open dialog', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await page.goto('/settings')
    await isLive(page)
    await page.keyboard.press('?')
    await page.getByRole('dialog').waitFor()
    await stop(page).click()
    await page.getByRole('status', { name: 'Stop', exact: true }).getByText(/gantry ✓/).waitFor()
    await context.close()
  })

  it('names the device that did not confirm, as wide as the page', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await atGantry(page)
    await orderFault(bench, { device: 'libs', kind: 'freeze' })
    await stop(page).click()
    const alarm = page.getByRole('alert').filter({ hasText: 'libs did not confirm the stop. Use the hardware e-stop.' })
    await alarm.waitFor().finally(() => orderFault(bench, { device: 'libs', kind: 'thaw' }))
    await picture(page, 'stop-alarm')

    expect(await alarm.innerText()).toContain('gantry ✓')
    expect(await axe(page)).toEqual([])

    await page.getByRole('button', { name: 'I have seen it' }).click()
    await alarm.waitFor({ state: 'detached' })
    await context.close()
  })

  it('is practised by mouse: a fault is ordered, seen, and put right', async () => {
    const { page, context, faults } = await aPerson(browser, bench.address)
    await page.goto('/devices/libs')
    await isLive(page)
    await allOnline(page)
    await page.getByText('Practise: order a fault').click()
    const ordered = page.getByRole('list', { name: 'Ordered faults' })
    for (const [button, words] of [['Leave a stop unconfirmed', 'libs does not confirm a stop'], ['Open the enclosure', 'the enclosure of libs is open']] as const) {
      // On a slow machine a click may come too late for the server, which says so.
      while (!(await ordered.getByText(words).isVisible())) {
        await page.getByRole('button', { name: button }).click()
        await ordered.getByText(words).waitFor({ timeout: 10_000 }).catch(() => undefined)
      }
    }
    await page.getByRole('region', { name: 'Device list' }).getByText(/armed .* interlock open/).first().waitFor()
    await stop(page).click()
    await page.getByRole('alert').getByText('libs did not confirm the stop.').waitFor()
    await picture(page, 'stop-practised')

    expect(await axe(page)).toEqual([])

    while (await ordered.isVisible()) {
      await page.getByRole('button', { name: 'Put all right' }).click({ timeout: 10_000 }).catch(() => undefined)
      await ordered.waitFor({ state: 'detached', timeout: 10_000 }).catch(() => undefined)
    }
    await page.getByRole('region', { name: 'Device list' }).getByText(/armed .* interlock open/).waitFor({ state: 'detached' })
    await expect.poll(async () => {
      const { devices } = await ask<{ devices: { device: string; confirmed: boolean }[] }>(bench, '/stop', {})
      return devices.find((one) => one.device === 'libs')?.confirmed
    }).toBe(true)

    expect(faults).toEqual([])

    await context.close()
  })

  it('reports at once that nothing confirmed when the server is silent, and stops nothing later', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await atGantry(page)
    bench.signal('SIGSTOP')
    await stop(page).click()
    const alarm = page.getByRole('alert').filter({ hasText: 'Use the hardware e-stop' })
    await alarm.waitFor()

    expect(await alarm.innerText()).toMatch(/gantry.*did not confirm/)

    await page.getByRole('status', { name: 'Connection' }).filter({ hasText: 'offline' }).waitFor()
    await context.close()
  })
})

describe('a run', () => {
  it('is shown on every screen, keeps its devices, and is aborted by STOP ALL', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await atGantry(page)
    const { lease } = await ask<{ lease: string }>(bench, '/control/take', { name: 'Ada' })
    const headers = { 'X-Control-Lease': lease, 'X-Deadline': String(Date.now() + 30_000), 'Idempotency-Key': crypto.randomUUID() }
    const { settings } = await ask<{ settings: { checklists: Record<string, string[]> } }>(bench, '/settings')
    const checklist = settings.checklists['laser']
    await ask(bench, '/runs', { protocol: 'pegmatite_map.yaml', checklist }, headers)
    const strip = page.getByRole('region', { name: 'Live runs' })
    await strip.getByText('running').waitFor()
    await page.getByText('is using gantry').waitFor()
    await picture(page, 'held-by-run')

    expect(await page.getByRole('button', { name: 'X+', exact: true }).isDisabled()).toBe(true)
    expect(await axe(page)).toEqual([])

    await page.keyboard.press('g')
    await page.keyboard.press('s')
    await strip.getByRole('link', { name: /^Open run/ }).waitFor()
    await stop(page).click()
    await page.getByRole('status', { name: 'Stop', exact: true }).getByText(/runs aborted/).waitFor()
    await strip.waitFor({ state: 'detached' })
    await page.getByRole('region', { name: 'Notices' }).getByText(/aborted/).first().waitFor()
    await picture(page, 'aborted')
    await ask(bench, '/control/release', {}, headers)

    expect(faults).toEqual([])

    await context.close()
  })
})

describe('an offline spell', () => {
  it('discards clicks and does not carry them out later', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
    await atGantry(page)
    await page.getByRole('button', { name: 'Take control' }).click()
    await page.getByRole('button', { name: 'Release control' }).waitFor()
    const first = await x()
    await page.getByRole('button', { name: 'X+' }).click()
    await expect.poll(x).toBeCloseTo(first + 1, 2)
    const before = await x()
    bench.signal('SIGSTOP')
    // At first the loss is not detected: these clicks are sent, and arrive after their deadline.
    await page.getByRole('button', { name: 'X+' }).click()
    await page.getByRole('status', { name: 'Connection' }).filter({ hasText: 'offline' }).waitFor()
    await page.getByText('No connection for').waitFor()
    await picture(page, 'offline')

    expect(await page.getByRole('button', { name: 'X+' }).isDisabled()).toBe(true)

    await page.waitForTimeout(4_000)
    bench.signal('SIGCONT')
    await isLive(page)
    await page.waitForTimeout(3_000)

    expect(await x()).toBeCloseTo(before, 2)
    expect(faults).toEqual([])

    await page.getByRole('button', { name: 'X+' }).click()
    await expect.poll(x).toBeCloseTo(before + 1, 2)
    await context.close()
  })

  it('on a slow network comes late or not at all, and is never made up for', async () => {
    const { page, context, faults } = await aPerson(browser, bench.address, {}, { welcomed: true, name: 'Ada' })
    const network = await context.newCDPSession(page)
    const slow = (offline: boolean) => network.send('Network.emulateNetworkConditions', { offline, latency: 400, downloadThroughput: 50_000, uploadThroughput: 20_000 })
    await network.send('Network.enable')
    await atGantry(page)
    await page.getByRole('button', { name: 'Take control' }).click()
    await page.getByRole('button', { name: 'Release control' }).waitFor()
    await slow(false)
    const first = await x()
    await page.getByRole('button', { name: 'X+', exact: true }).click()
    const refused = page.getByText(/too late|not sent|no answer/).first()
    await Promise.race([expect.poll(x).toBeCloseTo(first + 1, 2), refused.waitFor()])
    const before = await x()
    await slow(true)
    await page.getByRole('button', { name: 'X+', exact: true }).click({ timeout: 1_000, force: true }).catch(() => undefined)
    await page.getByRole('status', { name: 'Connection' }).filter({ hasText: 'offline' }).waitFor()
    await page.getByRole('button', { name: 'X+', exact: true }).click({ timeout: 1_000, force: true }).catch(() => undefined)
    await slow(false)
    await isLive(page)
    await page.waitForTimeout(3_000)

    expect(await x()).toBeCloseTo(before, 2)
    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])

    await releaseControl(page)
    await context.close()
  })

  it('is shown when the browser loses its network, and ends automatically', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await atGantry(page)
    await context.setOffline(true)
    await page.getByRole('status', { name: 'Connection' }).filter({ hasText: 'offline' }).waitFor()
    await stop(page).click()
    await page.getByRole('alert').filter({ hasText: 'did not confirm' }).or(page.getByRole('status', { name: 'Stop', exact: true }).getByText(/gantry ✓/)).waitFor()
    await picture(page, 'browser-offline')
    expect(await axe(page)).toEqual([])  // of rows whose values are old, too
    await context.setOffline(false)
    await isLive(page)
    await context.close()
  })

  it('ends when another server is at the same address', { tags: ['soak'] }, async () => {
    const folder = await aGantryAlone()
    const first = await startBench({ args: ['--lab', 'lab.yaml'], cwd: folder })
    const { page, context } = await aPerson(browser, first.entry)
    await page.goto('/devices')
    await isLive(page)
    await first.close()
    await page.getByRole('status', { name: 'Connection' }).filter({ hasText: 'offline' }).waitFor()
    const second = await startBench({ args: ['--lab', 'lab.yaml'], cwd: folder, port: first.port })
    await isLive(page)
    await page.getByRole('region', { name: 'Device list' }).getByText('gantry', { exact: true }).waitFor()
    await context.close()
    await second.close()
    await rm(folder, { recursive: true, force: true })
  })
})
