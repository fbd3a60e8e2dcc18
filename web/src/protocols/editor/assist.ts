// Search, completion and hover: loaded after the text is on the screen.
import { autocompletion, closeBrackets, closeBracketsKeymap, closeCompletion, completionKeymap, selectedCompletion } from '@codemirror/autocomplete'
import { highlightSelectionMatches, search, searchKeymap } from '@codemirror/search'
import { Prec, type Extension } from '@codemirror/state'
import { keymap, type EditorView } from '@codemirror/view'
import type { Read } from '../text/reading'
import { completionFor } from './completion'
import type { Contracts } from './contracts'
import { hoverFor } from './hover'

/** Enter after a word that is already written out ends the line, as it does elsewhere. */
function writtenOut(view: EditorView): boolean {
  const option = selectedCompletion(view.state)
  const { head } = view.state.selection.main
  const word = typeof option?.apply === 'string' ? option.apply : (option?.label ?? '')
  if (option && view.state.sliceDoc(Math.max(0, head - word.length), head) === word) closeCompletion(view)
  return false
}

export function assist(good: () => Read | null, contracts: Contracts): Extension {
  return [
    Prec.highest(keymap.of([{ key: 'Enter', run: writtenOut }])), search({ top: true }), highlightSelectionMatches(), closeBrackets(), autocompletion({ icons: false }),
    completionFor(() => good()?.data, contracts), hoverFor(good, contracts),
    Prec.high(keymap.of([...closeBracketsKeymap, ...completionKeymap, ...searchKeymap])),
  ]
}
