// Points that failed: told alike everywhere, measured again when a person asks for it, beside what the laser has fired.
import { beforeAll, expect, it } from 'vitest'
import { ask, orderFault } from './bench'
import { aPerson, goOn, ordered, releaseControl, tickChecklist } from './browser'
import { axe, picture } from './look'
import { now, reached, startRun, until } from './measured'
import { bench, browser } from './stage'

const SCAN = `labrun: 1
name: scan
params: {feed: {type: quantity, unit: mm/min, default: 600 mm/min}}
devices: {libs: libs_analyzer@1, gantry: gantry@1}
steps:
  - {do: gantry.home}
  - {do: gantry.move_to, with: {x: 0 mm, y: 0 mm, z: 0 mm}}
  - foreach: {point: "\${{ grid(x=span(0, 3 mm, 1 mm), y=span(0, 2 mm, 1 mm)) }}"}
    id: scan
    key: \${{ point.ix }},\${{ point.iy }}
    keep_going: true
    steps:
      - {id: travel, do: gantry.move_to, with: {x: "\${{ point.x }}", y: "\${{ point.y }}", z: 0 mm, feed: "\${{ params.feed }}"}}
      - {id: shoot, do: libs.measure}
    collect: {x: "\${{ point.x }}", y: "\${{ point.y }}", shot: "\${{ steps.shoot.shot_id }}"}
finally: [{fail: the valve is still open, on_error: continue}, {do: gantry.move_to, with: {z: 5 mm}}]
on_resume: [{do: gantry.home}, {do: gantry.move_to, with: {x: 0 mm, y: 0 mm, z: 0 mm}}]
`
interface Told { fate: string; done: number; word: string; total: number; measured: number; failed: number; left: number; holes: number }
beforeAll(async () => {
  await ask(bench, '/protocols', { name: 'scan.yaml', text: SCAN }, now())
}, 120_000)

const shots = async (): Promise<number> => Number((await ask<{ status: Record<string, unknown> }>(bench, '/devices/libs')).status['shots'])
const height = async (): Promise<number> => Number((await ask<{ status: Record<string, unknown> }>(bench, '/devices/gantry')).status['z'])
const fired = (count: number) => expect.poll(shots).toBe(count)
async function numbers(run: string): Promise<number[]> {
  const told = await ask<Told>(bench, `/runs/${run}`)
  return [told.total, told.measured, told.failed, told.left]
}

it('holes are offered with the map, chosen, and measured again', { tags: ['soak'] }, async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
  await reached(bench)
  const before = await shots()
  await orderFault(bench, { device: 'libs', kind: 'error', action: 'measure', error: 'ButtonNotFound', count: 3 })
  const run = await startRun(bench, 'scan.yaml')
  await until(bench, run, (told) => told.fate === 'succeeded')

  expect(await numbers(run)).toEqual([12, 9, 3, 0])
  await fired(before + 9)

  await page.goto('/runs')
  const row = page.getByRole('listitem').filter({ hasText: run })
  await row.getByText('succeeded with 3 holes').waitFor()
  await row.getByText('9 of 12 measured · 3 failed').waitFor()
  await page.goto(`/runs/${run}`)
  const end = page.getByRole('region', { name: 'How it ended' })
  await end.getByText('Done: succeeded with 3 holes').waitFor()
  await end.getByText(', but finally: the valve is still open').waitFor()

  expect(await height()).toBeCloseTo(5, 2) // what follows in `finally` runs all the same

  await end.getByText('9 of 12 measured · 3 failed').waitFor()
  await picture(page, 'run-holes')
  await end.getByRole('button', { name: 'Measure the 3 holes again…' }).click()
  const dialog = page.getByRole('dialog')
  await dialog.getByText('3 of 3 chosen').waitFor()
  await dialog.getByRole('button', { name: 'None' }).click()
  const map = dialog.getByRole('application')
  await map.focus()
  await page.keyboard.press('ArrowRight')
  await page.keyboard.press('Enter')
  await dialog.getByText('1 of 3 chosen').waitFor()
  await picture(page, 'run-holes-dialog')

  expect(await axe(page)).toEqual([])

  await tickChecklist(dialog)
  await dialog.getByRole('button', { name: 'Measure 1 point again' }).click()
  await end.getByText('Done: succeeded with 2 holes').waitFor()

  expect(await numbers(run)).toEqual([12, 10, 2, 0])
  await fired(before + 10)

  await end.getByRole('button', { name: 'Measure the 2 holes again…' }).click()
  await tickChecklist(dialog)
  await dialog.getByRole('button', { name: 'Measure 2 points again' }).click()
  await end.getByText('12 of 12 measured').waitFor()

  expect(await numbers(run)).toEqual([12, 12, 0, 0])
  await fired(before + 12)

  await page.getByRole('region', { name: 'Log' }).getByText('2 holes are measured again (pass 3), for Ada').waitFor()
  await picture(page, 'run-holes-none')

  expect(faults).toEqual([])
  await releaseControl(page)
  await context.close()
})

