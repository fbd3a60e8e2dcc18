// Runs in which something goes wrong: the failure is found and the run resumed with a changed protocol; by keyboard alone.
import { beforeAll, expect, it } from 'vitest'
import { ask, orderFault } from './bench'
import { aPerson, releaseControl, tabTo, tickChecklist } from './browser'
import { axe, picture } from './look'
import { now, reached, startRun, until } from './measured'
import { bench, browser } from './stage'

const SCAN = `labrun: 1
name: scan
devices: {libs: libs_analyzer@1, gantry: gantry@1}
steps:
  - {do: gantry.home}
  - {do: libs.locate}
  - foreach: {point: "\${{ grid(x=span(0, 3 mm, 1 mm), y=span(0, 2 mm, 1 mm)) }}"}
    id: scan
    key: \${{ point.ix }},\${{ point.iy }}
    keep_going: {max_failed: 1}
    steps:
      - {id: travel, do: gantry.move_to, with: {x: "\${{ point.x }}", y: "\${{ point.y }}", z: 0 mm}}
      - {id: shoot, do: libs.measure, retry: 2}
    collect: {x: "\${{ point.x }}", y: "\${{ point.y }}", shot: "\${{ steps.shoot.shot_id }}"}
`
beforeAll(async () => {
  await ask(bench, '/protocols', { name: 'trouble.yaml', text: SCAN }, now())
}, 120_000)

it('what went wrong is found in the outline and in the log, and the run is resumed with a changed protocol', { tags: ['soak'] }, async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
  await reached(bench)
  await orderFault(bench, { device: 'libs', kind: 'error', action: 'measure', error: 'ButtonNotFound', count: 4 })
  const run = await startRun(bench, 'trouble.yaml')
  await until(bench, run, (told) => told.fate === 'failed')
  const told = await ask<Record<string, number>>(bench, `/runs/${run}`)

  expect([told['total'], told['measured'], told['failed'], told['left']]).toEqual([12, 0, 1, 11])

  await page.goto('/runs')
  await page.getByRole('listitem').filter({ hasText: run }).getByText('0 of 12 measured · 1 failed · 11 left').waitFor()
  await page.goto(`/runs/${run}`)
  const end = page.getByRole('region', { name: 'How it ended' })
  await end.getByText('The run failed').waitFor()
  await end.getByText('0 of 12 measured · 1 failed · 11 left').waitFor()
  await end.getByText(/: point 2 of 12 \(x = 1 mm, y = 0 mm\): libs\.measure: .*, 2 tries; no more than 1 may fail$/).waitFor()
  const outline = page.getByRole('region', { name: 'Outline' })
  await outline.getByRole('checkbox', { name: 'only problems' }).check()
  const point = outline.getByRole('row').filter({ hasText: 'point 1 (0, 0)' })
  await point.waitFor()
  await outline.getByRole('treegrid').focus()
  for (let i = 0; i < 9 && !(await point.getAttribute('class'))?.includes('active'); i++) await page.keyboard.press('ArrowDown')
  await page.keyboard.press('ArrowRight')
  await outline.getByRole('row').filter({ hasText: 'shoot · libs.measure' }).first().waitFor()
  await page.keyboard.press('Enter')
  await page.getByRole('region', { name: 'Point', exact: true }).getByText('shoot · libs.measure').first().waitFor()
  await page.getByRole('region', { name: 'Log' }).getByRole('button', { name: 'problems' }).click()
  await page.getByRole('region', { name: 'Log' }).getByText(/0,0: .*a hole/).waitFor()
  await picture(page, 'run-failed')

  expect(await axe(page)).toEqual([])

  const { revision } = await ask<{ revision: string }>(bench, '/protocols/trouble.yaml')
  const session = await page.request.put(`${bench.address}/api/v1/protocols/trouble.yaml`, {
    data: { text: SCAN.replace('max_failed: 1', 'max_failed: 9'), base: revision }, headers: { Origin: bench.address },
  })

  expect(session.ok()).toBe(true)

  await end.getByRole('button', { name: 'Resume with a changed protocol…' }).click()
  const dialog = page.getByRole('dialog')
  await dialog.getByText('+    keep_going: {max_failed: 9}').waitFor()
  await picture(page, 'run-changed')

  expect(await axe(page)).toEqual([])

  await tickChecklist(dialog)
  await dialog.getByRole('button', { name: 'Resume the run' }).click()
  await end.getByText('✓ Done').waitFor()
  await page.getByText('resumed 1×').first().waitFor()

  expect(faults).toEqual([])
  await releaseControl(page)
  await context.close()
})

it('a run is started, paused and aborted by keyboard alone', { tags: ['soak'] }, async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
  await page.goto('/runs?start=pegmatite_map.yaml')
  await page.getByText('1,071 points').waitFor()
  for (const point of [/^enclosure closed$/, /^nobody in the beam path$/, /^sample fixed$/]) {
    await tabTo(page, point)
    await page.keyboard.press('Space')
  }
  await tabTo(page, /^Start$/)
  await page.keyboard.press('Enter')
  await page.getByRole('dialog').waitFor()
  await tabTo(page, /^Start now$/)
  await page.keyboard.press('Enter')
  await page.waitForURL('**/runs/2*')
  await page.getByRole('button', { name: 'Pause' }).waitFor()
  await tabTo(page, /^Pause$/)
  await page.keyboard.press('Enter')
  await tabTo(page, /^Pause now/)
  await page.keyboard.press('Enter')
  await page.getByText('Paused: nothing moves').waitFor()
  await tabTo(page, /^Abort$/)
  await page.keyboard.press('Enter')
  await tabTo(page, /^Abort the run$/)
  await page.keyboard.press('Enter')
  await page.getByRole('region', { name: 'How it ended' }).getByText('The run was aborted').waitFor()

  expect(faults).toEqual([])
  await releaseControl(page)
  await context.close()
})

it('from the empty first start to a finished map, by keyboard alone', { tags: ['soak'] }, async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, {})
  const press = async (name: RegExp, key = 'Enter'): Promise<void> => {
    await tabTo(page, name)
    await page.keyboard.press(key)
  }
  const fill = async (name: RegExp, words: string): Promise<void> => {
    await press(name, 'Control+a')
    await page.keyboard.type(words)
  }
  await page.goto('/')
  await page.getByRole('heading', { name: 'Welcome to labrun' }).waitFor()
  await fill(/^Your name/, 'Ada')
  await press(/^Next$/)
  await page.getByText('devices are online').waitFor()
  await press(/^Next$/)
  await press(/^Go to the protocols/)
  await page.getByRole('link', { name: 'Pegmatite map', exact: true }).waitFor()
  await press(/^Pegmatite map$/)
  await page.getByRole('status', { name: 'Check' }).filter({ hasText: 'no problems' }).waitFor()
  await press(/^Run$/)
  await page.getByText('1,071 points').waitFor()
  await fill(/^width/, '0.4')
  await fill(/^height/, '0.4')
  for (const point of [/^enclosure closed$/, /^nobody in the beam path$/, /^sample fixed$/]) await press(point, 'Space')
  await page.getByText('9 points').first().waitFor()
  await press(/^Start$/)
  await page.getByRole('dialog').waitFor()
  await press(/^Start now$/)
  const end = page.getByRole('region', { name: 'How it ended' })
  await end.getByText('✓ Done').waitFor()
  await press(/^Look at the results$/)
  await page.getByRole('region', { name: 'Map', exact: true }).getByText('9 of 9 cells measured').waitFor()
  await picture(page, 'keys-results')

  expect(faults).toEqual([])
  await releaseControl(page)
  await context.close()
})
