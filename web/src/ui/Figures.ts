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

/** The cells of a table that is copied stay cells. */
function copied(event: ClipboardEvent): void {
  const selection = getSelection()
  if (!selection?.rangeCount) return
  const range = selection.getRangeAt(0)
  const within = range.commonAncestorContainer.parentElement?.closest<HTMLElement>(FULL)
  const part = range.cloneContents()
  const short = [...part.querySelectorAll<HTMLElement>(FULL)]
  if (within && selection.toString() !== within.textContent) return
  if (!within && !short.length) return
  for (const one of short) one.textContent = one.dataset['full'] ?? ''
  const rows = [...part.querySelectorAll('tr')].map((row) => [...row.cells].map((cell) => cell.textContent.trim()).join('\t'))
  event.clipboardData?.setData('text/plain', within?.dataset['full'] ?? (rows.join('\n') || part.textContent || ''))
  event.preventDefault()
}
document.addEventListener('copy', copied)
