// Reached over the network: nothing but the form and STOP ALL until the token is entered, then everything.
import { rm } from 'node:fs/promises'
import type { Browser } from 'playwright-core'
import { afterAll, beforeAll, expect, it, vi } from 'vitest'
import { aGantryAlone, ask, type Bench, startBench } from './bench'
import { allOnline, aPerson, isLive, NARROW, openBrowser } from './browser'
import { axe, picture } from './look'

const TOKEN = 'correct-horse-battery'
let folder: string
let bench: Bench
let browser: Browser
beforeAll(async () => {
  folder = await aGantryAlone()
  ;[bench, browser] = await Promise.all([
    startBench({ args: ['--lab', 'lab.yaml', '--host', '0.0.0.0', '--token', TOKEN], cwd: folder }), openBrowser(),
  ])
  const headers = { Authorization: `Bearer ${TOKEN}` }
  const reach = async (): Promise<string> =>
    (await ask<{ reach: string }>(bench, '/devices/gantry', undefined, headers)).reach
  await vi.waitUntil(async () => (await reach()) === 'online', { timeout: 120_000, interval: 200 })
})
afterAll(async () => {
  await browser.close()
  await bench.close()
  await rm(folder, { recursive: true, force: true })
})

it('a browser signs in with the token, stays signed in across a reload, and can stop all before', async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry, { viewport: NARROW })
  await page.goto('/devices/gantry')
  await page.getByRole('heading', { level: 1, name: 'Sign in' }).waitFor()

  expect(await page.getByRole('button', { name: 'Take control' }).count()).toBe(0)
  expect(await axe(page)).toEqual([])

  await page.getByLabel('Token').fill('a guess')
  await page.getByRole('button', { name: 'Sign in' }).click()
  await page.getByRole('alert').filter({ hasText: 'the token is wrong' }).waitFor()
  await picture(page, 'sign-in')
  await page.getByRole('button', { name: 'Stop all devices' }).click()
  await page.getByRole('status', { name: 'Stop', exact: true }).getByText(/gantry ✓/).waitFor()
  await page.getByLabel('Token').fill(TOKEN)
  await page.keyboard.press('Enter')
  await isLive(page)
  await allOnline(page)
  await page.reload()
  await isLive(page)
  await page.goto('/settings')
  await page.getByRole('button', { name: 'Sign out' }).click()
  await page.getByRole('heading', { level: 1, name: 'Sign in' }).waitFor()

  expect((await page.request.get('/api/v1/runs')).status()).toBe(401)
  expect(faults).toEqual([])
  await context.close()
})

it('a browser whose sign-in is unknown to a new server must sign in again', async () => {
  const { page, context, faults } = await aPerson(browser, bench.entry)
  await page.goto('/settings')
  await page.getByLabel('Token').fill(TOKEN)
  await page.keyboard.press('Enter')
  await isLive(page)
  const { port } = bench
  await bench.close()
  bench = await startBench({ port, args: ['--lab', 'lab.yaml', '--host', '0.0.0.0', '--token', 'another-token-now'], cwd: folder })
  await page.getByRole('heading', { level: 1, name: 'Sign in' }).waitFor()
  await page.getByLabel('Token').fill('another-token-now')
  await page.keyboard.press('Enter')
  await isLive(page)

  expect(faults).toEqual([])
  await context.close()
})
