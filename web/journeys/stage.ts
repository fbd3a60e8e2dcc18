// One bench and one browser for journeys that follow one another: each person has a context of their own.
import type { Browser } from 'playwright-core'
import { afterAll, afterEach, beforeAll } from 'vitest'
import { type Bench, startBench } from './bench'
import { openBrowser, tidy } from './browser'

export let bench: Bench
export let browser: Browser
beforeAll(async () => {
  ;[bench, browser] = await Promise.all([startBench(), openBrowser()])
}, 120_000)
afterEach(() => tidy(browser, bench))
afterAll(async () => {
  await browser.close()
  await bench.close()
})
