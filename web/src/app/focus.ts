// Keeps the focus: what had it may be removed, or cannot be used for a moment, and the next key would go nowhere.

const FOCUSABLE = 'a[href], button, input, select, textarea, summary, [tabindex="0"]'

/** Where nothing is chosen yet, keys open the list; browsers would take its first entry at once, and then the second. */
function openList(event: KeyboardEvent): void {
  const list = event.target
  if (!(list instanceof HTMLSelectElement) || list.value !== '' || event.ctrlKey || event.altKey || event.metaKey) return
  if (!/^(ArrowUp|ArrowDown|\S)$/.test(event.key)) return
  event.preventDefault()
  list.showPicker()
}

/** Begin; returns the function that ends it. */
export function keepFocus(): () => void {
  let last: HTMLElement | null = null
  /** Where it stood: its parents within the page or the dialog, and which of their children it was in. */
  let stood: { parent: Element; index: number }[] = []

  function focused({ target }: FocusEvent): void {
    if (!(target instanceof HTMLElement)) return
    last = target
    stood = []
    for (let at: Element = target; at.parentElement !== null && !at.parentElement.matches('#main, body'); at = at.parentElement)
      stood.push({ parent: at.parentElement, index: [...at.parentElement.children].indexOf(at) })
  }

  function look(): void {
    if (last === null || document.activeElement !== document.body) return
    if (last.isConnected) return last.focus({ preventScroll: true }) // in vain while it is disabled
    for (const { parent, index } of stood) {
      if (!parent.isConnected) continue
      const here = parent.children[Math.min(index, parent.children.length - 1)]
      const next = here === undefined ? [] : [here, ...here.querySelectorAll(FOCUSABLE), ...parent.querySelectorAll(FOCUSABLE)]
      const to = next.find((one): one is HTMLElement => one instanceof HTMLElement && one.matches(FOCUSABLE) && !one.matches(':disabled, .unseen'))
      if (to !== undefined) return to.focus({ preventScroll: true })
    }
  }

  /** A click beside everything takes it away on purpose. */
  const pressed = (): void => void (last = null)
  const watching = new MutationObserver(look)
  watching.observe(document.body, { subtree: true, childList: true, attributeFilter: ['disabled'] })
  document.addEventListener('focusin', focused)
  document.addEventListener('pointerdown', pressed, true)
  document.addEventListener('keydown', openList)
  return () => {
    watching.disconnect()
    document.removeEventListener('focusin', focused)
    document.removeEventListener('pointerdown', pressed, true)
    document.removeEventListener('keydown', openList)
  }
}
