// The browser of the journeys: Debian's chromium, one context per person.
import { existsSync } from 'node:fs'
import { type Browser, type BrowserContext, type BrowserContextOptions, chromium, type Locator, type Page } from 'playwright-core'
import { ask, type Bench } from './bench'

const PLACES = [process.env['CHROMIUM'], '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome']

/** A machine that is busy shows it later, not otherwise; whoever waits for what never comes is told after this. */
const PATIENCE_MS = 180_000
const SHOWN_MS = 10_000

// The list of Playwright that this replaces, as far as it matters on loopback, and the pop-ups of an address bar that nobody
// sees: half a second of a processor for each of them in each window.
const WITHOUT = [
  'AvoidUnnecessaryBeforeUnloadCheckSync', 'DestroyProfileOnBrowserClose', 'HttpsUpgrades', 'HttpsFirstBalancedModeAutoEnable',
  'MediaRouter', 'PaintHolding', 'OptimizationHints', 'NetworkTimeServiceQuerying', 'AimEnabled', 'PreconnectToSearch',
  'WebUIOmniboxPopup', 'WebUIOmniboxAimPopup',
]

export const NARROW = { width: 390, height: 844 }
export const WIDE = { width: 1360, height: 860 }

export async function openBrowser(): Promise<Browser> {
  const path = PLACES.find((one) => one !== undefined && existsSync(one))
  if (path === undefined) throw new Error('no chromium: apt-get install chromium, or set CHROMIUM')
  return chromium.launch({ executablePath: path, args: ['--no-sandbox', '--disable-dev-shm-usage', `--disable-features=${WITHOUT.join(',')}`] })
}

/** After a failed journey: say what its pages showed, close its browser, stop what is still moving, release control. */
export async function tidy(browser: Browser, bench: Bench): Promise<void> {
  const left = browser.contexts()
  if (left.length === 0) return
  for (const page of left.flatMap((context) => context.pages())) {
    process.stderr.write(`${page.url()} showed:\n${await page.locator('body').innerText({ timeout: SHOWN_MS }).catch(String)}\n`)
  }
  await Promise.all(left.map((context) => context.close()))
  await ask(bench, '/stop', {})
  const { lease } = await ask<{ lease: string }>(bench, '/control/take', { name: 'Program', reason: 'a journey failed' })
  await ask(bench, '/control/release', {}, { 'X-Control-Lease': lease })
}

export interface Person {
  context: BrowserContext
  page: Page
  /** Errors in the page itself, as it reported them. */
  faults: string[]
}

/** A person with a browser of their own, who has opened the printed address of a bench; `known` is what it remembers. */
export async function aPerson(
  browser: Browser, entry: string, options: BrowserContextOptions = {}, known: Record<string, unknown> = { welcomed: true },
): Promise<Person> {
  const context = await browser.newContext({ viewport: WIDE, baseURL: new URL(entry).origin, reducedMotion: 'reduce', ...options })
  context.setDefaultTimeout(PATIENCE_MS)
  if (entry.includes('token=')) await context.request.get(entry, { maxRedirects: 0 })
  await context.addInitScript((preferences) => {
    if (localStorage.getItem('labrun.preferences') === null) {
      localStorage.setItem('labrun.preferences', JSON.stringify(preferences))
    }
  }, known)
  const page = await context.newPage()
  const faults: string[] = []
  page.on('pageerror', (error) => faults.push(error.message))
  return { context, page, faults }
}

/** Wait until the page receives data from the server. */
export async function isLive(page: Page): Promise<void> {
  await page.getByRole('status', { name: 'Connection' }).filter({ hasText: 'live' }).waitFor()
}

/** Release control, by as many clicks as it takes: on a slow machine one may come too late for the server, which says so. */
export async function releaseControl(page: Page): Promise<void> {
  const release = page.getByRole('button', { name: 'Release control' })
  const free = page.getByRole('button', { name: 'Take control' })
  while (await release.isVisible()) {
    await release.click()
    await free.waitFor({ timeout: 10_000 }).catch(() => undefined)
  }
}

/**
 * Order something, and again if the page says that a busy machine brought the click too late or not at all, or that no answer came
 * and it is still not done; until `done` shows.
 */
export async function ordered(page: Page, press: () => Promise<void>, done: Locator): Promise<void> {
  const late = page.getByRole('alert').filter({ hasText: /after its deadline|not sent|no answer/i })
  do {
    await press()
    await done.or(late).first().waitFor()
    await done.first().waitFor({ timeout: SHOWN_MS }).catch(() => undefined)
  } while (!(await done.first().isVisible()))
}

/** Abort the run that the page shows; `done` says that it was. */
export async function aborted(page: Page, done: Locator): Promise<void> {
  await ordered(page, async () => {
    await page.getByRole('button', { name: 'Abort', exact: true }).click()
    await page.getByRole('button', { name: 'Abort the run' }).click()
  }, done)
}

/** Let the paused run that the page shows go on. */
export async function goOn(page: Page): Promise<void> {
  const goes = page.getByRole('button', { name: 'Pause', exact: true }).or(page.getByRole('region', { name: 'How it ended' }))
  const resume = page.getByRole('button', { name: 'Resume', exact: true })
  await ordered(page, () => resume.click({ timeout: SHOWN_MS }).catch(() => undefined), goes)
}

/** Wait until every device of the bench is online. */
export async function allOnline(page: Page): Promise<void> {
  await page.getByText(/^([1-9]\d*) of \1 online$/).waitFor()
}

/** Tick every box of the checklist before a run resumes, once the settings that hold the list have come. */
export async function tickChecklist(dialog: Locator): Promise<void> {
  const boxes = dialog.getByRole('group', { name: 'Before it resumes' }).getByRole('checkbox')
  await boxes.first().waitFor()
  for (const box of await boxes.all()) await box.check()
}

/** Press Tab until an element with this name has the focus, as a person without a mouse does. */
export async function tabTo(page: Page, name: RegExp): Promise<void> {
  for (let presses = 0; presses < 140; presses += 1) {
    await page.keyboard.press('Tab')
    const words = await page.evaluate(() => {
      const at = document.activeElement
      const label = at instanceof HTMLInputElement || at instanceof HTMLSelectElement ? at.labels?.[0]?.textContent : at?.textContent
      return (at?.getAttribute('aria-label') ?? label ?? '').trim()
    })
    if (name.test(words)) return
  }
  throw new Error(`no Tab leads to ${name.source}`)
}
