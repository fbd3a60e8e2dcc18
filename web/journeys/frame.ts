// The frame: welcome, places, control between two people, themes, keys.
import { describe, expect, it } from 'vitest'
import { ask } from './bench'
import { allOnline, aPerson, isLive, NARROW, releaseControl, tabTo } from './browser'
import { picture } from './look'
import { bench, browser } from './stage'

describe('the frame', () => {
  it('lets a browser of the same user in by the plain address', async () => {
    const { page, context, faults } = await aPerson(browser, bench.address)
    await page.goto('/runs')
    await isLive(page)

    expect(faults).toEqual([])

    await context.close()
  })

  it('welcomes a new user in three steps', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, {}, {})
    await page.goto('/')
    await page.getByRole('heading', { name: 'Welcome to labrun' }).waitFor()
    await picture(page, 'welcome')
    await page.getByLabel('Your name').fill('Ada')
    await page.getByRole('button', { name: 'Next' }).click()
    await page.getByText('devices are online').waitFor()
    await page.getByRole('button', { name: 'Next' }).click()
    await picture(page, 'welcome-3')
    await page.getByRole('button', { name: 'Go to the protocols' }).click()
    await page.waitForURL('**/protocols')
    await page.goto('/')
    await page.waitForURL('**/protocols')

    expect(faults).toEqual([])

    await context.close()
  })

  it('leads to its five places by links and by keys', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto('/settings')
    for (const place of ['Devices', 'Protocols', 'Runs', 'Results', 'Settings']) {
      const link = page.getByRole('link', { name: place, exact: true })
      await link.click()
      await page.waitForURL(`**/${place.toLowerCase()}`)

      expect(await link.getAttribute('aria-current')).toBe('page')
      expect(await page.title()).toContain(place)
    }
    for (const [key, place] of [['d', 'devices'], ['p', 'protocols'], ['r', 'runs'], ['e', 'results'], ['s', 'settings']] as const) {
      await page.keyboard.press('g')
      await page.keyboard.press(key)
      await page.waitForURL(`**/${place}`)
    }
    await page.keyboard.press('?')
    await page.getByRole('dialog', { name: 'Keyboard shortcuts' }).waitFor()
    await picture(page, 'shortcuts')

    expect(await page.getByRole('button', { name: 'Stop all devices' }).isEnabled()).toBe(true)

    await page.getByRole('dialog').getByLabel('Single-letter keys').uncheck()
    await page.keyboard.press('Escape')
    await page.getByRole('dialog').waitFor({ state: 'detached' })
    await page.keyboard.press('g')
    await page.keyboard.press('d')
    await page.waitForTimeout(300)

    expect(new URL(page.url()).pathname).toBe('/settings')
    expect(faults).toEqual([])

    await context.close()
  })

  it('skips to the content with the first Tab', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await page.goto('/settings')
    await isLive(page)
    await page.keyboard.press('Tab')
    await page.keyboard.press('Enter')

    expect(await page.evaluate(() => document.activeElement?.id)).toBe('main')

    await context.close()
  })

  it('is used with the keyboard alone, from the first Tab to a moved gantry', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
    await page.goto('/settings')
    await isLive(page)
    const x = async () => (await ask<{ status: { x: number } }>(bench, '/devices/gantry')).status.x
    await tabTo(page, /^Take control$/)
    await page.keyboard.press('Enter')
    await page.getByRole('button', { name: 'Release control' }).waitFor()
    await page.keyboard.press('g')
    await page.keyboard.press('d')
    await allOnline(page)
    const before = await x()
    await tabTo(page, /^X[+]$/)
    await page.keyboard.press('Space')
    await expect.poll(x).toBeCloseTo(before + 1, 2)
    await tabTo(page, /^Release control$/)
    await page.keyboard.press('Enter')
    await page.getByRole('button', { name: 'Take control' }).waitFor()

    expect(faults).toEqual([])

    await context.close()
  })

  it('remembers the theme and follows the system without one', async () => {
    const { page, context } = await aPerson(browser, bench.entry, { colorScheme: 'dark' })
    await page.goto('/settings')
    const theme = () => page.evaluate(() => document.documentElement.dataset['theme'])

    expect(await theme()).toBe('dark')

    await page.getByLabel('light', { exact: true }).check()
    await page.reload()
    await isLive(page)

    expect(await theme()).toBe('light')

    await context.close()
  })

  it('lets two people see and pass on control', async () => {
    const ada = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
    const bo = await aPerson(browser, bench.entry, { viewport: NARROW }, { welcomed: true, name: 'Bo' })
    await Promise.all([ada.page.goto('/settings'), bo.page.goto('/settings')])
    await Promise.all([isLive(ada.page), isLive(bo.page)])
    await ada.page.getByRole('button', { name: 'Take control' }).click()
    await ada.page.getByRole('button', { name: 'Release control' }).waitFor()

    expect((await ask<{ holder: string }>(bench, '/control')).holder).toBe('Ada')

    await bo.page.getByRole('button', { name: 'Take control' }).click()
    const dialog = bo.page.getByRole('dialog', { name: 'Ada has control' })
    await dialog.getByRole('button', { name: 'Ask Ada for control' }).click()
    await dialog.getByText('Ada was asked').waitFor()
    await ada.page.getByText('Bo asks Ada for control').waitFor()
    await picture(bo.page, 'control-390')
    await dialog.getByLabel(/Or take over/).fill('Ada is at lunch')
    await dialog.getByRole('button', { name: 'Take over' }).click()
    await bo.page.getByRole('button', { name: 'Release control' }).waitFor()
    await ada.page.getByRole('button', { name: 'Take control' }).waitFor()
    await ada.page.getByText('Ada is at lunch').first().waitFor()
    await bo.page.reload()
    await bo.page.getByRole('button', { name: 'Release control' }).waitFor()
    await releaseControl(bo.page)

    expect((await ask<{ holder: string | null }>(bench, '/control')).holder).toBeNull()
    expect([...ada.faults, ...bo.faults]).toEqual([])

    await ada.context.close()
    await bo.context.close()
  })

  it('saves the settings of the bench', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await page.goto('/devices')
    await isLive(page)
    let answer: (value?: unknown) => void = () => undefined
    const written = new Promise((resolve) => { answer = resolve })
    await page.route('**/api/v1/settings', async (route) => {
      if (route.request().method() === 'GET') await written
      await route.continue()
    })
    await page.getByRole('link', { name: 'Settings' }).click()
    await page.getByLabel('Who works here, one per line').fill('Ada\nBo')
    await page.getByLabel('Step sizes of the jog pad, in mm').fill('0.05 0,5 5')
    const arrived = page.waitForResponse('**/api/v1/settings')
    answer()
    await arrived
    await page.getByRole('button', { name: 'Save' }).click()
    await page.getByText('Saved.').waitFor()
    await picture(page, 'settings')
    const { settings } = await ask<{ settings: { operators: string[]; step_sizes_mm: number[] } }>(bench, '/settings')

    expect(settings.operators).toEqual(['Ada', 'Bo'])
    expect(settings.step_sizes_mm).toEqual([0.05, 0.5, 5])

    await context.close()
  })
})
