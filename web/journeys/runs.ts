// Runs: launched from the form, followed on the map, paused, resumed, aborted, asked; found again after a crash.
import { mkdtemp, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import type { Page } from 'playwright-core'
import { describe, expect, it } from 'vitest'
import { ask, type Bench, startBench } from './bench'
import { aborted, aPerson, goOn, isLive, NARROW, type Person, releaseControl, tabTo } from './browser'
import { axe, picture } from './look'
import { startRun } from './measured'
import { bench, browser } from './stage'

const ADA = { welcomed: true, name: 'Ada' }

/** Send a command to the bench as a program does. */
async function command(on: Bench, path: string, body: unknown): Promise<void> {
  await ask(on, path, body, { 'Idempotency-Key': crypto.randomUUID(), 'X-Deadline': String(Date.now() + 5000) })
}

/** Close the page and release control for the next person. */
async function leave({ page, context }: Person): Promise<void> {
  await releaseControl(page)
  await context.close()
}

/** Fill in the form of the pegmatite map and start it from the dialog. */
async function launchMap(page: Page, size: string): Promise<string> {
  await page.goto('/runs?start=pegmatite_map.yaml')
  await page.getByLabel('width').fill(size)
  await page.getByLabel('height').fill(size)
  for (const point of ['enclosure closed', 'nobody in the beam path', 'sample fixed']) {
    await page.getByRole('checkbox', { name: point }).check()
  }
  // As a newcomer does; it is one run.
  await page.getByRole('button', { name: 'Start', exact: true }).dblclick()
  await page.getByRole('button', { name: 'Start now' }).dblclick()
  await page.waitForURL('**/runs/2*')
  return page.url()
}

describe('a run', () => {
  it('list is empty at first, and the page says what to do', async () => {
    const person = await aPerson(browser, bench.entry, {}, ADA)
    const { page, faults } = person
    await page.goto('/runs')
    await isLive(page)
    await page.getByText('Nothing has been run here yet').waitFor()
    await picture(page, 'runs-empty')

    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await leave(person)
  })

  it('is launched from its form and fills its map until it is done', async () => {
    const person = await aPerson(browser, bench.entry, {}, ADA)
    const { page, faults } = person
    await page.goto('/runs')
    await page.getByLabel('Protocol of a new run').selectOption('pegmatite_map.yaml')
    const start = page.getByRole('button', { name: 'Start', exact: true })
    await page.getByText('3 items are not ticked').waitFor()

    expect(await start.isDisabled()).toBe(true)

    await page.getByLabel('pitch').fill('0.001')
    await page.getByText('at least 0.02 mm', { exact: true }).waitFor()
    await page.getByLabel('pitch').fill('0.2')
    await page.getByText('1,071 points').waitFor()
    await picture(page, 'launch')

    expect(await axe(page)).toEqual([])

    // A program may start it once, as it was read; and no more, once that is taken back.
    for (const box of await page.getByRole('group', { name: 'Before a run' }).getByRole('checkbox').all()) await box.check()
    await page.getByRole('button', { name: 'Release to a program' }).click()
    const dialog = page.getByRole('dialog', { name: 'Release pegmatite_map.yaml' })
    const give = dialog.getByRole('button', { name: 'Release for one start' })
    await dialog.getByRole('region', { name: 'What would be run' }).getByText('6,428 actions').first().waitFor()

    expect(await give.isDisabled()).toBe(true)

    await dialog.getByRole('checkbox', { name: 'I have read it' }).check()
    await picture(page, 'release')

    expect(await axe(page)).toEqual([])

    await give.click()
    await dialog.getByRole('list', { name: 'Released' }).getByText('by Ada').waitFor()
    await dialog.getByRole('button', { name: 'Take back' }).click()
    await dialog.getByRole('list', { name: 'Released' }).waitFor({ state: 'detached' })

    expect(await ask(bench, '/releases')).toEqual([])

    await launchMap(page, '0.6')
    await page.getByRole('region', { name: 'Now' }).waitFor()
    await page.getByRole('progressbar', { name: 'Progress', exact: true }).waitFor()
    await page.getByRole('region', { name: 'Map' }).getByText('▶ running').or(page.getByText('✓ ok')).first().waitFor()
    await picture(page, 'run-live')

    expect(await axe(page)).toEqual([])

    await page.getByRole('region', { name: 'How it ended' }).getByText('✓ Done').waitFor()
    await page.getByRole('region', { name: 'Map' }).getByText('ok 16').waitFor()
    await page.getByRole('group', { name: 'What the map shows' }).getByRole('button', { name: 'Li' }).click()
    await page.getByRole('region', { name: 'Spectrum' }).getByRole('application').waitFor()
    await picture(page, 'run-done')

    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await leave(person)
  }, 240_000)
})

describe('a run that is looked at', () => {
  it('opens a point from the map by keys, with its attempts and its line of YAML', async () => {
    const person = await aPerson(browser, bench.entry, {}, ADA)
    const { page, faults } = person
    await page.goto('/runs')
    await page.getByRole('list', { name: 'All runs' }).getByRole('link', { name: 'Pegmatite map' }).first().click()
    const map = page.getByRole('region', { name: 'Map' }).getByRole('application')
    await map.focus()
    await page.keyboard.press('ArrowRight')
    await page.keyboard.press('ArrowUp')
    await page.getByText('point 7 (0.2, 0.2) · ok').waitFor()
    await page.getByRole('region', { name: 'Spectrum' }).getByRole('application').waitFor() // what has not come cannot be reached
    await tabTo(page, /^Spectrum of/)
    await page.keyboard.press('Shift+Tab')
    await page.keyboard.press('Enter')
    const point = page.getByRole('region', { name: 'Point', exact: true })
    await point.getByText('shoot · libs.measure').waitFor()
    await point.getByRole('listitem').filter({ hasText: 'shoot' }).getByRole('button', { name: /line \d+/ }).click()
    await page.getByRole('dialog').getByText('do: libs.measure').waitFor()
    await picture(page, 'run-yaml-line')
    await page.keyboard.press('Escape')
    await picture(page, 'run-point')

    expect(page.url()).toContain('point=6')
    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await leave(person)
  })

  it('fits a narrow screen, dark as well', async () => {
    const person = await aPerson(browser, bench.entry, { viewport: NARROW, colorScheme: 'dark' }, ADA)
    const { page, faults } = person
    await page.goto('/runs')
    await page.getByRole('list', { name: 'All runs' }).getByRole('link', { name: 'Pegmatite map' }).first().click()
    await page.getByRole('region', { name: 'Map' }).getByText('ok 16').waitFor()
    await picture(page, 'run-narrow-dark')
    const wide = await page.evaluate(() => document.documentElement.scrollWidth)

    expect(wide).toBeLessThanOrEqual(390)
    expect(await axe(page)).toEqual([])

    await page.getByRole('button', { name: 'Steps' }).click()
    await page.getByRole('region', { name: 'Outline' }).waitFor()
    await picture(page, 'run-narrow-outline')
    await page.goto('/runs?start=pegmatite_map.yaml')
    await page.getByRole('checkbox', { name: 'sample fixed' }).waitFor()
    await picture(page, 'launch-narrow-dark')

    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await leave(person)
  })
})

describe('a person and a live run', () => {
  it('pause, resume and abort, each with what will happen', async () => {
    const person = await aPerson(browser, bench.entry, {}, ADA)
    const { page, faults } = person
    await launchMap(page, '4')
    await page.getByRole('button', { name: 'Pause' }).click()
    await page.getByRole('button', { name: 'Pause now' }).click()
    await page.getByText('Paused: nothing moves').waitFor()
    await picture(page, 'run-paused')

    expect(await axe(page)).toEqual([])

    await goOn(page)
    await page.getByRole('banner').or(page.locator('main')).getByText('▶').first().waitFor()
    await page.getByRole('button', { name: 'Pause' }).click()
    await page.getByRole('button', { name: 'Pause after this point' }).click()
    await page.getByText('Paused: nothing moves').waitFor()
    await goOn(page)
    await page.getByRole('button', { name: 'Abort' }).click()
    await page.getByRole('dialog').getByText('Kept:').waitFor()
    await picture(page, 'run-abort')

    expect(await axe(page)).toEqual([])

    await page.getByRole('button', { name: 'Go back' }).click()

    expect(await page.getByRole('button', { name: 'Abort' }).isVisible()).toBe(true)

    const end = page.getByRole('region', { name: 'How it ended' })
    await aborted(page, end.getByText('The run was aborted'))
    await picture(page, 'run-aborted')

    await end.getByRole('button', { name: 'Resume', exact: true }).click()
    const dialog = page.getByRole('dialog')

    expect(await dialog.getByRole('button', { name: 'Resume the run' }).isDisabled()).toBe(true)

    for (const point of ['enclosure closed', 'nobody in the beam path', 'sample fixed']) {
      await dialog.getByRole('checkbox', { name: point }).check()
    }
    await picture(page, 'run-resume')
    await dialog.getByRole('button', { name: 'Resume the run' }).click()
    await page.getByText('resumed 1×').first().waitFor()
    await aborted(page, end.getByText('The run was aborted'))

    expect(faults).toEqual([])
    await leave(person)
  })

  it('answer its question from the page', async () => {
    const text = 'labrun: 1\nname: asks\ndevices: {gantry: gantry@1}\nsteps:\n  - {do: gantry.home}\n  - {id: which, ask: "Which sample lies there?", choices: [granite, basalt]}\n  - {log: "it is ${{ steps.which.choice }}"}\n'
    await command(bench, '/protocols', { name: 'asks.yaml', text })
    const person = await aPerson(browser, bench.entry, {}, ADA)
    const { page, faults } = person
    await page.goto('/runs?start=asks.yaml')
    await page.getByRole('button', { name: 'Start', exact: true }).click()
    const question = page.getByRole('region', { name: 'Question' })
    await question.getByText('Which sample lies there?').waitFor()
    await picture(page, 'run-question')

    expect(await axe(page)).toEqual([])

    await question.getByRole('button', { name: 'basalt' }).click()
    await page.getByRole('region', { name: 'How it ended' }).getByText('✓ Done').waitFor()
    await page.getByRole('region', { name: 'Log' }).getByText('answered basalt by Ada').waitFor()
    await page.getByRole('region', { name: 'Spectrum' }).getByText('This run has no spectrum.').waitFor()

    expect(faults).toEqual([])
    await leave(person)
  })

  it('tell what an action returned whose fate no device could tell', { tags: ['soak'] }, async () => {
    const folder = await mkdtemp(join(tmpdir(), 'labrun-journey-'))
    await writeFile(join(folder, 'lab.yaml'), [
      'name: unsure', 'summary: An analyser that nobody can ask', 'simulated: true', 'devices:', '  libs:', '    contract: libs_analyzer@1',
      '    driver: sim_libs', '    config: {clock: fast, faults: {measure: {DialogOpen: 1.0}}}', '',
    ].join('\n'))
    await writeFile(join(folder, 'unseen.yaml'), [
      'labrun: 1', 'name: unseen', 'devices: {libs: libs_analyzer@1}', 'steps:', '  - {id: shoot, do: libs.measure, on_unknown: ask}',
      '  - {log: "it was shot ${{ steps.shoot.shot_id }}"}', '',
    ].join('\n'))
    const unsure = await startBench({ args: ['--lab', 'lab.yaml'], cwd: folder })
    const person = await aPerson(browser, unsure.entry, {}, ADA)
    const { page, faults } = person
    await page.goto(`/runs/${await startRun(unsure, 'unseen.yaml')}`)
    await page.getByRole('button', { name: 'Take control' }).click()
    const question = page.getByRole('region', { name: 'Question' })
    await question.getByRole('button', { name: 'happened', exact: true }).click()
    const returned = question.getByRole('form', { name: 'What it returned' })
    await returned.getByLabel('shot_id').fill('S-17')
    await picture(page, 'run-happened')

    expect(await axe(page)).toEqual([])

    await returned.getByRole('button', { name: 'It happened' }).click()
    await page.getByRole('region', { name: 'How it ended' }).getByText('✓ Done').waitFor()
    await page.getByRole('region', { name: 'Log' }).getByText('it was shot S-17').waitFor()

    expect(faults).toEqual([])
    await leave(person)
    await unsure.close()
  })

  it('are two: what one does, both see, and only who has control may abort', { tags: ['soak'] }, async () => {
    const ada = await aPerson(browser, bench.entry, {}, ADA)
    await launchMap(ada.page, '4')
    const bo = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Bo' })
    await bo.page.goto(ada.page.url())
    await bo.page.getByRole('button', { name: 'Pause' }).click()
    await bo.page.getByRole('button', { name: 'Pause now' }).click()
    await ada.page.getByText('Paused: nothing moves').waitFor()
    await bo.page.getByRole('button', { name: 'Abort' }).click()
    await bo.page.getByRole('button', { name: 'Abort the run' }).click()
    await bo.page.getByText('Ada has control of the bench').waitFor()
    await picture(bo.page, 'run-two')
    await aborted(ada.page, ada.page.getByRole('region', { name: 'How it ended' }).getByText('The run was aborted'))
    await bo.page.getByRole('region', { name: 'How it ended' }).getByText('The run was aborted').waitFor()

    expect([...ada.faults, ...bo.faults]).toEqual([])
    await leave(bo)
    await leave(ada)
  })
})
