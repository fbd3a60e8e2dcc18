// What is copied has all the digits of what was read, from a table, a card or a sentence.
import { expect, test } from 'vitest'
import './Figures'

/** What a person gets who selects from one element to another and copies. */
function copiedFrom(html: string, first: string, last = first): string | null {
  document.body.innerHTML = html
  const [start, end] = [document.querySelector(first), document.querySelector(last)]
  if (!start || !end) throw new Error('nothing to select')
  const range = document.createRange()
  range.setStart(start.firstChild ?? start, 0)
  range.setEnd(end.lastChild ?? end, end.lastChild?.textContent?.length ?? 0)
  getSelection()?.removeAllRanges()
  getSelection()?.addRange(range)
  let text: string | null = null
  document.dispatchEvent(Object.assign(new Event('copy', { cancelable: true }), { clipboardData: { setData: (_: string, given: string) => (text = given) } }))
  return text
}

const TABLE = '<table><tr><th>lithium</th><td id="a" data-full="0.123456789">0.123457</td><td id="b">2</td></tr></table>'
const CARD = '<dl><dt id="a">area</dt><dd data-full="1704.6123456">1704.61</dd><dt>note</dt><dd id="b">none</dd></dl>'
const SENTENCE = '<p>Kept: <span id="a" data-full="mass = 1.23456789 mg">mass = 1.23457 mg</span></p>'

test('copied numbers have all their digits, and what stood below each other still does', () => {
  expect(copiedFrom(TABLE, 'th', '#b')).toBe('lithium\t0.123456789\t2')
  expect(copiedFrom(TABLE, '#a')).toBe('0.123456789')
  expect(copiedFrom(CARD, '#a', '#b')?.split(/\s*\n\s*/)).toEqual(['area', '1704.6123456', 'note', 'none'])
  expect(copiedFrom(SENTENCE, '#a')).toBe('mass = 1.23456789 mg')
  expect(copiedFrom(TABLE, '#b')).toBe(null)
})
