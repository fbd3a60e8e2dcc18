// The frame: places, connection, control, STOP ALL, themes, keys.
import type { Browser } from 'playwright-core'
import { afterAll, beforeAll, describe, expect, it } from 'vitest'
import { ask, type Bench, startBench } from './bench'
import { aPerson, openBrowser } from './browser'
import { picture } from './look'

let bench: Bench
let browser: Browser
beforeAll(async () => {
  ;[bench, browser] = await Promise.all([startBench(), openBrowser()])
})
afterAll(async () => {
  await browser.close()
  await bench.close()
})

describe('the frame', () => {
  it('welcomes whoever comes first, in three steps', async () => {
    const { page, context, faults } = await aPerson(browser, bench.address, {}, {})
    await page.goto('/')
    await page.getByRole('heading', { name: 'Welcome to labrun' }).waitFor()
    await picture(page, 'welcome')
    await page.getByLabel('Your name').fill('Ada')
    await page.getByRole('button', { name: 'Next' }).click()
    await page.getByText('of 6 devices are online').or(page.getByText('devices are online')).waitFor()
    await picture(page, 'welcome-2')
    await page.getByRole('button', { name: 'Next' }).click()
    await page.getByRole('button', { name: 'Go to the protocols' }).click()
    await page.waitForURL('**/protocols')

    expect(faults).toEqual([])

    await page.getByRole('button', { name: 'Take control' }).click()
    await page.getByRole('button', { name: 'Release control' }).waitFor()

    expect((await ask<{ holder: string }>(bench, '/control')).holder).toBe('Ada')

    await page.getByRole('button', { name: 'Release control' }).click()
    await page.getByRole('button', { name: 'Take control' }).waitFor()
    await context.close()
  })
})
