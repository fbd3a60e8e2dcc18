// Protocols: the list, the editor in all its views, one undo for text and outline, conflicts, drafts.
import type { Page } from 'playwright-core'
import { describe, expect, it } from 'vitest'
import { ask, letIn } from './bench'
import { allOnline, aPerson, NARROW, releaseControl, tabTo } from './browser'
import { axe, picture } from './look'
import { bench, browser } from './stage'

interface Text {
  text: string
  revision: string
}

async function saved(name: string): Promise<Text> {
  return ask<Text>(bench, `/protocols/${name}`)
}

/** A separate protocol for each journey. */
async function copyOf(name: string, of: string): Promise<void> {
  await ask(bench, '/protocols', { name, copy_of: of })
}

/** Open it by its link in the list, as a person does. */
async function open(page: Page, name: string): Promise<void> {
  await page.goto('/protocols')
  await page.getByRole('link', { name, exact: true }).click()
  await page.getByRole('region', { name: 'Outline' }).waitFor()
}

function row(page: Page, name: RegExp | string) {
  return page.getByRole('treegrid', { name: 'Steps' }).getByRole('row', { name })
}

/** Wait until the checker has checked the current text and found no error. */
async function sound(page: Page): Promise<void> {
  await page.getByRole('status', { name: 'Check' }).filter({ hasText: /no problems|^⚠/ }).waitFor()
}

/** The whole text in the editor. */
async function textOf(page: Page): Promise<string> {
  return page.getByRole('textbox', { name: 'Protocol YAML' }).evaluate((dom) => {
    const tile = (dom as unknown as { cmTile?: { view?: { state: { doc: { toString(): string } } } }; cmView?: { view?: { state: { doc: { toString(): string } } } } })
    return (tile.cmTile?.view ?? tile.cmView?.view)?.state.doc.toString() ?? dom.textContent
  })
}

describe('the list of protocols', () => {
  it('searches, creates, copies, deletes and restores', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto('/protocols')
    await page.getByRole('link', { name: 'pegmatite_map.yaml' }).waitFor()
    await picture(page, 'protocols')
    await page.getByRole('searchbox', { name: 'Search protocols' }).fill('stroke')
    await page.getByRole('link', { name: 'pegmatite_map.yaml' }).waitFor({ state: 'detached' })

    await expect.poll(() => page.getByRole('list', { name: 'Protocols' }).getByRole('listitem').count()).toBe(1)

    await page.getByRole('button', { name: 'New protocol' }).click()
    await page.getByRole('radio', { name: 'From an example' }).check()
    await page.getByRole('combobox', { name: 'Example' }).selectOption('grid_scan')
    await page.getByLabel('File name').fill('first try')
    await picture(page, 'protocols-new')
    await page.getByRole('button', { name: 'Create' }).click()
    await page.getByRole('heading', { level: 1, name: 'first_try.yaml' }).waitFor()
    await sound(page)
    await page.getByRole('link', { name: 'All protocols' }).click()
    await page.getByRole('button', { name: 'Delete first_try.yaml' }).click()
    await page.getByRole('button', { name: 'Trash (1)' }).click()
    await page.getByRole('button', { name: 'Restore first_try.yaml' }).click()
    await page.getByText('The trash is empty.').waitFor()
    await page.getByRole('button', { name: 'Close' }).click()
    await page.getByRole('button', { name: 'Copy first_try.yaml' }).click()
    await page.getByRole('heading', { level: 1, name: 'first_try_2.yaml' }).waitFor()

    expect(faults).toEqual([])

    await context.close()
  })
})

describe('a newcomer', () => {
  it('sees what comes of it, chooses a template by its picture, and runs it', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, {}, {})
    await page.goto('/')
    await page.getByRole('button', { name: 'Next' }).click()
    await page.getByRole('button', { name: 'Next' }).click()
    const map = page.getByRole('img', { name: 'Lithium in a simulated core' })
    await map.waitFor()
    await expect.poll(() => map.evaluate((one) => (one as HTMLImageElement).naturalWidth)).toBe(51)
    await expect.poll(() => page.getByRole('button', { name: 'Run the example' }).isEnabled()).toBe(true)
    await picture(page, 'welcome-ways')

    expect(await axe(page)).toEqual([])

    await page.getByRole('button', { name: 'Build a protocol' }).click()
    await page.getByRole('dialog', { name: 'New protocol' }).waitFor()
    await page.getByRole('button', { name: 'A line across' }).click()
    await picture(page, 'protocols-templates')

    expect(await axe(page)).toEqual([])

    await page.getByRole('button', { name: 'Create' }).click()
    await page.getByRole('heading', { level: 1, name: 'Line scan line_scan.yaml' }).waitFor()
    await sound(page)
    await page.getByRole('button', { name: 'Run', exact: true }).click()
    await page.waitForURL('**/runs?start=line_scan.yaml')

    expect(faults).toEqual([])

    await context.close()
  })
})

