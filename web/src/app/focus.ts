// Keeps the focus: what had it may be removed, or cannot be used for a moment, and the next key would go nowhere.

const FOCUSABLE = 'a[href], button, input, select, textarea, summary, [tabindex="0"]'
const DIALOG = '[role=dialog]'

/** Where nothing is chosen yet, keys open the list; browsers would take its first entry at once, and then the second. */
function openList(event: KeyboardEvent): void {
  const list = event.target
  if (!(list instanceof HTMLSelectElement) || list.value !== '' || event.ctrlKey || event.altKey || event.metaKey) return
  if (!/^(ArrowUp|ArrowDown|\S)$/.test(event.key)) return
  event.preventDefault()
  list.showPicker()
}

interface Place {
  at: HTMLElement
  /** Its parents within the page or the dialog, and which of their children it was in. */
  stood: { parent: Element; index: number }[]
}

/** Go back there, or to what stands there now; false if nothing does. */
function goBack({ at, stood }: Place): boolean {
  at.focus({ preventScroll: true }) // in vain while it is disabled
  if (at.isConnected) return true
  for (const { parent, index } of stood) {
    if (!parent.isConnected) continue
    const here = parent.children[Math.min(index, parent.children.length - 1)]
    const next = here === undefined ? [] : [here, ...here.querySelectorAll(FOCUSABLE), ...parent.querySelectorAll(FOCUSABLE)]
    const to = next.find((one): one is HTMLElement => one instanceof HTMLElement && one.matches(FOCUSABLE) && !one.matches(':disabled, .unseen'))
    if (to === undefined) continue
    to.focus({ preventScroll: true })
    return true
  }
  return false
}

/** Begin; returns the function that ends it. */
export function keepFocus(): () => void {
  let inPage: Place | null = null
  let inDialog: Place | null = null

  function focused({ target }: FocusEvent): void {
    if (!(target instanceof HTMLElement)) return
    // Who works by mouse does not look for it: a space bar is to scroll, and not to press what is there now.
    if (!target.matches(':focus-visible')) return forget(target)
    const stood: Place['stood'] = []
    for (let at: Element = target; at.parentElement !== null && !at.parentElement.matches('#main, body'); at = at.parentElement)
      stood.push({ parent: at.parentElement, index: [...at.parentElement.children].indexOf(at) })
    const place = { at: target, stood }
    if (target.closest(DIALOG) !== null) inDialog = place
    else [inPage, inDialog] = [place, null]
  }

  function look(): void {
    if (document.activeElement !== document.body || (inDialog !== null && goBack(inDialog))) return
    if (inPage !== null && document.querySelector(DIALOG) === null) goBack(inPage)
  }

  function forget(target: EventTarget | null): void {
    inDialog = null
    if (target instanceof Element && target.closest(DIALOG) === null) inPage = null
  }
  /** A click beside everything takes it away on purpose. */
  const pressed = ({ target }: Event): void => { forget(target) }
  // Not at once: while the focus goes from one to the other the page has it, and what a `blur` changes would call it back.
  const watching = new MutationObserver(() => setTimeout(look))
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
