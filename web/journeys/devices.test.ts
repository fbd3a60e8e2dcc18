// Devices by hand: moved, taught, armed, fired, recorded; and what the page shows when they fail.
import { mkdtemp, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import type { Browser, Locator, Page } from 'playwright-core'
import { afterAll, afterEach, beforeAll, describe, expect, it } from 'vitest'
import { ask, type Bench, orderFault, startBench } from './bench'
import { allOnline, aPerson, isLive, NARROW, openBrowser, type Person, releaseControl, tidy } from './browser'
import { axe, picture } from './look'

interface Device { name: string; status: Record<string, number | string | boolean> }

let bench: Bench
let browser: Browser
beforeAll(async () => {
  ;[bench, browser] = await Promise.all([startBench({ speed: 4 }), openBrowser()])
})
afterEach(() => tidy(browser, bench))
afterAll(async () => {
  await browser.close()
  await bench.close()
})

const status = async (device: string, at = bench) => (await ask<Device>(at, `/devices/${device}`)).status
const detail = (page: Page): Locator => page.getByRole('region', { name: 'Device detail' })

async function atDevice(device: string, options = {}, at = bench): Promise<Person> {
  const person = await aPerson(browser, at.entry, options, { welcomed: true, name: 'Ada' })
  await person.page.goto(`/devices/${device}`)
  await isLive(person.page)
  await allOnline(person.page)
  await person.page.getByRole('button', { name: 'Take control' }).click()
  const dialog = person.page.getByRole('dialog')
  const release = person.page.getByRole('button', { name: 'Release control' })
  await release.or(dialog).first().waitFor()
  if (await dialog.count()) {
    await dialog.getByLabel(/Or take over/).fill('the next journey')
    await dialog.getByRole('button', { name: 'Take over' }).click()
    await release.waitFor()
  }
  return person
}

async function leave(person: Person): Promise<void> {
  expect(person.faults).toEqual([])

  await releaseControl(person.page)
  await person.context.close()
}

describe('the gantry', () => {
  it('moves by the selected step size, and never beyond its limits', async () => {
    const person = await atDevice('gantry')
    const { page } = person
    await detail(page).getByRole('radio', { name: '10 mm' }).check({ force: true })
    await page.getByRole('button', { name: 'X+', exact: true }).click()
    await expect.poll(async () => (await status('gantry'))['x']).toBe(10)
    await page.getByRole('button', { name: 'Y-', exact: true }).click()
    await page.getByRole('status', { name: 'Jog' }).getByText(/outside 0 to 810 mm/).waitFor()

    expect((await status('gantry'))['y']).toBe(0)

    await leave(person)
  })

  it('goes to a clicked or typed position, relative to the user’s zero', async () => {
    const person = await atDevice('gantry')
    const { page } = person
    await page.getByRole('img', { name: /Work area/ }).click({ position: { x: 100, y: 100 } })
    const aimed = Number(await page.getByLabel('Go to X').inputValue())
    await page.getByRole('form', { name: 'Position' }).getByRole('button', { name: 'Go to' }).click()
    await expect.poll(async () => (await status('gantry'))['x']).toBeCloseTo(aimed, 1)
    await page.getByText('History', { exact: true }).click()
    await page.getByRole('region', { name: 'Numbers' }).getByRole('rowheader', { name: 'x mm', exact: true }).waitFor()
    await page.getByRole('img', { name: / from .* to / }).waitFor()
    await page.getByText('Live picture of the bench').click()
    await page.getByRole('img', { name: /^What \w+ sees$/ }).waitFor()

    expect(await axe(page)).toEqual([])

    await page.getByText('Live picture of the bench').click()

    await picture(page, 'gantry')
    await expect.poll(() => page.getByRole('status', { name: 'X position' }).innerText()).toBe(aimed.toFixed(2))
    await page.getByRole('button', { name: 'Set 0 for X' }).click()

    await expect.poll(() => page.getByRole('status', { name: 'X position' }).innerText()).toBe('0.00')
    expect((await status('gantry'))['work_x']).toBe(0)

    await page.getByLabel('Go to X').fill('5')
    await page.getByLabel('Go to Y').fill('')
    await page.getByRole('form', { name: 'Position' }).getByRole('button', { name: 'Go to' }).click()
    await expect.poll(async () => (await status('gantry'))['x']).toBeCloseTo(aimed + 5, 1)
    await page.getByLabel('Go to X').fill('9000')
    await page.getByText(/x 900\d.* is outside 0–730 mm|outside 0–730 mm/).first().waitFor()
    await page.getByRole('button', { name: 'Return to zero' }).click()
    await expect.poll(async () => (await status('gantry'))['x']).toBeCloseTo(aimed, 1)
    await leave(person)
  })

  it('can be held during a move and resumed', async () => {
    const person = await atDevice('gantry')
    const { page } = person
    const aim = Number((await status('gantry'))['y']) > 350 ? 0 : 700
    await page.getByLabel('Go to Y').fill(String(aim))
    await page.getByRole('form', { name: 'Position' }).getByRole('button', { name: 'Go to' }).click()
    await page.getByRole('button', { name: 'Hold', exact: true }).click()
    await expect.poll(async () => (await status('gantry'))['state']).toBe('hold')
    await page.getByRole('button', { name: 'Resume' }).click()
    await expect.poll(async () => (await status('gantry'))['y']).toBeCloseTo(aim, 1)
    await leave(person)
  })

  it('saves a position under a name and returns to it', async () => {
    const person = await atDevice('gantry')
    const { page } = person
    const before = await status('gantry')
    await page.getByLabel('Name of this position').fill('loading')
    await page.getByRole('button', { name: 'Save' }).click()
    await page.getByRole('button', { name: 'X+', exact: true }).click()
    await expect.poll(async () => (await status('gantry'))['x']).not.toBe(before['x'])
    await page.reload()
    await isLive(page)
    await page.getByRole('button', { name: 'Go to loading' }).click()
    await expect.poll(async () => (await status('gantry'))['x']).toBe(before['x'])
    await leave(person)
  })

  it('moves while a button is held, and stops when it is released', async () => {
    const person = await atDevice('gantry')
    const { page } = person
    await detail(page).getByLabel('hold', { exact: true }).check()
    const button = page.getByRole('button', { name: 'Y+', exact: true })
    const box = await button.boundingBox()
    const before = Number((await status('gantry'))['y'])
    await page.mouse.move((box?.x ?? 0) + 20, (box?.y ?? 0) + 20)
    await page.mouse.down()
    await expect.poll(async () => Number((await status('gantry'))['y'])).toBeGreaterThan(before + 10)
    await page.mouse.up()
    await expect.poll(async () => (await status('gantry'))['state']).toBe('idle')
    await page.waitForTimeout(1_500)
    const stood = Number((await status('gantry'))['y'])
    await page.waitForTimeout(1_500)

    expect(Number((await status('gantry'))['y'])).toBe(stood) // on a slow machine perhaps the end of the axis

    await leave(person)
  })

  it('stops when the page that holds it is closed', async () => {
    const person = await atDevice('gantry')
    const { page, context } = person
    await detail(page).getByLabel('hold', { exact: true }).check()
    await page.getByRole('button', { name: 'Y-', exact: true }).focus()
    const before = Number((await status('gantry'))['y'])
    await page.keyboard.down('Space')
    await expect.poll(async () => Number((await status('gantry'))['y'])).toBeLessThan(before)
    await context.close()
    await expect.poll(async () => (await status('gantry'))['state']).toBe('idle')
    await new Promise((resolve) => setTimeout(resolve, 1_500))
    const stood = (await status('gantry'))['y']
    await new Promise((resolve) => setTimeout(resolve, 1_500))

    expect((await status('gantry'))['y']).toBe(stood)
  })

  it('obeys the keys only while Keys is on', async () => {
    const person = await atDevice('gantry')
    const { page } = person
    const before = Number((await status('gantry'))['x'])
    await page.keyboard.press('ArrowRight')
    await page.getByRole('switch', { name: 'Keys' }).click()
    await page.keyboard.press('ArrowRight')
    await expect.poll(async () => (await status('gantry'))['x']).toBeCloseTo(before + 1, 2)
    await page.keyboard.press('Escape')

    expect(await page.getByRole('switch', { name: 'Keys' }).getAttribute('aria-checked')).toBe('false')

    await page.waitForTimeout(700)
    await page.keyboard.press('ArrowRight')
    await page.waitForTimeout(1_500)

    expect((await status('gantry'))['x']).toBeCloseTo(before + 1, 2)

    await leave(person)
  })
})

/** The laser's focus is at the bottom: elsewhere a shot gives no signal. */
async function focus(): Promise<void> {
  const reach = async () => (await ask<{ reach: string }>(bench, '/devices/gantry')).reach
  await expect.poll(reach).toBe('online')
  const { lease } = await ask<{ lease: string }>(bench, '/control/take', { name: 'Ada' })
  const headers = () => ({ 'X-Control-Lease': lease, 'X-Deadline': String(Date.now() + 5_000), 'Idempotency-Key': crypto.randomUUID() })
  await ask(bench, '/devices/gantry/actions/move_to', { params: { x: 0, y: 0, z: 0 } }, headers())
  await expect.poll(async () => (await status('gantry'))['z']).toBe(0)
  await ask(bench, '/control/release', {}, headers())
}

describe('an action', () => {
  it('reports invalid input, before and after it is sent', async () => {
    const person = await atDevice('gantry')
    const { page } = person
    await detail(page).locator('summary', { hasText: 'move_to' }).click()
    const form = page.getByRole('form', { name: 'move_to' })
    await form.getByLabel('x', { exact: true }).fill('731')
    await form.getByRole('button', { name: 'Run' }).click()
    await form.getByText('731 is outside 0–730 mm').waitFor()
    await form.getByLabel('x', { exact: true }).fill('3 s')
    await form.getByRole('button', { name: 'Run' }).click()
    await form.getByText(/time/).first().waitFor()
    await form.getByLabel('x', { exact: true }).fill('2 cm')
    await form.getByRole('button', { name: 'Run' }).click()
    await form.getByText('✓ ok').waitFor()
    await picture(page, 'action')

    // A status follows the outcome; the page has it when it shows it.
    await expect.poll(async () => (await status('gantry'))['x']).toBe(20)
    const shown = Number((await status('gantry'))['work_x']).toFixed(2).replace('-', '−')
    await expect.poll(() => page.getByRole('status', { name: 'X position' }).innerText()).toBe(shown)

    await form.getByLabel('x', { exact: true }).fill('')
    await form.getByRole('button', { name: 'Teach' }).click()

    expect(await form.getByLabel('x', { exact: true }).inputValue()).toBe('20')

    await leave(person)
  })

  it('that is a hazard is armed, held and done once; its file is shown in place', async () => {
    await focus()
    const person = await atDevice('libs')
    const { page } = person
    await detail(page).locator('summary', { hasText: 'measure' }).click()
    const form = page.getByRole('form', { name: 'measure' })

    expect(await form.getByRole('button', { name: 'Run' }).count()).toBe(0)

    await form.getByRole('button', { name: 'Arm' }).click()
    const hold = form.getByRole('button', { name: 'Hold 1 s to measure' })
    await hold.click()
    await page.waitForTimeout(300)

    expect((await status('libs'))['shots']).toBe(0)

    await picture(page, 'armed')
    const box = await hold.boundingBox()
    await page.mouse.move((box?.x ?? 0) + 20, (box?.y ?? 0) + 10)
    await page.mouse.down()
    await page.waitForTimeout(1_200)
    await page.mouse.up()
    await picture(page, 'fired')
    await form.getByText('✓ ok').waitFor()
    await expect.poll(async () => (await status('libs'))['shots']).toBe(1)
    const shot = (await form.locator('dl dd').first().innerText()).trim()
    await detail(page).locator('summary', { hasText: 'export' }).click()
    const write = page.getByRole('form', { name: 'export' })
    await write.getByLabel(/^shot/).fill(shot)
    await write.getByLabel(/^file/).fill('first.csv')
    await write.getByRole('button', { name: 'Run' }).click()
    await write.getByRole('img', { name: /values from/ }).waitFor()
    await picture(page, 'spectrum')

    expect(await axe(page)).toEqual([])

    await leave(person)
  })

  it('can be confirmed in a dialog instead of held, with the keyboard alone', async () => {
    const person = await atDevice('libs')
    const { page } = person
    const before = Number((await status('libs'))['shots'])
    await detail(page).locator('summary', { hasText: 'measure' }).focus()
    await page.keyboard.press('Enter')
    const form = page.getByRole('form', { name: 'measure' })
    await form.getByRole('button', { name: 'Arm' }).focus()
    await page.keyboard.press('Enter')
    await form.getByRole('button', { name: /Confirm in a dialog/ }).focus()
    await page.waitForTimeout(1_100)
    await page.keyboard.press('Enter')
    await page.getByRole('button', { name: 'Yes, measure now' }).focus()
    await page.keyboard.press('Enter')
    await expect.poll(async () => Number((await status('libs'))['shots'])).toBeCloseTo(before + 1, 2)
    await leave(person)
  })

  it('that fails reports the error and whether the action happened', async () => {
    const person = await atDevice('libs')
    const { page } = person
    await orderFault(bench, { device: 'libs', kind: 'error', action: 'locate', error: 'ButtonNotFound' })
    await detail(page).locator('summary', { hasText: 'locate' }).click()
    const form = page.getByRole('form', { name: 'locate' })
    await form.getByRole('button', { name: 'Run' }).click()
    await form.getByText('ButtonNotFound').waitFor()
    await form.getByText('It did not happen.').waitFor()
    await leave(person)
  })

  it('becomes a step of a protocol while it is recorded', async () => {
    const person = await atDevice('gantry')
    const { page } = person
    await detail(page).getByRole('button', { name: 'Record' }).click()
    await detail(page).locator('summary', { hasText: 'move_to' }).click()
    const form = page.getByRole('form', { name: 'move_to' })
    await form.getByLabel('x', { exact: true }).fill('33')
    await form.getByRole('button', { name: 'Run' }).click()
    await form.getByText('✓ ok').waitFor()
    await form.getByRole('button', { name: 'Add to protocol' }).waitFor()
    await picture(page, 'recorded')
    await page.getByRole('button', { name: /Make a protocol from 1 step/ }).click()
    await page.waitForURL('**/protocols/recorded.yaml')
    const { text } = await ask<{ text: string }>(bench, '/protocols/recorded.yaml')

    expect(text).toContain('gantry: gantry@1')
    expect(text).toMatch(/- \{do: gantry\.move_to, with: \{x: 33(\.0)?\}\}/)

    const checked = await ask<{ ok: boolean }>(bench, '/check', { text, name: 'recorded.yaml' })

    expect(checked.ok).toBe(true)

    await leave(person)
  })
})

describe('a device', () => {
  it('that is lost shows since when and why, and returns after a scan', async () => {
    const person = await atDevice('balance')
    const { page } = person
    await orderFault(bench, { device: 'balance', kind: 'kill' })
    await page.getByRole('link', { name: /balance/ }).getByText(/lost|failed|starting/).first().waitFor()
    await picture(page, 'lost')
    expect(await axe(page)).toEqual([])
    await page.getByRole('button', { name: 'Scan' }).click()
    await page.getByRole('link', { name: /balance/ }).getByText('ready').waitFor()
    await leave(person)
  })

  it('that is in alarm is cleared in a dialog, after a check', async () => {
    const folder = await mkdtemp(join(tmpdir(), 'labrun-journey-'))
    const lab = join(folder, 'lab.yaml')
    await writeFile(lab, [
      'name: alarming', 'summary: A gantry whose first move ends in an alarm', 'simulated: true', 'devices:', '  gantry:', '    contract: gantry@1',
      '    driver: sim_gantry', '    config: {clock: fast, homed: true, faults: {move_to: {Alarm: 1.0}}}', '',
    ].join('\n'))
    const alarming = await startBench({ args: ['--lab', lab], cwd: folder })
    const person = await atDevice('gantry', {}, alarming)
    const { page } = person
    await page.getByLabel('Go to X').fill('50')
    await page.getByRole('form', { name: 'Position' }).getByRole('button', { name: 'Go to' }).click()
    await page.getByRole('button', { name: 'Clear alarm…' }).click()
    const home = page.getByRole('button', { name: /^Home/ })

    expect(await home.isDisabled()).toBe(true)

    await page.getByLabel(/I have checked/).check()
    await picture(page, 'alarm')
    await home.click()
    await page.getByRole('dialog').waitFor({ state: 'detached' })
    await page.getByRole('button', { name: 'Clear alarm…' }).waitFor({ state: 'detached' })
    await leave(person)
    await alarming.close()
  })

  it('fits on a screen of 390 pixels, with the pad within reach of a thumb', async () => {
    const person = await atDevice('gantry', { viewport: NARROW, hasTouch: true })
    const { page } = person
    const wider = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth)

    expect(wider).toBe(0)

    const before = Number((await status('gantry'))['x'])
    await page.getByRole('button', { name: 'X+', exact: true }).tap()
    await expect.poll(async () => (await status('gantry'))['x']).toBeCloseTo(before + 1, 2)
    const size = await page.getByRole('button', { name: 'X+', exact: true }).boundingBox()

    expect(Math.min(size?.width ?? 0, size?.height ?? 0)).toBeGreaterThanOrEqual(44)

    await picture(page, 'gantry-390')
    await leave(person)
  })
})