describe('the editor', () => {
  it('moves, copies, removes and undoes by keyboard, and the comments stay', async () => {
    await copyOf('keys.yaml', 'pegmatite_map.yaml')
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await open(page, 'keys.yaml')
    await sound(page)
    const before = await textOf(page)
    await row(page, /^.*Measure/).click()
    await picture(page, 'editor')
    await page.keyboard.press('Alt+ArrowUp')
    await page.getByText('● unsaved').waitFor()
    const moved = await textOf(page)

    expect(moved.indexOf('id: shoot')).toBeLessThan(moved.indexOf('id: lower'))
    expect(moved).toContain('# never fired twice: see the contract')

    await page.keyboard.press('Control+d')

    expect(await textOf(page)).toContain('id: shoot_2')

    await page.keyboard.press('Delete')
    await page.keyboard.press('Control+z')
    await page.keyboard.press('Control+z')
    await page.keyboard.press('Control+z')

    expect(await textOf(page)).toBe(before)
    expect(faults).toEqual([])

    await context.close()
  })

  it('adds a step and a structure, edits it in the form, and saves', async () => {
    await copyOf('adding.yaml', 'hello.yaml')
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await open(page, 'adding.yaml')
    await row(page, /Move to/).click()
    await page.getByRole('button', { name: 'Add step' }).click()
    await page.getByRole('button', { name: 'libs: measure', exact: true }).waitFor()

    expect(await axe(page)).toEqual([])

    await page.getByRole('searchbox', { name: 'Search steps' }).fill('fire burst')
    await page.getByRole('button', { name: 'libs: measure', exact: true }).click()
    await row(page, /Measure/).and(page.locator('[aria-selected=true]')).waitFor()
    await page.getByRole('region', { name: 'Step' }).getByLabel('Attempts in total').fill('3')
    await page.keyboard.press('Tab')
    await expect.poll(() => textOf(page)).toContain('retry: 3')
    await row(page, /Move to/).click()
    const x = page.getByRole('region', { name: 'Step' }).getByLabel('Y', { exact: true })
    await x.fill('25')
    await x.press('Enter')
    await expect.poll(() => textOf(page)).toContain('y: 25 mm}')
    await page.getByRole('button', { name: 'Add step' }).click()
    await page.getByRole('button', { name: 'For each', exact: true }).click()
    await row(page, /For each/).waitFor()
    await page.getByRole('button', { name: 'Add step' }).click()
    await page.getByRole('button', { name: 'Always at the end', exact: true }).click()
    await sound(page)
    await page.getByRole('button', { name: 'Save' }).click()
    await page.getByText(/^saved /).waitFor()
    const { text } = await saved('adding.yaml')

    expect(text).toContain('do: libs.measure')
    expect(text).toContain('foreach:')
    expect(text).toContain('# two devices at the same time')
    expect(faults).toEqual([])

    await context.close()
  })

  it('watches a group and chooses conditions, without an expression', async () => {
    await copyOf('watching.yaml', 'hello.yaml')
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await open(page, 'watching.yaml')
    const add = async (words: string): Promise<void> => {
      await page.getByRole('button', { name: 'Add step' }).click()
      await page.getByRole('button', { name: words, exact: true }).click()
    }
    const form = page.getByRole('region', { name: 'Step' })
    await row(page, /Write to the log/).click()
    await add('Watch')
    const watch = form.getByRole('group', { name: 'Watch 1' })
    await watch.getByRole('combobox', { name: 'What is looked at' }).selectOption('z of gantry')
    await watch.getByRole('combobox', { name: 'Compared how' }).selectOption('is more than')
    await watch.getByLabel('With what').fill('90')
    await watch.getByLabel('With what').press('Enter')
    await expect.poll(() => textOf(page)).toContain('when: "${{ status.gantry.z > 90 mm }}"')
    await watch.getByRole('combobox', { name: 'Another condition' }).selectOption('armed of libs')
    await watch.getByRole('combobox', { name: 'All, or one of them' }).selectOption('or')
    await watch.getByRole('combobox', { name: /As soon as/ }).selectOption('tell people and fail:')
    await watch.getByRole('textbox', { name: 'With these words' }).fill('too high')
    await watch.getByRole('textbox', { name: 'With these words' }).press('Enter')
    await picture(page, 'editor-watch')
    await row(page, /Steps in order/).click()
    await add('While')
    await form.getByRole('group', { name: 'As long as' }).getByRole('combobox', { name: 'What is looked at' }).selectOption('x of Move to')
    await form.getByLabel('With what').fill('50')
    await form.getByLabel('With what').press('Enter')
    await sound(page)

    expect(await axe(page)).toEqual([])

    const text = await textOf(page)

    expect(text).toContain('{when: "${{ status.gantry.z > 90 mm or status.libs.armed }}", then: [{notify: too high}, {fail: too high}]}')
    expect(text).toContain('while: ${{ steps.travel.x > 50 mm }}')
    expect(faults).toEqual([])

    await context.close()
  })

  it('builds a scan from a blank page by mouse, without an expression', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await page.goto('/protocols')
    await page.getByRole('button', { name: 'New protocol' }).click()
    await page.getByLabel('File name').fill('blank')
    await page.getByRole('button', { name: 'Create' }).click()
    await page.getByRole('region', { name: 'Outline' }).waitFor()

    expect(await textOf(page)).toBe('labrun: 1\nname: blank\nsteps: []\n')

    const step = page.getByRole('region', { name: 'Step' })
    const add = async (words: string): Promise<void> => {
      await page.getByRole('button', { name: 'Add step' }).click()
      await page.getByRole('button', { name: words, exact: true }).click()
    }
    await add('For each')
    await step.getByLabel('To x').press('Control+a')
    await step.getByLabel('To x').pressSequentially('14,0', { delay: 80 })
    await page.keyboard.press('Tab')
    await expect.poll(() => step.getByLabel('To x').inputValue()).toBe('14.0 mm')
    await step.getByLabel('To x').fill('14')
    await page.keyboard.press('Tab')
    await step.getByLabel('Pitch').fill('4')
    await page.keyboard.press('Tab')
    await step.getByText('4 × 3 = 12 points; the last x is 12 mm; the last y is 8 mm').waitFor()
    await picture(page, 'building-grid')
    await step.getByLabel('Only inside').fill('${{ [] }}')
    await page.keyboard.press('Tab')
    await expect.poll(() => textOf(page)).toContain("order='snake'), []) }}")
    await page.getByRole('button', { name: 'Undo' }).click()
    await step.getByRole('radio', { name: 'Line' }).check()
    await expect.poll(() => textOf(page)).toContain('point: ${{ grid(x=linspace(0 mm, 14 mm, 11), y=[0 mm]) }}')
    await step.getByRole('radio', { name: 'Plate' }).check()
    await step.getByText('96 wells, 9 mm apart').waitFor()
    await step.getByRole('radio', { name: 'Table' }).check()
    const dropped = await page.evaluateHandle(() => {
      const data = new DataTransfer()
      data.items.add(new File(['place,x (mm),y (mm)\nA,1,2\nB,3,4\n'], 'places.csv', { type: 'text/csv' }))
      return data
    })
    await step.getByText('or drop it here').dispatchEvent('drop', { dataTransfer: dropped })
    await step.getByText('2 rows: place, x, y').waitFor()
    await picture(page, 'building-table')
    await sound(page)

    expect(await textOf(page)).toContain("point: ${{ csv('places.csv') }}")

    await row(page, /Move to/).click()

    expect(await step.getByRole('combobox', { name: 'Take Z from' }).getByRole('option').allInnerTexts()).toContain('x of the point')

    await row(page, /For each point/).click()
    for (let presses = 0; presses < 4; presses++) await page.getByRole('button', { name: 'Undo' }).click()
    await expect.poll(() => step.getByRole('radio', { name: 'Grid' }).isChecked()).toBe(true)
    await add('libs: measure')
    await add('libs: export')
    await step.getByRole('combobox', { name: 'Take Shot from' }).selectOption('shot id of Measure')
    await step.getByLabel('Attempts in total').fill('3')
    await page.keyboard.press('Tab')
    await step.getByLabel('Wait between').fill('2 s')
    await page.keyboard.press('Tab')
    await step.getByRole('radio', { name: 'it is left out' }).check()
    await step.getByLabel('May fail').fill('3')
    await page.keyboard.press('Tab')
    await picture(page, 'building-fails')
    await row(page, /For each of 12 points/).click()
    for (const column of ['x of the point', 'y of the point', 'file of Export']) await step.getByLabel('Add to: Keep as columns').selectOption(column)
    await page.getByRole('region', { name: 'Problems' }).getByRole('button', { name: 'Add libs.disarm at the end' }).click()
    await page.getByRole('status', { name: 'Check' }).filter({ hasText: 'no problems' }).waitFor()
    await picture(page, 'building-done')
    await page.getByRole('button', { name: 'Save' }).click()
    await page.getByText(/^saved /).waitFor()

    expect((await saved('blank.yaml')).text).toBe(`labrun: 1
name: blank
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - id: scan
    foreach:
      point: \${{ grid(x=span(0 mm, 14 mm, 4 mm, fit='inside'), y=span(0 mm, 10 mm, 4 mm, fit='inside'), order='snake') }}
    key: \${{ point.ix }},\${{ point.iy }}
    keep_going: {max_failed: 3}
    steps:
      - {do: gantry.move_to, with: {x: "\${{ point.x }}", y: "\${{ point.y }}"}}
      - id: measure
        do: libs.measure
      - id: export
        do: libs.export
        with:
          shot: \${{ steps.measure.shot_id }}
          file: export_\${{ point.ix }}_\${{ point.iy }}.csv
        retry: {attempts: 3, wait: 2 s}
    collect: {x: "\${{ point.x }}", y: "\${{ point.y }}", file: "\${{ steps.export.file }}"}

finally:
  - {do: libs.disarm, on_error: continue}
`)
    await page.getByRole('link', { name: 'Devices', exact: true }).click()
    await page.getByRole('region', { name: 'Device detail' }).getByRole('heading', { name: /^gantry/ }).waitFor()
    await page.goBack()
    await row(page, /For each of 12 points/).waitFor()

    expect(faults).toEqual([])

    await context.close()
  })

  it('takes the outline from a camera while the area is drawn, cuts off what is outside, and sees when the devices work', { tags: ['soak'] }, async () => {
    const { page, context, faults } = await aPerson(browser, bench.address, {}, { welcomed: true, name: 'Ada' })
    await ask(bench, '/protocols', { name: 'outlined.yaml', text: 'labrun: 1\nname: outlined\nsteps: []\n' })
    await page.goto('/devices/overview')
    await allOnline(page)
    await page.getByRole('button', { name: 'Take control' }).click()
    await page.getByText('calibrate', { exact: true }).click()
    const calibrate = page.getByRole('form', { name: 'calibrate' })
    await calibrate.getByLabel(/^x\b/).fill('100')
    await calibrate.getByLabel(/^y\b/).fill('300')
    await calibrate.getByRole('button', { name: 'Run' }).click()
    await calibrate.getByText(/rms/).waitFor()
    await open(page, 'outlined.yaml')
    await page.getByRole('button', { name: 'Add step' }).click()
    await page.getByRole('button', { name: 'For each', exact: true }).click()
    const form = page.getByRole('region', { name: 'Step' })
    await form.getByLabel('Pitch').fill('10')
    await page.keyboard.press('Tab')
    await form.getByRole('combobox', { name: 'Camera' }).selectOption('overview')
    await form.getByRole('button', { name: 'Take an outline' }).click()
    await form.getByText('Which one?').waitFor()

    expect(await axe(page)).toEqual([])

    await form.getByRole('button', { name: /mm at x 24 y 60/ }).click()
    await form.getByRole('button', { name: 'Add a point after it' }).click()
    await form.getByLabel('Its x in mm').press('Control+a')
    await page.keyboard.type('12,5')
    await page.keyboard.press('Enter')

    expect(await form.getByLabel('Its x in mm').inputValue()).toBe('12.5')
    expect(await axe(page)).toEqual([])

    await picture(page, 'outline-points')
    await form.getByRole('button', { name: 'Leave it out' }).click()
    await form.getByRole('button', { name: 'Use this outline' }).click()
    await expect.poll(() => textOf(page)).toContain("csv('outline.csv')")
    await page.getByRole('button', { name: 'Preview' }).click()
    await page.getByRole('button', { name: 'Cut them off' }).click()
    await sound(page)
    await page.getByRole('button', { name: 'Rehearse' }).click()
    await page.getByRole('table', { name: 'What each device does when' }).getByRole('row', { name: /gantry.move_to/ }).waitFor()
    await picture(page, 'building-outline')

    expect(await axe(page)).toEqual([])
    expect(await textOf(page)).toMatch(/inside\(grid\(x=span\(0 mm, \d+ mm, 10 mm.*, csv\('outline.csv'\)\)/)
    expect(faults).toEqual([])

    await releaseControl(page)
    await context.close()
  })

  it('takes the outline of a turned sample from three places of the gantry, and ends a drag at the edge of the picture', { tags: ['soak'] }, async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
    await ask(bench, '/protocols', { name: 'turned.yaml', text: 'labrun: 1\nname: turned\nsteps: []\n' })
    await page.goto('/devices/gantry')
    await allOnline(page)
    await page.getByRole('button', { name: 'Take control' }).click()
    const move = async (x: number, y: number): Promise<void> => {
      const form = page.getByRole('form', { name: 'move_to' })
      if (!(await form.isVisible())) await page.locator('summary', { hasText: 'move_to' }).click()
      await form.getByLabel('x', { exact: true }).fill(String(x))
      await form.getByLabel('y', { exact: true }).fill(String(y))
      await form.getByRole('button', { name: 'Run' }).click()
      await expect.poll(async () => (await ask<{ status: Record<string, unknown> }>(bench, '/devices/gantry')).status['y']).toBe(y)
    }
    await move(100, 100)
    await open(page, 'turned.yaml')
    await page.getByRole('button', { name: 'Add step' }).click()
    await page.getByRole('button', { name: 'For each', exact: true }).click()
    const form = page.getByRole('region', { name: 'Step' })
    for (const [x, y] of [[140, 110], [130, 150]] as const) {
      await form.getByRole('button', { name: /^Teach corner \d of 3$/ }).click()
      await form.getByRole('link', { name: 'gantry', exact: true }).click()
      await move(x, y)
      await page.goBack()
      await row(page, /For each/).click()
    }
    await form.getByText('Corner 1: x 100.00 y 100.00 mm · Corner 2: x 140.00 y 110.00 mm').waitFor()
    await form.getByRole('button', { name: 'Teach corner 3 of 3' }).click()
    await expect.poll(() => textOf(page)).toMatch(/csv\('outline(_\d+)?\.csv'\)/) // the camera's may be there
    await page.getByRole('button', { name: 'Preview' }).click()
    await sound(page)
    await picture(page, 'building-turned')

    expect(await axe(page)).toEqual([])

    await page.getByRole('button', { name: 'Draw the area' }).click()
    const sheet = page.getByRole('region', { name: 'Preview' }).getByRole('img')
    const box = await sheet.boundingBox()
    if (box === null) throw new Error('the preview has no box')
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2)
    await page.mouse.down()
    await page.mouse.move(box.x + box.width / 2 - 40, box.y + box.height + 4000, { steps: 4 })
    await page.mouse.up()
    await sound(page)

    expect(await textOf(page)).not.toMatch(/span\(-\d{4}/)
    expect(faults).toEqual([])

    await releaseControl(page)
    await context.close()
  })

  it('builds one by keys alone, at 1280 px with every line in view', async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, { viewport: { width: 1280, height: 800 } })
    await page.goto('/protocols')
    await page.getByRole('link', { name: 'hello.yaml' }).waitFor()
    await tabTo(page, /^New protocol$/)
    await page.keyboard.press('Enter')
    await page.getByRole('radio', { name: 'Empty' }).and(page.locator(':focus')).waitFor()
    await page.keyboard.press('Enter')
    await page.getByRole('region', { name: 'Outline' }).waitFor()
    await tabTo(page, /Add step/)
    for (const words of ['for each', 'measure']) {
      await page.keyboard.press(words === 'for each' ? 'Enter' : 'Insert')
      await page.getByRole('searchbox', { name: 'Search steps' }).and(page.locator(':focus')).waitFor()
      await page.keyboard.type(words)
      await page.keyboard.press('Enter')
      await page.getByRole('treegrid', { name: 'Steps' }).and(page.locator(':focus')).waitFor()
    }
    await page.keyboard.press('ArrowUp')
    await page.keyboard.press('ArrowUp')
    await page.getByRole('region', { name: 'Step' }).getByLabel('Pitch').waitFor()
    await page.keyboard.press('Enter')
    await tabTo(page, /^Pitch$/)
    await page.keyboard.press('Control+a')
    await page.keyboard.type('5')
    await page.keyboard.press('Enter')
    await expect.poll(() => textOf(page)).toContain('x=span(0 mm, 10 mm, 5 mm)')
    await sound(page)
    await picture(page, 'building-keys')

    expect(await page.locator('.cm-scroller').evaluate((one) => one.scrollWidth - one.clientWidth)).toBeLessThanOrEqual(0)

    expect(await textOf(page)).toMatch(/steps:\n +- \{do: gantry\.move_to, .*\n +- do: libs\.measure\n/)
    expect(faults).toEqual([])

    await context.close()
  })

  it('shows problems while one types, fixes one, and pauses the other views of a broken text', async () => {
    await copyOf('problems.yaml', 'hello.yaml')
    const { page, context } = await aPerson(browser, bench.entry)
    await open(page, 'problems.yaml')
    await sound(page)
    const editor = page.getByRole('textbox', { name: 'Protocol YAML' })
    await row(page, /Move to/).click()
    await editor.getByText('there', { exact: false }).last().click()
    await page.getByRole('region', { name: 'Step' }).getByLabel('X', { exact: true }).fill('900')
    await page.keyboard.press('Tab')
    const problems = page.getByRole('region', { name: 'Problems' })
    await problems.getByRole('button', { name: /900/ }).waitFor()
    await picture(page, 'editor-problem')

    expect(await page.getByRole('button', { name: 'Run', exact: true }).isDisabled()).toBe(true)

    await problems.getByRole('button', { name: 'Use 730 mm' }).click()
    await sound(page)
    await editor.click()
    await page.keyboard.press('Control+Home')
    await page.keyboard.type('oops: [')
    await page.getByText(/The text has an error on line \d+ – other views paused\./).waitFor()
    await picture(page, 'editor-broken')
    await page.keyboard.press('Control+z')
    await page.getByText('other views paused').waitFor({ state: 'detached' })
    await sound(page)
    await context.close()
  })

  it('completes actions and keys, and Esc then Tab leaves the text', async () => {
    await copyOf('complete.yaml', 'hello.yaml')
    const { page, context } = await aPerson(browser, bench.entry)
    await open(page, 'complete.yaml')
    await row(page, /Write to the log/).click()
    await page.getByRole('textbox', { name: 'Protocol YAML' }).focus()
    await page.keyboard.press('Tab')
    await page.keyboard.press('Shift+Tab')
    await page.keyboard.press('End')
    await page.keyboard.press('Enter')
    await page.keyboard.type('- do: gan')
    // The list takes no Enter while what was typed last is looked up, nor in its first 75 ms.
    const list = page.locator('.cm-tooltip-autocomplete:not(.cm-tooltip-autocomplete-disabled)')
    await list.getByRole('option', { name: /gantry\.home/ }).waitFor()
    await page.waitForTimeout(100)
    await picture(page, 'editor-complete')
    await page.keyboard.press('Enter')

    expect(await textOf(page)).toMatch(/- do: gantry\.\w+/)

    // What is written out is still offered: Enter ends the line, and a key without a value begins a block.
    await page.keyboard.press('Control+a')
    const lines = ['labrun: 1', 'name: complete', 'devices:', 'gantry: gantry@1', 'libs: libs_analyzer@1']
    for (const line of lines) {
      await page.keyboard.type(line, { delay: 80 })
      if (line.includes('@')) await list.getByRole('option', { name: line.split(' ')[1] ?? '' }).waitFor()
      await page.waitForTimeout(100)
      await page.keyboard.press('Enter')
    }

    expect((await textOf(page)).trimEnd()).toBe('labrun: 1\nname: complete\ndevices:\n  gantry: gantry@1\n  libs: libs_analyzer@1')

    await page.keyboard.press('Escape')
    await page.keyboard.press('Tab')

    expect(await page.evaluate(() => document.activeElement?.closest('.cm-editor') === null)).toBe(true)

    await context.close()
  })

  it('selects the same thing in text, outline and preview, and previews the points', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await open(page, 'pegmatite_map.yaml')
    await row(page, /For each of 1,071 points/).waitFor()
    await page.getByRole('button', { name: 'Preview', exact: true }).click()
    const preview = page.getByRole('region', { name: 'Preview' })
    await preview.getByText('1,071 · 4.0 × 10.0 mm').waitFor()
    await preview.getByRole('img').click({ position: { x: 200, y: 100 } })
    await row(page, /For each of/).and(page.locator('[aria-selected=true]')).waitFor()
    await picture(page, 'editor-preview')
    await preview.getByRole('button', { name: 'Show as table' }).click()
    await preview.getByRole('cell', { name: '1', exact: true }).first().waitFor()
    await page.getByRole('tab', { name: 'Words' }).click()
    await page.getByText(/At each of 1,071 points/).waitFor()
    await picture(page, 'editor-words')
    await context.close()
  })

  it('moves and stretches the grid in the preview, as parameters of the text', async () => {
    await copyOf('grid.yaml', 'pegmatite_map.yaml')
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await open(page, 'grid.yaml')
    await page.getByRole('button', { name: 'Preview', exact: true }).click()
    const preview = page.getByRole('region', { name: 'Preview' })
    await preview.getByText('1,071 · 4.0 × 10.0 mm').waitFor()
    await preview.getByLabel('Width', { exact: true }).fill('2')
    await page.keyboard.press('Tab')
    await preview.getByText('561 · 2.0 × 10.0 mm').waitFor()
    const canvas = preview.getByRole('img')
    await canvas.scrollIntoViewIfNeeded()
    const box = await canvas.boundingBox()
    if (!box) throw new Error('the picture has no place')
    const scale = (280 - 68) / 10
    const [left, bottom] = [box.x + (box.width - 2 * scale) / 2, box.y + 280 - 34]
    await page.mouse.move(left + 2 * scale, bottom - 10 * scale)
    await page.mouse.down()
    await page.mouse.move(left + 3 * scale, bottom - 6 * scale, { steps: 4 })
    await picture(page, 'editor-grid')
    await page.mouse.up()
    await expect.poll(() => textOf(page)).toMatch(/height: +\{type: quantity, unit: mm, default: 6 mm/)
    await page.getByRole('button', { name: 'Undo' }).click()

    expect(await textOf(page)).toMatch(/width: +\{type: quantity, unit: mm, default: 2 mm/)
    expect(await textOf(page)).toMatch(/height: +\{type: quantity, unit: mm, default: 10 mm/)
    expect(faults).toEqual([])

    await context.close()
  })

  it('draws the area of a loop on the bench, sees at once what lies beyond, and cuts it off', async () => {
    const steps = "  - foreach:\n      point: ${{ grid(x=span(0 mm, 40 mm, 20 mm), y=span(0 mm, 40 mm, 20 mm)) }}\n    steps:\n      - {do: gantry.move_to, with: {x: \"${{ point.x }}\", y: \"${{ point.y }}\"}}\n"
    await ask(bench, '/protocols', { name: 'drawn.yaml', text: `labrun: 1\nname: drawn\ndevices: {gantry: gantry@1}\nsteps:\n${steps}` })
    const { page, context, faults } = await aPerson(browser, bench.entry)
    await open(page, 'drawn.yaml')
    await row(page, /For each/).click()
    await page.getByRole('button', { name: 'Draw on the bench' }).click()
    const preview = page.getByRole('region', { name: 'Preview' })
    await preview.getByText('Drag over the picture').waitFor()
    const canvas = preview.getByRole('img')
    const box = await canvas.boundingBox()
    if (!box) throw new Error('the picture has no place')
    const scale = (280 - 68) / 810
    const at = (x: number, y: number): [number, number] => [box.x + (box.width - 730 * scale) / 2 + x * scale, box.y + 280 - 34 - y * scale]
    await page.mouse.move(...at(500, 100))
    await page.mouse.down()
    await page.mouse.move(...at(820, 300), { steps: 5 })
    await preview.getByText('✕ beyond the work area').waitFor()
    await picture(page, 'editor-drawing')
    await page.mouse.up()
    await preview.getByText(/points are outside the work area/).waitFor()
    await picture(page, 'editor-drawn')
    await preview.getByRole('button', { name: 'Cut them off' }).click()
    await preview.getByText(/points are outside the work area/).waitFor({ state: 'detached' })
    await preview.getByRole('button', { name: 'Photograph' }).click()
    await preview.getByRole('alert').getByText('position is unknown: calibrate it').waitFor()
    await sound(page)

    const [, x0, x1, y0, y1] = /x=span\((\d+) mm, (\d+) mm, 20 mm.*y=span\((\d+) mm, (\d+) mm, 20 mm/.exec(await textOf(page)) ?? []
    expect([Number(x0), Number(x1)].map((mm) => Math.floor(mm / 20))).toEqual([25, 36])
    expect([Number(y0), Number(y1)].map((mm) => Math.round(mm / 20))).toEqual([5, 15])
    expect(Number(x1)).toBeLessThanOrEqual(730)
    expect(faults).toEqual([])

    await context.close()
  })

  it('rehearses with simulated devices, and explains', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await open(page, 'hello.yaml')
    await page.getByRole('button', { name: 'Preview', exact: true }).click()
    const preview = page.getByRole('region', { name: 'Preview' })
    await preview.getByRole('button', { name: 'Rehearse' }).click()
    await preview.getByText(/Rehearsed: succeeded/).waitFor()
    await preview.getByRole('button', { name: 'Explain' }).click()
    await preview.getByLabel('Explanation').getByText(/gantry\.home/).first().waitFor()
    await picture(page, 'editor-rehearsed')
    await context.close()
  })

  it('merges the changes of two people who both saved', async () => {
    await copyOf('shared.yaml', 'hello.yaml')
    const { page, context } = await aPerson(browser, bench.entry)
    await open(page, 'shared.yaml')
    await sound(page)
    await row(page, /hello Three/).click()
    await page.getByRole('region', { name: 'Step' }).getByLabel('Summary').fill('Mine')
    await page.keyboard.press('Tab')
    await expect.poll(() => textOf(page)).toContain('summary: Mine')
    const there = await saved('shared.yaml')
    const theirs = there.text.replace('y: 1 cm', 'y: 3 cm')
    await fetch(`${bench.address}/api/v1/protocols/shared.yaml`, {
      method: 'PUT', headers: { ...(await letIn(bench)), 'content-type': 'application/json' }, body: JSON.stringify({ text: theirs, base: there.revision }),
    })
    await page.getByText(/^changed by others/).waitFor() // as soon as it is so, and not at the next save
    await page.getByRole('button', { name: 'Merge…' }).waitFor()
    await page.getByRole('button', { name: 'Save' }).click()
    await page.getByRole('heading', { name: 'Someone else has saved this protocol' }).waitFor()
    await picture(page, 'editor-conflict')

    expect(await axe(page)).toEqual([])

    await page.getByRole('button', { name: 'Merge both' }).click()
    await page.getByText(/^saved /).waitFor()
    const { text } = await saved('shared.yaml')

    expect(text).toContain('summary: Mine')
    expect(text).toContain('y: 3 cm')

    await context.close()
  })

  it('keeps a draft over a way back in mid-word and a reload, and restores it', async () => {
    await copyOf('draft.yaml', 'hello.yaml')
    const { page, context } = await aPerson(browser, bench.entry)
    await open(page, 'draft.yaml')
    await row(page, /hello Three/).click()
    await page.getByRole('region', { name: 'Step' }).getByLabel('Summary').fill('Not saved yet')
    await page.goBack()
    await page.getByRole('link', { name: 'draft.yaml', exact: true }).click()
    await page.getByText('● unsaved').waitFor()
    await open(page, 'draft.yaml')
    await page.getByText('● unsaved').waitFor()

    expect(await textOf(page)).toContain('summary: Not saved yet')

    await page.getByRole('button', { name: 'Discard' }).click()

    expect(await textOf(page)).toBe((await saved('draft.yaml')).text)

    await context.close()
  })

  it('takes a step that was done by hand, after the row where it was left', async () => {
    await copyOf('byhand.yaml', 'hello.yaml')
    const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, name: 'Ada' })
    await open(page, 'byhand.yaml')
    await row(page, /Move to/).click()
    await page.goto('/devices/gantry')
    await allOnline(page)
    await page.getByRole('button', { name: 'Take control' }).click()
    await page.getByRole('button', { name: 'Release control' }).waitFor()
    const device = page.getByRole('region', { name: 'Device detail' })
    await device.locator('summary', { hasText: 'move_to' }).click()
    const form = page.getByRole('form', { name: 'move_to' })
    await form.getByLabel('x', { exact: true }).fill('33')
    await form.getByRole('button', { name: 'Run' }).click()
    await form.getByRole('button', { name: 'Add to protocol' }).click()
    await page.getByText('will go after “Move to” into byhand.yaml').first().waitFor()
    await open(page, 'byhand.yaml')
    await page.getByText('1 step was added.').waitFor()

    expect(await textOf(page)).toMatch(/retry: 3\n\n? {2}- do: gantry\.move_to\n {4}with: \{x: 33\}|retry: 3\n\n? {2}- \{do: gantry\.move_to, with: \{x: 33\}\}/)
    expect(faults).toEqual([])

    await releaseControl(page)
    await context.close()
  })

  it('is edited with a mouse at 200 %, and read on a phone', { tags: ['soak'] }, async () => {
    const { page, context, faults } = await aPerson(browser, bench.entry, { viewport: { width: 640, height: 430 } })
    await open(page, 'pegmatite_map.yaml')
    await row(page, /Measure/).click()
    await page.getByRole('region', { name: 'Step' }).getByRole('textbox', { name: 'Note' }).fill('at the focus')
    await page.keyboard.press('Tab')
    await page.getByRole('button', { name: 'Undo' }).click()
    await page.getByRole('button', { name: 'Preview' }).click()
    await expect.poll(async () => (await page.getByRole('region', { name: 'Preview' }).boundingBox())?.y).toBeLessThan(300)
    await picture(page, 'editor-zoomed')

    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(640)
    expect(faults).toEqual([])

    await context.close()
    const phone = await aPerson(browser, bench.entry, { viewport: NARROW, hasTouch: true, isMobile: true })
    await open(phone.page, 'pegmatite_map.yaml')
    await phone.page.getByText('On a phone a protocol is read-only').waitFor()
    await phone.context.close()
  })

  it('opens a used protocol in place, and goes to the launch form', async () => {
    const { page, context } = await aPerson(browser, bench.entry)
    await open(page, 'multi_sample.yaml')
    await row(page, /Use scan_core\.yaml/).click()
    await page.keyboard.press('ArrowRight')
    await row(page, /Measure.*in scan_core\.yaml/).waitFor()
    await picture(page, 'editor-used')
    await page.getByRole('button', { name: 'Run', exact: true }).click()
    await page.waitForURL('**/runs?start=multi_sample.yaml')
    await context.close()
  })

  for (const theme of ['light', 'dark'] as const) {
    it(`has nothing that axe finds, in ${theme}, wide and narrow`, { tags: theme === 'dark' ? ['soak'] : [] }, async () => {
      const { page, context, faults } = await aPerson(browser, bench.entry, {}, { welcomed: true, theme })
      await page.goto('/protocols')
      await page.getByRole('link', { name: 'pegmatite_map.yaml' }).waitFor()

      expect(await axe(page)).toEqual([])

      await picture(page, `protocols-${theme}`)
      await open(page, 'pegmatite_map.yaml')
      await row(page, /For each of 1,071 points/).waitFor()
      await row(page, /Measure/).click()
      await page.getByRole('button', { name: 'Preview', exact: true }).click()
      await page.getByRole('region', { name: 'Preview' }).getByText('1,071 · 4.0').waitFor()
      await picture(page, `editor-${theme}`)

      expect(await axe(page)).toEqual([])

      await row(page, /For each of 1,071 points/).click()
      await page.getByRole('region', { name: 'Step' }).getByRole('radio', { name: 'Grid' }).waitFor()
      await picture(page, `editor-loop-${theme}`)

      expect(await axe(page)).toEqual([])

      for (const view of ['Outline', 'Words', 'YAML']) {
        await page.getByRole('tab', { name: view, exact: true }).click()
        await page.waitForTimeout(300)

        expect(await axe(page)).toEqual([])
      }
      await page.getByRole('tab', { name: 'Outline' }).click()
      await page.setViewportSize(NARROW)
      await page.getByRole('button', { name: 'Add step' }).and(page.locator(':enabled')).waitFor()
      await picture(page, `editor-narrow-${theme}`)

      expect(await axe(page)).toEqual([])
      expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(390)

      await page.goto('/protocols')
      await page.getByRole('link', { name: 'pegmatite_map.yaml' }).waitFor()
      await picture(page, `protocols-narrow-${theme}`)

      expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(390)
      expect(faults).toEqual([])

      await context.close()
    })
  }
})
