// Results: a map and its spectra, points selected and measured again, plasma and classes, tables, files.
import { readFileSync } from 'node:fs'
import { describe, expect, it } from 'vitest'
import { ask } from './bench'
import { aPerson, isLive, NARROW } from './browser'
import { axe, picture } from './look'
import { measuredMap, startRun, until } from './measured'
import { bench, browser } from './stage'

let run: string

describe('results', () => {
  it('are empty at first, and the page says what to do', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto('/results')
    await isLive(page)
    await page.getByText('No run has measured anything yet').waitFor()

    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await context.close()
  })

  it('are a map and the spectrum of the point under the cursor', async () => {
    run = await measuredMap(bench)
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto('/results')
    await page.getByRole('list', { name: 'Runs with results' }).getByRole('link', { name: 'Pegmatite map' }).click()
    const map = page.getByRole('region', { name: 'Map', exact: true })
    await map.getByText('48 of 48 cells measured').waitFor()
    await map.getByRole('application').focus()
    await page.keyboard.press('ArrowUp')
    await page.keyboard.press('ArrowRight')
    await map.getByText('(0.2, 0.2) mm').waitFor()
    const spectrum = page.getByRole('region', { name: 'Spectrum' })
    await spectrum.getByText('point 11 (0.2, 0.2)').first().waitFor()
    await spectrum.locator('canvas').first().waitFor()
    await picture(page, 'results')

    expect(await axe(page)).toEqual([])

    await spectrum.getByRole('button', { name: 'Pin' }).click()
    await map.getByRole('application').focus()
    await page.keyboard.press('End')
    await spectrum.getByText('point 7').first().waitFor()
    await spectrum.getByRole('button', { name: 'peaks' }).click()
    await spectrum.getByRole('button', { name: 'fit', exact: true }).click()
    await spectrum.getByText(/Plasma [\d,]+ K/).waitFor()
    await picture(page, 'results-fit')
    const [png] = await Promise.all([page.waitForEvent('download'), spectrum.getByRole('button', { name: 'PNG' }).click()])
    const opaque = await page.evaluate(async (src) => {
      const image = new Image()
      image.src = src
      await image.decode()
      const ctx = new OffscreenCanvas(1, 1).getContext('2d')
      ctx?.drawImage(image, 0, 0)
      return ctx?.getImageData(0, 0, 1, 1).data[3]
    }, `data:image/png;base64,${readFileSync(await png.path()).toString('base64')}`)

    expect(opaque).toBe(255)

    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await context.close()
  }, 300_000)

  it('give a mean of selected points, and a protocol that measures them again', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto(`/results/${run}`)
    const map = page.getByRole('region', { name: 'Map', exact: true })
    const sheet = map.getByRole('application')
    await sheet.focus()
    for (const key of ['Shift+ArrowRight', 'Shift+ArrowUp', 'Shift+ArrowUp']) await page.keyboard.press(key)
    await map.getByText('6 points selected').waitFor()
    await map.getByRole('button', { name: 'Mean spectrum' }).click()
    await page.getByRole('region', { name: 'Spectrum' }).getByText('mean of 6 points').waitFor()
    await map.getByRole('button', { name: 'Clear' }).click()
    await map.getByRole('button', { name: 'lasso' }).click()
    const box = await sheet.boundingBox()
    if (box === null) throw new Error('the map has no box')
    await page.mouse.move(box.x + box.width / 2 - 100, box.y + 40)
    await page.mouse.down()
    for (const [dx, dy] of [[100, 30], [120, 200], [-60, 220]]) await page.mouse.move(box.x + box.width / 2 + (dx ?? 0), box.y + (dy ?? 0), { steps: 6 })
    await page.mouse.up()
    await map.getByText(/\d+ points selected/).waitFor()
    await picture(page, 'results-lasso')
    const chosen = Number(/(\d+) points/.exec(await map.getByText(/\d+ points selected/).innerText())?.[1])
    await map.getByRole('button', { name: 'Measure these again' }).click()
    await page.waitForURL('**/protocols/**')
    const name = decodeURIComponent(new URL(page.url()).pathname.replace('/protocols/', ''))
    const { text } = await ask<{ text: string }>(bench, `/protocols/${encodeURIComponent(name)}`)

    expect(chosen).toBeGreaterThan(4)
    expect(text).toContain(`# ${chosen} points of ${run}, to be measured again`)
    expect(faults).toEqual([])
    await context.close()
  })

  it('explain a point, down to its line of YAML', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto(`/results/${run}?point=2,2`)
    await page.getByRole('button', { name: 'Why this point?' }).click()
    const point = page.getByRole('region', { name: 'Point', exact: true })
    await point.getByText('shoot · libs.measure').waitFor()
    await point.getByText('Log of this point').click()
    await point.getByText('libs.measure ok').waitFor()
    await point.getByRole('listitem').filter({ hasText: 'shoot · libs.measure' }).getByRole('button', { name: /line/ }).click()
    await page.getByRole('dialog').getByText('do: libs.measure').waitFor()

    expect(faults).toEqual([])
    await context.close()
  })

  it('are reduced to plasma and classes, shown as a table, and downloaded', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto(`/results/${run}`)
    const reduce = page.getByRole('region', { name: 'Plasma and classes' })
    await reduce.getByRole('button', { name: 'Reduce the spectra' }).click()
    await reduce.getByRole('button', { name: 'Map of the classes' }).click()
    const map = page.getByRole('region', { name: 'Map', exact: true })
    await map.getByText(/class 1: \d+/).waitFor()
    await picture(page, 'results-classes')

    expect(await axe(page)).toEqual([])

    await reduce.getByRole('button', { name: 'Map of the temperature' }).click()
    await map.getByRole('button', { name: 'Show as table' }).click()
    await map.getByRole('columnheader', { name: 'temperature_k' }).waitFor()
    await picture(page, 'results-table')
    await page.getByRole('button', { name: 'Download' }).click()
    const menu = page.getByRole('group', { name: 'Downloads' })
    await picture(page, 'results-download')

    expect(await axe(page)).toEqual([])

    for (const [link, ending] of [['CSV', '.csv'], ['Parquet', '.parquet'], ['Run folder (zip)', '.zip']] as const) {
      const [download] = await Promise.all([page.waitForEvent('download'), menu.getByRole('link', { name: link }).first().click()])

      expect(download.suggestedFilename().endsWith(ending)).toBe(true)
    }
    const [svg] = await Promise.all([page.waitForEvent('download'), menu.getByRole('button', { name: 'SVG' }).click()])

    expect(svg.suggestedFilename()).toContain('temperature_k.svg')

    const [png] = await Promise.all([page.waitForEvent('download'), menu.getByRole('button', { name: 'PNG' }).click()])

    const head = readFileSync(await png.path())

    expect(Math.max(head.readUInt32BE(16), head.readUInt32BE(20))).toBe(2400) // its longer side: drawn from the SVG, with axes and colours
    expect(faults).toEqual([])
    await context.close()
  }, 300_000)

  it('fit a narrow screen, dark as well', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, { viewport: NARROW, colorScheme: 'dark' })
    await page.goto(`/results/${run}?point=2,2&map=data.csv/K`)
    await page.getByText('48 of 48 cells measured').waitFor()
    await page.getByLabel('Overlay').selectOption({ label: 'Li' })
    await page.getByText('both').waitFor()
    await picture(page, 'results-narrow-dark')

    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(390)
    expect(await axe(page)).toEqual([])
    expect(faults).toEqual([])
    await context.close()
  })

  it('are a spectrum where a run has no points, and a curve where it has no map', { tags: ['soak'] }, async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    for (const name of ['single', 'titrate']) {
      await ask(bench, '/protocols', { name: `${name}.yaml`, template: name })
      const made = await startRun(bench, `${name}.yaml`)
      await until(bench, made, (told) => told.fate === 'succeeded')
      await page.goto(`/runs/${made}`)
      await page.getByRole('region', { name: 'How it ended' }).getByText(/lithium = \d+\.?\d{0,5} ·|end_point = /).waitFor()
      if (name === 'single') await page.getByRole('region', { name: 'Spectrum' }).getByText('spectra/sample.csv').waitFor()
      await page.goto('/results')
      await page.getByRole('list', { name: 'Runs with results' }).getByRole('listitem').filter({ hasText: made }).getByRole('link').first().click()
      if (name === 'single') await page.getByRole('application', { name: 'Spectrum of spectra/sample.csv' }).waitFor()
      else await page.getByRole('application', { name: 'ph over volume_ml' }).waitFor()
      await picture(page, `results-${name}`)

      expect(await axe(page)).toEqual([])
    }
    expect(faults).toEqual([])
    await context.close()
  })
})
