// Runs found again: by words, sample and day; labelled; compared; a sample with all that was measured on it.
import { createServer } from 'node:http'
import type { AddressInfo } from 'node:net'
import { beforeAll, describe, expect, it } from 'vitest'
import { aPerson, isLive, NARROW, tabTo } from './browser'
import { axe, picture } from './look'
import { startRun, until } from './measured'
import { bench, browser } from './stage'

let ids: string[] = []

describe('runs', { tags: ['soak'] }, () => {
  beforeAll(async () => {
    for (const [sample, height] of [['K17', '0.6 mm'], ['K17', '0.4 mm'], ['SPD-07', '0.4 mm']] as const) {
      const run = await startRun(bench, 'pegmatite_map.yaml', { width: '0.6 mm', height, sample })
      await until(bench, run, (told) => told.fate === 'succeeded' && !(told as { live?: boolean }).live)
      ids = [...ids, run]
    }
  }, 240_000)

  it('are found by sample and by size, and a search that means nothing says what there is', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto('/runs')
    await isLive(page)
    const list = page.getByRole('list', { name: 'All runs' })
    await list.getByRole('link', { name: 'SPD-07' }).waitFor()
    const search = page.getByRole('searchbox', { name: 'Search runs' })
    await search.fill('sample:K17 height>=0.5mm')
    await page.getByText('1 found').waitFor()
    await picture(page, 'finding-runs')

    expect(await list.getByText(ids[0] ?? '', { exact: true }).count()).toBe(1)
    expect(new URL(page.url()).searchParams.get('find')).toBe('sample:K17 height>=0.5mm')
    expect(await axe(page)).toEqual([])

    await search.fill('colour:red')
    await page.getByRole('alert').getByText('there is no colour:').waitFor()

    expect(await list.count()).toBe(0)
    await page.getByText('How to search').click()
    await picture(page, 'finding-help')

    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await context.close()
  })

  it('are compared: parameters, values, maps on one scale with their difference, spectra', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, { viewport: { width: 1366, height: 768 } })
    await page.goto('/runs')
    for (const id of ids.slice(0, 2)) await page.getByRole('checkbox', { name: `Compare ${id}` }).check()
    await page.getByRole('link', { name: 'Compare 2 runs' }).click()
    const table = page.getByRole('region', { name: 'Runs side by side' })
    await table.getByRole('row', { name: /height/ }).getByText('0.4 mm').waitFor()
    await page.getByRole('img', { name: /^Difference of 2\. K17/ }).waitFor()
    await page.getByText('16 spectra').waitFor()
    await picture(page, 'finding-compare')

    expect(await table.getByRole('row', { name: /sample/ }).count()).toBe(0)
    expect(await axe(page)).toEqual([])
    await page.mouse.wheel(0, 1400)
    await page.waitForTimeout(300)
    await picture(page, 'finding-compare-below')

    expect(faults).toEqual([])
    await context.close()
  })

  it('are labelled, and all of one sample is on one page, by keys alone', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto(`/results/${ids[2] ?? ''}`)
    await page.getByRole('region', { name: 'Map', exact: true }).waitFor()
    await tabTo(page, /^Label: sample/)
    await page.keyboard.press('Enter')
    await tabTo(page, /^Sample/)
    await page.keyboard.type('K17')
    await page.keyboard.press('Tab')
    await page.keyboard.type('good again')
    await page.keyboard.press('Enter')
    await page.getByRole('link', { name: '#again' }).waitFor()
    await tabTo(page, /^K17$/)
    await page.keyboard.press('Enter')
    await page.getByRole('heading', { name: 'K17', level: 1 }).waitFor()
    await page.getByRole('list', { name: 'Runs of K17' }).getByText(ids[2] ?? '', { exact: true }).waitFor()
    await page.getByText(`Spectra of K17 in ${ids[0] ?? ''}`).click()
    await page.getByRole('link', { name: '1,2', exact: true }).waitFor()
    await page.getByText('12 spectra').first().waitFor()
    await picture(page, 'finding-sample')

    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await context.close()
  })

  it('show one number with its limits, on a narrow dark screen as well', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, { viewport: NARROW, colorScheme: 'dark' })
    await page.goto('/runs?find=K17')
    await page.getByLabel('Show over these runs').selectOption('data.Si')
    const chart = page.getByRole('group', { name: 'data.Si of 3 runs' })
    await chart.getByText(/^mean/).waitFor()
    await expect.poll(() => chart.getAttribute('viewBox')).toMatch(/^0 0 3\d\d /) // as wide as its panel
    await chart.scrollIntoViewIfNeeded()
    await picture(page, 'finding-chart-narrow-dark')
    await page.getByRole('textbox', { name: 'Upper limit' }).pressSequentially('0,5', { delay: 50 })
    await page.keyboard.press('Enter')
    await expect.poll(() => page.getByRole('list', { name: 'Outside of the limits' }).getByRole('listitem').count()).toBe(3)
    await page.reload()
    await page.getByRole('list', { name: 'All runs' }).getByText(/^✕ data\.Si .*, above 0\.5$/).first().waitFor()
    await picture(page, 'finding-limits-narrow-dark')

    expect(new URL(page.url()).search).toBe('?find=K17&value=data.Si&high=0.5')
    await page.evaluate(() => scrollTo(0, 0))

    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(390)
    expect(await axe(page)).toEqual([])
    await page.goto(`/compare?run=${ids[0] ?? ''}&run=${ids[1] ?? ''}`)
    await page.getByRole('img', { name: /^Difference of 2\. K17/ }).waitFor()
    await picture(page, 'finding-compare-narrow-dark')

    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(390)
    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await context.close()
  })
})

describe('people elsewhere', () => {
  it('are told by a chat of what a person chose, after a test, and it is kept', async () => {
    const got: string[] = []
    const chat = createServer((request, response) => {
      request.on('data', (part: Buffer) => got.push(part.toString())).on('end', () => response.end())
    }).listen(0, '127.0.0.1')
    await new Promise((resolve) => chat.once('listening', resolve))
    const to = `json://127.0.0.1:${(chat.address() as AddressInfo).port}/hook`
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto('/settings')
    await page.getByRole('button', { name: 'Add a person or program' }).click()
    await page.getByLabel('Address of 1').fill('json://127.0.0.1:9/hook')
    await page.getByRole('button', { name: 'Send a test' }).click()
    await page.getByRole('alert').getByText('json:').waitFor()
    await page.getByLabel('Address of 1').fill(to)
    await page.getByRole('button', { name: 'Send a test' }).click()
    await page.getByText('sent to json').waitFor()
    await page.getByLabel('a run is done').check()
    await page.getByRole('button', { name: 'Apply' }).click()
    await page.getByText('Saved.').waitFor()
    await picture(page, 'finding-notify')

    expect(await axe(page)).toEqual([])
    await page.reload()

    expect(await page.getByLabel('Address of 1').inputValue()).toBe(to)
    const run = await startRun(bench, 'pegmatite_map.yaml', { width: '0.2 mm', height: '0.2 mm' })
    await until(bench, run, (told) => told.fate === 'succeeded')
    await expect.poll(() => got.join()).toContain('succeeded')

    expect(got[0]).toContain('This is a test')
    expect(faults).toEqual([])
    await context.close()
    chat.close()
  }, 120_000)
})