it('a run of which no point succeeded is not resumed into the same failure', { tags: ['soak'] }, async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
  await reached(bench)
  const before = await shots()
  await orderFault(bench, { device: 'libs', kind: 'error', action: 'measure', error: 'ButtonNotFound', count: 12 })
  const run = await startRun(bench, 'scan.yaml')
  await until(bench, run, (told) => told.fate === 'failed')

  expect(await numbers(run)).toEqual([12, 0, 12, 0])
  expect(await shots()).toBe(before)

  await page.goto(`/runs/${run}`)
  const end = page.getByRole('region', { name: 'How it ended' })
  await end.getByRole('button', { name: 'Measure the 12 holes again…' }).waitFor()

  expect(await end.getByRole('button', { name: 'Resume', exact: true }).count()).toBe(0)
  expect(faults).toEqual([])

  await context.close()
})

it('STOP ALL makes no hole: it says who it was, shows one state, and the run is resumed to its end', { tags: ['soak'] }, async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
  await reached(bench)
  const before = await shots()
  const run = await startRun(bench, 'scan.yaml', { feed: '1 mm/min' }) // a minute a millimetre: it is pressed in time
  await page.goto(`/runs/${run}`)
  await until(bench, run, (told) => told.done >= 2)
  await page.getByRole('button', { name: 'Stop all devices' }).click()
  const header = page.locator('header.top')
  await header.getByText('aborted').waitFor()

  expect(await page.getByRole('button', { name: 'Pause' }).count()).toBe(0)
  expect(await page.getByText('▶ aborted').count()).toBe(0)

  const end = page.getByRole('region', { name: 'How it ended' })
  await end.getByText('aborted by Ada (STOP ALL on the page)').waitFor()
  await picture(page, 'run-stopped')
  const [total, measured, failed, left] = await numbers(run)

  expect([total, failed, (measured ?? 0) + (left ?? 0)]).toEqual([12, 0, 12])

  await end.getByRole('button', { name: 'Resume', exact: true }).click()
  const dialog = page.getByRole('dialog')
  await tickChecklist(dialog)
  await dialog.getByRole('button', { name: 'Resume the run' }).click()
  await end.getByText('12 of 12 measured').waitFor()

  expect(await numbers(run)).toEqual([12, 12, 0, 0])
  await fired(before + 12)

  expect(faults).toEqual([])
  await releaseControl(page)
  await context.close()
})

it('a live run gets more points, and nothing that was done is done again', { tags: ['soak'] }, async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
  await reached(bench)
  await ask(bench, '/protocols', { name: 'more.yaml', text: SCAN.replace('span(0, 2 mm', 'span(0, 3 mm') }, now())
  const before = await shots()
  const run = await startRun(bench, 'scan.yaml', { feed: '1 mm/min' }) // a second a millimetre: it is pressed in time
  await page.goto(`/runs/${run}`)
  await page.getByRole('button', { name: 'Pause', exact: true }).click()
  await page.getByRole('button', { name: 'Pause now' }).click()
  await page.getByRole('button', { name: 'Change…' }).click()
  const dialog = page.getByRole('dialog')
  await dialog.getByLabel('Protocol').selectOption('more.yaml')
  await dialog.getByText(/finished actions still match/).waitFor()
  await picture(page, 'run-change')

  expect(await axe(page)).toEqual([])

  const change = dialog.getByRole('button', { name: 'Change the run' })
  await ordered(page, () => change.click({ timeout: 10_000 }).catch(() => undefined), page.getByRole('region', { name: 'Log lines' }).getByText('continues with a changed protocol'))
  await dialog.waitFor({ state: 'hidden' })
  await goOn(page)
  await until(bench, run, (told) => told.fate === 'succeeded')

  expect(await numbers(run)).toEqual([16, 16, 0, 0])
  await fired(before + 16)
  expect(faults).toEqual([])
  await context.close()
})
