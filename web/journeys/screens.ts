// Every screen, light and wide, dark at 390 pixels, and in lab mode at 1920: axe finds nothing, and nothing sticks out.
import { describe, expect, it } from 'vitest'
import { aPerson, isLive, NARROW, WIDE } from './browser'
import { axe, picture } from './look'
import { bench, browser } from './stage'

const SCREENS = [
  '/devices/gantry', '/devices/libs', '/devices/camera', '/protocols', '/protocols/hello.yaml', '/protocols/pegmatite_map.yaml',
  '/runs', '/results', '/samples', '/compare', '/settings', '/nowhere',
]
const LOOKS = [
  { look: 'light', theme: 'light', viewport: WIDE, lab: false, tags: ['soak'] },
  { look: 'dark-390', theme: 'dark', viewport: NARROW, lab: false, tags: [] },
  { look: 'lab-1920', theme: 'dark', viewport: { width: 1920, height: 1080 }, lab: true, tags: ['soak'] },
]


describe.each(LOOKS)('in $look', ({ look, theme, viewport, lab, tags }) => {
  it('every screen is accessible, fits and has one heading', { tags }, async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, { viewport }, { welcomed: true, theme, lab })
    const wrong: string[] = []
    for (const screen of SCREENS) {
      await page.goto(screen)
      await isLive(page)
      await page.getByRole('heading', { level: 1 }).first().waitFor()
      await page.waitForLoadState('networkidle').catch(() => undefined) // a page may keep requesting
      await picture(page, `screen-${look}${screen.replaceAll('/', '-')}`)
      const wider = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth)
      const headings = await page.getByRole('heading', { level: 1 }).count()
      if (wider > 0) wrong.push(`${screen}: ${wider} px wider than the screen`)
      if (headings !== 1) wrong.push(`${screen}: ${headings} headings of the first level`)
      wrong.push(...(await axe(page)).map((one) => `${screen}: ${one}`))
    }

    expect(wrong).toEqual([])
    expect(faults).toEqual([])

    await context.close()
  })
})
