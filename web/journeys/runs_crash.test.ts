// Runs belong to no server and no tab: the server is killed mid-run, started again, and the page finds the run.
import { readFile, rm, writeFile } from 'node:fs/promises'
import { join } from 'node:path'
import type { Browser } from 'playwright-core'
import { afterAll, afterEach, beforeAll, expect, it } from 'vitest'
import { aGantryAlone, ask, type Bench, startBench } from './bench'
import { aborted, aPerson, isLive, openBrowser, tidy } from './browser'
import { picture } from './look'

/** A minute of turns on the simulated lab, without the optics. */
const SLOW = `labrun: 1
name: slow-loop
devices: {gantry: gantry@1}
steps:
  - foreach: {point: "\${{ grid(x=span(0, 9 mm, 1 mm), y=span(0, 9 mm, 1 mm), order='snake') }}"}
    key: \${{ point.ix }},\${{ point.iy }}
    steps:
      - {id: travel, do: gantry.move_to, with: {x: "\${{ point.x }}", y: "\${{ point.y }}"}}
      - {wait: 500 ms}
`
let folder: string
let bench: Bench
let browser: Browser
beforeAll(async () => {
  folder = await aGantryAlone()
  await writeFile(join(folder, 'slow.yaml'), SLOW)
  ;[bench, browser] = await Promise.all([startBench({ args: [folder, '--lab', join(folder, 'lab.yaml')] }), openBrowser()])
})
afterEach(() => tidy(browser, bench))
afterAll(async () => {
  await browser.close()
  await bench.close()
  await rm(folder, { recursive: true, force: true })
})

it('a server that is killed mid-run leaves the run going, and the page finds it again', async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
  await page.goto('/runs?start=slow.yaml')
  await page.getByRole('button', { name: 'Start', exact: true }).click()
  await page.waitForURL('**/runs/2*')
  const id = new URL(page.url()).pathname.split('/').at(-1) ?? ''
  const map = page.getByRole('region', { name: 'Map' })
  await map.getByText(/ok [3-9]/).waitFor()

  bench.signal('SIGKILL')
  await page.getByText(/No connection for/).waitFor()
  await picture(page, 'run-server-killed')
  await page.getByRole('button', { name: 'Abort' }).click()
  await page.getByRole('button', { name: 'Abort the run' }).click()
  await page.getByText(/Not sent: no connection/).waitFor()

  bench = await startBench({ args: [folder, '--lab', join(folder, 'lab.yaml')], port: bench.port })
  await isLive(page)
  await page.waitForFunction(() => /ok ([2-9]\d|\d{3})/.test(document.querySelector('main')?.textContent ?? ''), null)
  const told = await ask<{ fate: string; live: boolean; done: number }>(bench, `/runs/${id}`)

  expect(told).toMatchObject({ fate: 'running', live: true })
  expect(told.done).toBeGreaterThan(9)

  await picture(page, 'run-server-back')
  await aborted(page, page.getByRole('region', { name: 'How it ended' }).getByText('The run was aborted'))

  expect(faults).toEqual([])
  await context.close()
})

it('an engine that is killed leaves an interrupted run, which is resumed from the page', async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
  await ask(bench, '/control/take', { name: 'Program', reason: 'a journey' }).then(async (taken) => {
    await ask(bench, '/control/release', {}, { 'X-Control-Lease': (taken as { lease: string }).lease })
  })
  await page.goto('/runs?start=slow.yaml')
  await page.getByRole('button', { name: 'Start', exact: true }).click()
  await page.waitForURL('**/runs/2*')
  const id = new URL(page.url()).pathname.split('/').at(-1) ?? ''
  await page.getByRole('region', { name: 'Map' }).getByText(/ok [3-9]/).waitFor()
  process.kill(await engineOf(join(folder, 'runs', id)), 'SIGKILL')
  const end = page.getByRole('region', { name: 'How it ended' })
  await end.getByText('Its engine is gone').waitFor()
  await picture(page, 'run-engine-killed')
  await end.getByRole('button', { name: 'Resume', exact: true }).click()
  await page.getByRole('button', { name: 'Resume the run' }).click()
  await page.getByText('resumed 1×').first().waitFor()
  await aborted(page, end.getByText('The run was aborted'))

  expect((await ask<{ resumes: number }>(bench, `/runs/${id}`)).resumes).toBe(1)
  expect(faults).toEqual([])
  await context.close()
})

/** The process of a live run's engine, from its lock. */
async function engineOf(run: string): Promise<number> {
  const told = JSON.parse(await readFile(join(run, 'control.json'), 'utf8')) as { pid: number }
  return told.pid
}
