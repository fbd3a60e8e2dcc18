// A number in a table or on a card: the digits that a person reads, with all of them on hover and in what is copied.
import { h, type FunctionalComponent } from 'vue'
import { exact, figures } from './format'

/** `full`: all of its digits, where they are not those of a double. */
export const Figures: FunctionalComponent<{ of: number; error?: number | undefined; full?: string }> = ({ of, error, full = exact(of) }) => {
  const short = figures(of, error)
  return short === full ? short : h('span', { title: full, 'data-full': full }, short)
}
Figures.props = ['of', 'error', 'full']

const FULL = '[data-full]'

/** As it would be read: blocks below each other. */
function textOf(part: DocumentFragment): string {
  const sheet = document.createElement('div')
  sheet.style.position = 'fixed'
  sheet.style.left = '-9999px'
  sheet.append(part)
  document.body.append(sheet)
  const text = sheet.innerText
  sheet.remove()
  return text
}

/** The cells of a table that is copied stay cells. */
function copied(event: ClipboardEvent): void {
  const selection = getSelection()
  if (!selection?.rangeCount) return
  const range = selection.getRangeAt(0)
  const within = range.commonAncestorContainer.parentElement?.closest<HTMLElement>(FULL)
  const part = range.cloneContents()
  const short = [...part.querySelectorAll<HTMLElement>(FULL)]
  if (within && selection.toString().trim() !== within.textContent.trim()) return
  if (!within && !short.length) return
  for (const one of short) one.textContent = one.dataset['full'] ?? ''
  const own = [...part.children].filter((one) => one.matches('td, th')) // of one row, which does not come along
  const rows = (own.length ? [own] : [...part.querySelectorAll('tr')].map((row) => [...row.cells])).map((cells) => cells.map((cell) => cell.textContent.trim()).join('\t'))
  event.clipboardData?.setData('text/plain', within?.dataset['full'] ?? (rows.join('\n') || textOf(part)))
  event.preventDefault()
}
document.addEventListener('copy', copied)
